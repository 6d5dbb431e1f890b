"""URDF text to the few elements that motion and mass depend on: links with inertia, joints with their figures.

Visuals, collisions, materials, transmissions, simulator tags and whatever else a file holds are skipped while reading,
so missing meshes and faulty tags among them do no harm, and a large file stays small in memory.
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from typing import Any
from xml.etree.ElementTree import Element
from xml.parsers import expat

from srs_ik.errors import InvalidRobot

MAX_BYTES = 8 * 2**20
"""Largest text that is read. Descriptions of whole humanoids have a few hundred kilobytes."""

MAX_ELEMENTS = 200_000
"""Most elements that are read, skipped ones included; a humanoid with hands has a few thousand."""

MAX_DEPTH = 1000
"""Deepest nesting of elements, which some parsers follow by recursion: bodies of an MJCF file nest, links do not."""

Kept = Mapping[str, frozenset[str]]
"""Elements that are kept inside each element."""

KEPT: Kept = {
    "robot": frozenset({"link", "joint"}),
    "link": frozenset({"inertial"}),
    "inertial": frozenset({"origin", "mass", "inertia"}),
    "joint": frozenset({"parent", "child", "origin", "axis", "limit", "dynamics", "mimic"}),
}
"""What motion and mass depend on; of several elements where one is meant, the first counts."""

_SEVERAL = frozenset({"link", "joint", "group", "material", "visual", "collision"})


def parse(text: str | bytes, source: str, kept: Kept = KEPT) -> Element:
    """Read URDF text.

    Args:
        text: the XML; bytes are decoded as its own declaration says.
        source: what error messages call it.
        kept: elements that are kept inside each element; others are for files that are like a URDF.

    Returns:
        The element ``<robot>`` with these elements in it, unchecked.

    Raises:
        InvalidRobot: the text is empty, too large or of too many elements, no well-formed XML, no URDF, an unexpanded
            xacro file, or has a document type declaration (which is where entities that expand without end are
            defined).
    """
    # Blank lines before the XML declaration are an error by the letter, and common in strings of programs.
    text = text.lstrip("\ufeff \t\r\n") if isinstance(text, str) else text.lstrip()
    if not text:
        raise InvalidRobot(f"{source} is empty", source)
    check_size(text, source)
    reader = _Reader(source, kept)
    run(reader, text, source)
    if reader.root is None:
        raise InvalidRobot(f"{source} has no <robot> element", source)
    return reader.root


def root_tag(text: bytes) -> str:
    """Tag of the outermost element of an XML text; "" where it does not begin with one."""
    found: list[str] = []
    parser = expat.ParserCreate()

    def start(tag: str, attributes: dict[str, str]) -> None:
        found.append(tag)
        raise StopIteration

    parser.StartElementHandler = start
    with contextlib.suppress(StopIteration, expat.ExpatError, LookupError, ValueError):
        parser.Parse(text.lstrip()[:MAX_BYTES], True)
    return found[0] if found else ""


def check_size(text: str | bytes, source: str) -> None:
    """Refuse a text that is too large.

    Raises:
        InvalidRobot: it is.
    """
    if len(text) > MAX_BYTES:
        raise InvalidRobot(f"{source} is larger than {MAX_BYTES // 2**20} MiB, too large for a robot", source)


def run(handler: Guardian, text: str | bytes, source: str) -> None:
    """Parse a text for its events.

    Raises:
        InvalidRobot: it is not well-formed, or the handler refuses it.
    """
    # Without namespace processing, as other URDF readers do: files with undeclared prefixes in skipped tags are common.
    parser = expat.ParserCreate()
    parser.StartElementHandler = handler.start
    parser.EndElementHandler = handler.end
    parser.StartDoctypeDeclHandler = handler.doctype
    try:
        parser.Parse(text, True)
    except (expat.ExpatError, LookupError, ValueError) as error:
        raise InvalidRobot(f"{source} is not well-formed XML: {error}", source) from None


class Guardian:
    """Bounds the elements of a text and their depth while it is parsed.

    Args:
        source: what error messages call the text.
    """

    def __init__(self, source: str) -> None:
        self.source = source
        self._count = 0
        self._depth = 0

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        """An element begins.

        Raises:
            InvalidRobot: it is one too many, or too deep.
        """
        self._count += 1
        self._depth += 1
        if self._count > MAX_ELEMENTS:
            message = f"{self.source} has more than {MAX_ELEMENTS} XML elements, too many for a robot"
            raise InvalidRobot(message, self.source)
        if self._depth > MAX_DEPTH:
            message = f"{self.source} has XML elements nested more than {MAX_DEPTH} deep, too deep for a robot"
            raise InvalidRobot(message, self.source)

    def end(self, tag: str) -> None:
        """An element ends."""
        self._depth -= 1

    def doctype(self, *declaration: Any) -> None:
        """A document type is declared.

        Raises:
            InvalidRobot: always.
        """
        message = f"{self.source} has a <!DOCTYPE> declaration, which no robot needs and which is not read for safety"
        raise InvalidRobot(message, self.source)


class _Reader(Guardian):
    """Builds the tree of kept elements from the events of the parser."""

    def __init__(self, source: str, kept: Kept) -> None:
        super().__init__(source)
        self._kept = kept
        self.root: Element | None = None
        self._open: list[Element] = []
        self._skipped = 0

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        super().start(tag, attributes)
        if self._skipped:
            self._skipped += 1
        elif not self._open:
            if tag != "robot":
                message = f"{self.source} is no URDF: its outermost element is <{tag[:60]}>, not <robot>"
                raise InvalidRobot(message, self.source)
            self.root = Element(tag, attributes)
            self._open.append(self.root)
        elif tag.startswith("xacro:"):
            message = f"{self.source} is a xacro file: give it a name that ends in .xacro, and it is expanded"
            raise InvalidRobot(message, self.source)
        else:
            parent = self._open[-1]
            if tag in self._kept.get(parent.tag, ()) and (tag in _SEVERAL or parent.find(tag) is None):
                element = Element(tag, attributes)
                parent.append(element)
                self._open.append(element)
            else:
                self._skipped = 1

    def end(self, tag: str) -> None:
        super().end(tag)
        if self._skipped:
            self._skipped -= 1
        else:
            self._open.pop()
