"""MJCF files, the format of MuJoCo, as far as Pinocchio reads them."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, fromstring, tostring

import numpy as np
import pinocchio as pin

from srs_ik.errors import InvalidRobot
from srs_ik.robot.description import document
from srs_ik.robot.description.check import FARTHEST, LONGEST_NAME, MAX_FREEDOM

MAX_INCLUDES = 20
"""Most files that one may include, in all."""

_FREEDOM = {"slide": 1, "hinge": 1, "ball": 3, "free": 6}


def build(path: Path, content: bytes, label: str, first_complaint: Callable[[], str]) -> Any:
    """The ``pinocchio.Model`` of an MJCF file.

    Args:
        path: the file.
        content: what is in it.
        label: what error messages call it.
        first_complaint: what the parser has printed by now.

    Raises:
        InvalidRobot: the file is too large or too deep, Pinocchio does not read it, or names, places or limits in it
            make no sense.
    """
    _Guardian(path, label).read(content)
    try:
        # Pinocchio reads MJCF from files only.
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, "whole.xml")
            file.write_bytes(_whole(content, path.absolute().parent, label))
            model = pin.buildModelFromMJCF(str(file))
    except InvalidRobot:
        raise
    except Exception as error:
        # What it throws ends with the message, after the place in its own source.
        complaint = first_complaint() or " ".join(str(error).rpartition("message:")[2].split())
        raise InvalidRobot(f"{label} is an MJCF file that Pinocchio does not read: {complaint}", label) from None
    _check(model, label)
    return model


def _whole(content: bytes, folder: Path, label: str) -> bytes:
    """An MJCF text as MuJoCo understands it, for Pinocchio, which reads the letter.

    Files that it includes are put in their places; sections of the same name, such as the bodies of a robot and the
    floor of a scene, become one; defaults come before what they are for; and the folder of meshes is an absolute path.

    Raises:
        InvalidRobot: with what it includes it is nested too deep.
    """
    try:
        root = fromstring(content.lstrip())
        _include(root, folder)
        sections = {"compiler": Element("compiler"), "default": Element("default")}
        for section in root:
            first = sections.setdefault(section.tag, section)
            if first is not section:
                first.attrib |= section.attrib
                first.extend(section)
        compiler = sections["compiler"].attrib
        compiler["meshdir"] = str(folder / compiler.get("meshdir", compiler.get("assetdir", "")))
        root[:] = list(sections.values())
        text: bytes = tostring(root)
    except RecursionError:
        raise InvalidRobot(f"{label} has XML elements nested too deep for a robot", label) from None
    document.run(document.Guardian(label), text, label)
    return text


def _include(element: Element, folder: Path) -> None:
    # All paths are relative to the main file.
    for k, child in reversed(list(enumerate(element))):
        if child.tag == "include":
            included = fromstring((folder / child.get("file", "")).read_bytes().lstrip())
            _include(included, folder)
            element[k : k + 1] = list(included)
        else:
            _include(child, folder)


class _Guardian(document.Guardian):
    """Bounds an MJCF file and those that it includes: Pinocchio's memory grows with the cube of the joints."""

    def __init__(self, path: Path, label: str) -> None:
        super().__init__(label)
        self._folder = path.parent
        self._freedom = 0
        self._untyped = 0
        self._defaults = 0
        self._usual = 1
        self._bodies = 0
        self._included: list[Path] = []

    def read(self, content: bytes) -> None:
        document.check_size(content, self.source)
        document.run(self, content.lstrip(), self.source)
        for file in self._included:
            try:
                with file.open("rb") as stream:
                    content = stream.read(document.MAX_BYTES + 1)
            except (OSError, ValueError):
                raise InvalidRobot(f"{self.source} includes {str(file)!r}, which cannot be read", self.source) from None
            document.check_size(content, str(file))
            document.run(self, content.lstrip(), str(file))
        if not self._bodies:
            raise InvalidRobot(f"{self.source} is an MJCF file without any <body>", self.source)
        if self._freedom + self._untyped * self._usual > MAX_FREEDOM:
            message = f"{self.source} has more than the {MAX_FREEDOM} degrees of freedom that are read"
            raise InvalidRobot(message, self.source)

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        super().start(tag, attributes)
        if tag == "default":
            self._defaults += 1
        elif tag == "joint" and self._defaults:
            self._usual = max(self._usual, _FREEDOM.get(attributes.get("type", ""), 1))
        elif tag == "joint" and "type" in attributes:
            self._freedom += _FREEDOM.get(attributes["type"], 1)
        elif tag == "joint":
            self._untyped += 1
        elif tag == "freejoint":
            self._freedom += _FREEDOM["free"]
        elif tag == "body":
            self._bodies += 1
        elif tag == "include":
            # The list grows while it is gone through, so that files of included files are bounded too.
            self._included.append(self._folder / attributes.get("file", ""))
        if len(self._included) > MAX_INCLUDES:
            raise InvalidRobot(f"{self.source} includes more than {MAX_INCLUDES} files", self.source)

    def end(self, tag: str) -> None:
        super().end(tag)
        self._defaults -= tag == "default"


def _check(model: Any, label: str) -> None:
    try:
        names = [frame.name for frame in model.frames]
    except UnicodeDecodeError:
        raise InvalidRobot(f"{label}: a name in it is no text", label) from None
    if not all(name.isprintable() and len(name) <= LONGEST_NAME for name in names):
        raise InvalidRobot(f"{label}: a name in it cannot be printed, or is longer than {LONGEST_NAME}", label)
    if "universe" in names[1:]:
        raise InvalidRobot(
            f"{label}: something in it is called 'universe', which is Pinocchio's name of the world", label
        )
    placements = [frame.placement for frame in model.frames]
    for name, place in [*zip(model.names, model.jointPlacements, strict=True), *zip(names, placements, strict=True)]:
        if not np.abs(place.homogeneous).max() <= FARTHEST:
            raise InvalidRobot(f"{label}: {name!r} lies nowhere, or farther than {FARTHEST:g} m", label)
    if not (model.lowerPositionLimit <= model.upperPositionLimit).all():
        raise InvalidRobot(f"{label}: a joint has a lower limit above its upper limit", label)
    if (model.lowerPositionLimit >= FARTHEST).any() or (model.upperPositionLimit <= -FARTHEST).any():
        raise InvalidRobot(f"{label}: a joint has limits that are out of any reach", label)
