"""Chains of a MoveIt SRDF file: which frames a planning group goes from and to."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from srs_ik.errors import InvalidRobot, did_you_mean, listed
from srs_ik.robot.description import document
from srs_ik.robot.description.files import read
from srs_ik.robot.description.model import is_xml

_KEPT: Mapping[str, frozenset[str]] = {"robot": frozenset({"group"}), "group": frozenset({"chain"})}

_PAIRS: Mapping[str, frozenset[str]] = {"robot": frozenset({"disable_collisions"})}


def chains(source: str | Path) -> dict[str, tuple[str, str]]:
    """Base and tip frame of every group that is given as one chain in an SRDF file, by path or text.

    Raises:
        InvalidRobot: the file is missing or no SRDF.
    """
    text, label = _text(source)
    found = {}
    for group in document.parse(text, label, _KEPT).findall("group"):
        inside = group.findall("chain")
        # A group of two chains is two arms.
        if len(inside) != 1 or not group.get("name"):
            continue
        (chain,) = inside
        base, tip = chain.get("base_link"), chain.get("tip_link")
        if not base or not tip:
            raise InvalidRobot(f"{label}: the chain of group {group.get('name')!r} lacks base_link or tip_link", label)
        found[group.attrib["name"]] = (base, tip)
    return found


def disabled_pairs(source: str | Path) -> dict[frozenset[str], str]:
    """Pairs of links that an SRDF file, by path or text, says need not be watched for collisions, and why.

    Raises:
        InvalidRobot: the file is missing or no SRDF.
    """
    text, label = _text(source)
    pairs = document.parse(text, label, _PAIRS).findall("disable_collisions")
    return {frozenset((pair.get("link1", ""), pair.get("link2", ""))): pair.get("reason", "disabled") for pair in pairs}


def _text(source: str | Path) -> tuple[str | bytes, str]:
    """An SRDF file, or the text of one, and how messages call it."""
    if isinstance(source, str) and is_xml(source):
        return source, "the SRDF text"
    return read(Path(source), str(source)), str(source)


def chain_of(source: str | Path, group: str | None) -> tuple[str, str]:
    """Base and tip frame of one group, of the only one where none is named.

    Raises:
        InvalidRobot: the file is missing or no SRDF, has no such group, or several and none is named.
    """
    found = chains(source)
    names = list(found)
    label = "the SRDF" if isinstance(source, str) and is_xml(source) else str(source)
    if not names:
        raise InvalidRobot(f"{label} has no group that is given as a chain; name base and tip instead", label)
    if group is None:
        if len(names) > 1:
            raise InvalidRobot(f"{label} has several chains, name one of them as the limb: {listed(names)}", label)
        group = names[0]
    if group not in found:
        hint = did_you_mean(group, names)
        raise InvalidRobot(f"{label} has no chain {group!r}{hint}; its chains are {listed(names)}", label)
    return found[group]
