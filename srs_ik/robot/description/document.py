"""URDF text to the few elements that motion and mass depend on: links with inertia, joints with their figures.

Visuals, collisions, materials, transmissions, simulator tags and whatever else a file holds are skipped while reading,
so missing meshes and faulty tags among them do no harm, and a large file stays small in memory.
"""

from __future__ import annotations

import codecs
import re
from collections.abc import Mapping
from xml.etree.ElementTree import Element
from xml.parsers import expat

from srs_ik.errors import InvalidRobot
from srs_ik.system import bounds

_PART = 2**20
"""Bytes that the parser is given at once: few enough parts, as it begins a long name or value again with each."""

_READ = re.compile(r"utf-8|utf-8-sig|utf-16|utf-16-[bl]e|ascii|iso8859-\d+|cp125\d|koi8-[rtu]")
"""Encodings that are read, by Python's names: those of one meaning for each byte or code unit."""

_DECLARED = re.compile(rb"(?:\xef\xbb\xbf)?\s*<\?xml\s[^>]{0,200}?encoding\s*=\s*[\"']([A-Za-z0-9._-]{1,40})[\"']")
_BEFORE = re.compile(r"(?:\s++|<\?.*?\?>|<!--.*?-->)*+", re.DOTALL)
_CROWDED = re.compile(rf"<(?:[^<=]*+=\s*+[\"']){{{bounds.XML_ATTRIBUTES}}}")
_TAG = re.compile(r"<([^\s/<>!?]+)")

Kept = Mapping[str, frozenset[str]]
"""Elements that are kept inside each element."""

KEPT: Kept = {
    "robot": frozenset({"link", "joint"}),
    "link": frozenset({"inertial"}),
    "inertial": frozenset({"origin", "mass", "inertia"}),
    "joint": frozenset({"parent", "child", "origin", "axis", "limit", "dynamics", "mimic"}),
}
"""What motion and mass depend on; of several elements where one is meant, the first counts."""

_SEVERAL = frozenset({"link", "joint", "group", "chain", "material", "visual", "collision"}).union(
    {"disable_collisions", "disable_default_collisions", "enable_collisions"}
)


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
    reader = _Reader(source, kept)
    run(reader, text, source)
    if reader.root is None:
        raise InvalidRobot(f"{source} has no <robot> element", source)
    return reader.root


def root_tag(text: bytes) -> str:
    """Tag of the outermost element of an XML text; "" where it does not begin with one."""
    try:
        return _Prolog(_decoded(text, "")).tag
    except InvalidRobot:
        return ""


def run(handler: Guardian, text: str | bytes, source: str) -> None:
    """Parse a text for its events.

    Raises:
        InvalidRobot: it is empty, too large or not well-formed, declares a document type, has an element of far too
            many attributes, or the handler refuses it.
    """
    text = _decoded(text, source)
    if not text:
        raise InvalidRobot(f"{source} is empty", source)
    # Before the parser sees it: entities that a document type defines would be expanded, even after an error.
    if _Prolog(text).has_doctype:
        handler.doctype()
    if _CROWDED.search(text):
        message = f"{source} has an element of {bounds.XML_ATTRIBUTES} attributes or more, too many for a robot"
        raise InvalidRobot(message, source)
    # Without namespace processing, as other URDF readers do: files with undeclared prefixes in skipped tags are common.
    parser = expat.ParserCreate("utf-8")
    parser.StartElementHandler = handler.start
    parser.EndElementHandler = handler.end
    parser.StartDoctypeDeclHandler = handler.doctype
    try:
        content = text.encode()
        # In parts: after an error the parser reads on to the end of what it was given.
        for start in range(0, len(content), _PART):
            parser.Parse(content[start : start + _PART], False)
        parser.Parse(b"", True)
    except (expat.ExpatError, ValueError) as error:
        raise InvalidRobot(f"{source} is not well-formed XML: {error}", source) from None


def _decoded(text: str | bytes, source: str) -> str:
    """XML as text, without what comes before its declaration or first element.

    Blank lines there are an error by the letter, and common in strings of programs.

    Raises:
        InvalidRobot: it is too large, not in the encoding that it declares, or no XML but USD.
    """
    if len(text) > bounds.XML_BYTES:
        raise InvalidRobot(f"{source} is larger than {bounds.XML_BYTES // 2**20} MiB, too large for a robot", source)
    if text[:8] in (b"PXR-USDC", "PXR-USDC") or text[:5] in (b"#usda", "#usda"):
        raise InvalidRobot(f"{source} is USD, which is not read: URDF, xacro and MJCF are", source)
    if isinstance(text, bytes):
        encoding = _encoding(text)
        try:
            if not _READ.fullmatch(codecs.lookup(encoding).name):
                raise LookupError(f"unknown encoding {encoding!r}")
            text = text.decode(encoding)
        except (LookupError, ValueError) as error:
            raise InvalidRobot(f"{source} is not well-formed XML: {error}", source) from None
    return text.lstrip("\ufeff \t\r\n")


def _encoding(text: bytes) -> str:
    """The encoding of an XML text: by its first bytes, else as it declares, else UTF-8."""
    if text.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    declared = _DECLARED.match(text)
    return declared[1].decode() if declared else "utf-8"


class _Prolog:
    """What comes before the content of an XML text: any document type, and the tag of the outermost element, if any."""

    def __init__(self, text: str) -> None:
        end = _BEFORE.match(text).end()  # type: ignore[union-attr]
        self.has_doctype = text.startswith("<!DOCTYPE", end)
        tag = _TAG.match(text, end)
        self.tag = tag[1] if tag else ""


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
        """An element begins; raises InvalidRobot where it is one too many, or too deep."""
        self._count += 1
        self._depth += 1
        if self._count > bounds.XML_ELEMENTS:
            message = f"{self.source} has more than {bounds.XML_ELEMENTS} XML elements, too many for a robot"
            raise InvalidRobot(message, self.source)
        if self._depth > bounds.XML_DEPTH:
            message = f"{self.source} has XML elements nested more than {bounds.XML_DEPTH} deep, too deep for a robot"
            raise InvalidRobot(message, self.source)

    def end(self, tag: str) -> None:
        """An element ends."""
        self._depth -= 1

    def doctype(self, *declaration: object) -> None:
        """A document type is declared, which is always refused."""
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
