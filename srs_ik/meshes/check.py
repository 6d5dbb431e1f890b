"""What a mesh file asks for, before its reader does as it is told: a few bytes can ask for gigabytes."""

from __future__ import annotations

import io
import json
import re
import struct
from xml.etree import ElementTree

from srs_ik.meshes import bounds

_SHOWING = ("instance_geometry", "instance_controller")
_DEEPEST = 200
_ENCODINGS = (b"utf-8", b"us-ascii", b"ascii", b"iso-8859-1")


class Beyond(Exception):
    """More than is read; the message is the end of a sentence about the file."""


def check(content: bytes, kind: str) -> bool:
    """Make sure that a mesh file, once read, is not much larger than its bytes; whether it holds pictures.

    These are to be left alone. `kind` is its ending, in lower case; files of the other kinds cannot say one thing
    twice.

    Raises:
        Beyond: it has too many pieces or numbers.
    """
    if kind == ".dae":
        _check_pieces(_collada_pieces(content))
    if kind in (".glb", ".gltf"):
        header = json.loads(_glb_header(content) if kind == ".glb" else content)
        _check_pieces(len(header.get("nodes", ())))
        # Numbers that are in no file are zeros, as many as are asked for.
        numbers = sum(accessor["count"] for accessor in header.get("accessors", ()))
        if numbers > 3 * bounds.TRIANGLES:
            raise Beyond(f"holds {numbers} points and indices, more than the {3 * bounds.TRIANGLES} that are read")
        return bool(header.get("images"))
    return False


def _check_pieces(count: float) -> None:
    if count > bounds.PIECES:
        raise Beyond(
            f"shows its parts {'over and over' if count > 1e9 else f'{count:.0f} times'}; {bounds.PIECES} are read"
        )


def _glb_header(content: bytes) -> bytes:
    (length,) = struct.unpack_from("<I", content, 12)
    return content[20 : 20 + length]


class _Node:
    """A node of a Collada file: how many pieces it shows itself, and the names of the nodes that it shows again."""

    def __init__(self) -> None:
        self.own = 0
        self.again: list[str] = []


def _collada_pieces(content: bytes) -> float:
    """How many pieces the nodes of a Collada file show, those that are shown again counted again."""
    _check_plain(content)
    everything, open_nodes, named = _Node(), [], {}  # type: _Node, list[_Node], dict[str, _Node]
    for event, element in ElementTree.iterparse(io.BytesIO(content), events=("start", "end")):
        tag = element.tag.rpartition("}")[2]
        if event == "end":
            if tag == "node":
                open_nodes.pop()
            element.clear()
        elif tag == "node":
            open_nodes.append(node := _Node())
            if len(open_nodes) > _DEEPEST:
                raise Beyond(f"has nodes in nodes, more than {_DEEPEST} deep")
            named.setdefault(element.get("id", ""), node)
        elif tag in _SHOWING:
            for node in (everything, *open_nodes):
                node.own += 1
        elif tag == "instance_node":
            for node in (everything, *open_nodes):
                node.again.append(element.get("url", "").removeprefix("#"))
    totals: dict[str, float] = {}
    return everything.own + sum(_total(name, named, totals) for name in everything.again)


def _check_plain(content: bytes) -> None:
    """Make sure that an XML file holds no entities, which can stand for other files or for gigabytes."""
    head = content.removeprefix(b"\xef\xbb\xbf")[:200]
    declared = re.match(rb"""<\?xml[^>]*encoding\s*=\s*["']([^"']*)""", head)
    if b"\0" in head or (declared and declared[1].lower() not in _ENCODINGS):
        raise Beyond("is not written in UTF-8")
    if b"<!DOCTYPE" in content:
        raise Beyond("has a DOCTYPE, which no mesh needs")


def _total(name: str, named: dict[str, _Node], totals: dict[str, float]) -> float:
    """Pieces of a named node; without end if it shows itself."""
    if name not in totals:
        totals[name] = float("inf")
        node = named.get(name, _Node())
        totals[name] = node.own + sum(_total(other, named, totals) for other in node.again)
    return totals[name]
