"""MJCF text, with the files that it includes, to one tree of elements."""

from __future__ import annotations

from collections import deque
from pathlib import Path
from xml.etree.ElementTree import Element

from srs_ik.errors import InvalidRobot, quoted
from srs_ik.robot.description import document
from srs_ik.robot.description.files import label_of, read
from srs_ik.system import bounds

_ROOT = "mujoco"
_SECTIONS = frozenset(
    {"compiler", "option", "size", "statistic", "visual", "default", "extension", "asset", "worldbody", "deformable"}
    | {"contact", "tendon", "equality", "actuator", "sensor", "custom", "keyframe"}
)


def whole(path: Path, content: bytes, label: str) -> Element:
    """The element ``<mujoco>`` of a file, with the elements of included files in the place of each ``<include>``.

    A file that is included is looked for beside the main file, `path`, then beside the one that includes it.

    Raises:
        InvalidRobot: a text is not well-formed, all of them are too large together, a file cannot be read or is
            included twice, or what they make is nested too deep.
    """
    return _Including(path, label).whole(content)


class _Including:
    def __init__(self, path: Path, label: str) -> None:
        self._label = label
        self._folder = path.absolute().parent
        self._open = {path.resolve()}
        self._bytes = 0
        self._trees = _Trees(label)

    def whole(self, content: bytes) -> Element:
        root = self._tree(content, self._label)
        if root.tag != _ROOT:
            raise InvalidRobot(f"{self._label} has the outermost element <{root.tag[:60]}>, not <{_ROOT}>", self._label)
        level, depth = [(root, self._folder)], 0
        while level:
            depth += 1
            if depth > bounds.XML_DEPTH:
                message = f"{self._label} has XML elements nested more than {bounds.XML_DEPTH} deep with its includes"
                raise InvalidRobot(message, self._label)
            level = [inner for element, folder in level for inner in self._filled(element, folder)]
        for section in root:
            if section.tag not in _SECTIONS:
                message = f"{self._label}: <{_ROOT}> has a <{section.tag[:60]}>, which is not understood"
                raise InvalidRobot(message, self._label)
        return root

    def _filled(self, element: Element, folder: Path) -> list[tuple[Element, Path]]:
        """Put what is included into the place of each include; the children, and the folder that each comes from."""
        pending = deque((child, folder) for child in element)
        found: list[tuple[Element, Path]] = []
        while pending:
            child, beside = pending.popleft()
            if child.tag == "include":
                included, inner = self._included(child, beside)
                pending.extendleft((grandchild, inner) for grandchild in reversed(included))
            else:
                found.append((child, beside))
        element[:] = [child for child, _ in found]
        return found

    def _included(self, include: Element, beside: Path) -> tuple[Element, Path]:
        name = include.get("file", "")
        if set(include.attrib) != {"file"} or len(include) or not name.strip():
            raise InvalidRobot(f"{self._label}: an <include> names one file and nothing else", self._label)
        try:
            path = next((p for p in (self._folder / name, beside / name) if p.exists()), self._folder / name)
            place = path.resolve()
        except (OSError, ValueError, RuntimeError):
            message = f"{self._label} includes {quoted(name)}, which cannot be read: it is no path"
            raise InvalidRobot(message, self._label) from None
        if place in self._open:
            raise InvalidRobot(f"{self._label} includes the file {quoted(name)} twice, or in a circle", self._label)
        self._open.add(place)
        if len(self._open) > bounds.XML_INCLUDES + 1:
            raise InvalidRobot(f"{self._label} includes more than {bounds.XML_INCLUDES} files", self._label)
        try:
            content = read(path, label_of(path))
        except InvalidRobot as error:
            message = f"{self._label} includes {quoted(name)}, which cannot be read: {error}"
            raise InvalidRobot(message, self._label) from None
        return self._tree(content, label_of(path)), place.parent

    def _tree(self, content: bytes, label: str) -> Element:
        self._bytes += len(content)
        if self._bytes > bounds.XML_BYTES:
            size = f"larger than {bounds.XML_BYTES // 2**20} MiB"
            raise InvalidRobot(f"{self._label} is {size} with what it includes, too large for a robot", self._label)
        return self._trees.read(content, label)


class _Trees(document.Guardian):
    """Builds trees of elements, with one count of elements for all of them."""

    _SKIPPED = frozenset({"asset", "visual", "statistic", "custom", "keyframe", "sensor", "contact", "extension"})
    """Sections without effect on motion and mass, large ones among them."""

    def read(self, content: bytes, label: str) -> Element:
        # The element that holds what is read: the outermost one, then those that are open in it.
        holder = Element("")
        self._above, self._skipped = [holder], 0
        document.run(self, content, label)
        return holder[0]

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        super().start(tag, attributes)
        # A section is the third, after what holds all and the outermost element.
        if self._skipped or (len(self._above) == 2 and tag in self._SKIPPED):
            self._skipped += 1
            return
        element = Element(tag, attributes)
        self._above[-1].append(element)
        self._above.append(element)

    def end(self, tag: str) -> None:
        super().end(tag)
        if self._skipped:
            self._skipped -= 1
        else:
            self._above.pop()
