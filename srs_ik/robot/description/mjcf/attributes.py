"""Attributes of MJCF elements: default classes, the compiler's settings, figures, and placements from any notation."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from srs_ik.errors import InvalidRobot, did_you_mean, quoted
from srs_ik.robot.description.figures import figure
from srs_ik.system import bounds

Attributes = Mapping[str, str]


def words(text: str) -> frozenset[str]:
    """The words of a text."""
    return frozenset(text.split())


TURNS = ("axisangle", "xyaxes", "zaxis", "euler")
"""Attributes that say an orientation otherwise than by "quat"."""

ORIENTATION = frozenset({"quat", *TURNS})

_COMPILER = words(
    "autolimits boundmass boundinertia settotalmass balanceinertia strippath coordinate angle fitaabb eulerseq "
    "meshdir texturedir discardvisual usethread fusestatic inertiafromgeom inertiagrouprange saveinertial assetdir "
    "alignfree conflict convexhull exactmeshinertia"
)
_MAIN = "main"
_WITH_DEFAULTS = ("joint", "site", "geom")
ACTUATORS = words("general motor position velocity intvelocity damper cylinder muscle")
"""Actuators that a joint may have; in a default class, one of any kind stands for all."""

_ANY_ACTUATOR = "actuator"
_OTHER_DEFAULTS = words("default mesh material camera light pair equality tendon orientation pid adhesion dcmotor")
CHOICES = {
    "type": ("hinge", "slide", "ball", "free"),
    "limited": ("true", "false", "auto"),
    "actuatorfrclimited": ("true", "false", "auto"),
}
"""Words that attributes of a joint may have."""

_SHORTEST = 1e-9
"""Shortest vector or quaternion that is taken for a direction or a rotation."""


@dataclass(frozen=True)
class Compiler:
    """Settings for a whole file."""

    degrees: bool  # whether angles are in degrees
    eulerseq: str  # axes of Euler angles; small letters turn with the body, capitals stay
    autolimits: bool  # whether a range says that a joint is limited
    others: Attributes  # every attribute as it stands


class Reader:
    """Reads attributes below the element ``<mujoco>``; the file's label goes into every message.

    Raises:
        InvalidRobot: a setting of the compiler or a default class makes no sense.
    """

    def __init__(self, root: Element, label: str) -> None:
        self.label = label
        self.compiler = self._compiler(root)
        self._classes: dict[str, dict[str, dict[str, str]]] = {
            _MAIN: {tag: {} for tag in (*_WITH_DEFAULTS, _ANY_ACTUATOR)}
        }
        for section in root.iterfind("default"):
            self._default(section, None)

    def fail(self, what: str) -> InvalidRobot:
        """The error for what is wrong in this file."""
        return InvalidRobot(f"{self.label}: {what}", self.label)

    def known(self, element: Element, attributes: Iterable[str], where: str) -> None:
        """Refuse attributes that are not among these."""
        for key in element.attrib:
            if key not in attributes:
                raise self.fail(f"{where} has the attribute {quoted(key)}, which is not understood")

    def class_named(self, name: str, where: str) -> str:
        """The name of a default class, checked."""
        if name not in self._classes:
            raise self.fail(
                f"{where} has the class {quoted(name)}, which is not defined{did_you_mean(name, self._classes)}"
            )
        return name

    def merged(self, element: Element, childclass: str, where: str) -> dict[str, str]:
        """Attributes of an element over those of its default class."""
        self.one_orientation(element.attrib, where)
        usual = self._classes[self.class_named(element.get("class", childclass), where)][element.tag]
        return _over(usual, element.attrib)

    def merged_actuator(self, element: Element, where: str) -> dict[str, str]:
        """Attributes of an actuator over those of its default class, whatever actuator gives them there."""
        usual = self._classes[self.class_named(element.get("class", _MAIN), where)][_ANY_ACTUATOR]
        return {**usual, **element.attrib}

    def figure(self, text: str, what: str) -> float:
        """One finite number."""
        value = figure(text)
        if math.isnan(value):
            raise self.fail(f"{what} is {quoted(text)}, not a finite number")
        return value

    def vector(self, text: str, length: int, what: str) -> np.ndarray:
        """So many finite numbers."""
        words = text.split(None, length)
        if len(words) != length:
            raise self.fail(f"{what} is {quoted(text)}, not {length} numbers")
        return np.array([self.figure(word, what) for word in words])

    def position(self, text: str, what: str) -> np.ndarray:
        """Three figures in metres, none of them out of reach."""
        place = self.vector(text, 3, what)
        if np.abs(place).max() > bounds.FARTHEST:
            raise self.fail(f"{what} is {quoted(text)}, farther than {bounds.FARTHEST:g} m")
        return place

    def direction(self, vector: np.ndarray, what: str) -> np.ndarray:
        """A vector at unit length."""
        length = math.hypot(*vector)
        if not _SHORTEST < length < math.inf:
            raise self.fail(f"{what} has no direction")
        return vector / length

    def joint_choices(self, attributes: Attributes, where: str) -> None:
        """Refuse a joint, or defaults of joints, with a word in them that it cannot have."""
        for key, choices in CHOICES.items():
            self.choice(attributes, key, choices, choices[0], where)

    def choice(self, attributes: Attributes, key: str, choices: tuple[str, ...], usual: str, where: str) -> str:
        """A word of several."""
        word = attributes.get(key, usual)
        if word not in choices:
            raise self.fail(f"{key} of {where} is {quoted(word)}, not one of {', '.join(choices)}")
        return word

    def one_orientation(self, attributes: Attributes, where: str) -> None:
        """Refuse an element that says its orientation in two ways."""
        given = sorted(ORIENTATION & attributes.keys())
        if len(given) > 1:
            raise self.fail(f"{where} has an orientation by {' and by '.join(given)}; one is enough")

    def placement(self, attributes: Attributes, where: str) -> pin.SE3:
        """Position and orientation in the element above."""
        place = self.position(attributes.get("pos", "0 0 0"), f"pos of {where}")
        return pin.SE3(self.rotation(attributes, where), place)

    def rotation(self, attributes: Attributes, where: str) -> np.ndarray:
        """(3, 3) rotation of whichever attribute says the orientation."""
        key = next((key for key in TURNS if key in attributes), "quat")
        text, what = attributes.get(key, "1 0 0 0"), f"{key} of {where}"
        if key == "quat":
            return pin.Quaternion(*self.direction(self.vector(text, 4, what), what)).toRotationMatrix()
        if key == "axisangle":
            *axis, angle = self.vector(text, 4, what)
            return _turn(self.direction(np.array(axis), what), self.angle(angle))
        if key == "xyaxes":
            vectors = self.vector(text, 6, what)
            x = self.direction(vectors[:3], what)
            y = self.direction(vectors[3:] - x * (x @ vectors[3:]), what)
            return np.column_stack([x, y, np.cross(x, y)])
        if key == "zaxis":
            return turned_to(self.direction(self.vector(text, 3, what), what))
        R = np.eye(3)
        for letter, angle in zip(self.compiler.eulerseq, self.vector(text, 3, what), strict=True):
            turn = _turn(np.eye(3)["xyz".index(letter.lower())], self.angle(angle))
            R = R @ turn if letter.islower() else turn @ R
        return R

    def angle(self, value: float) -> float:
        """An angle of the file in radians."""
        return math.radians(value) if self.compiler.degrees else value

    def _compiler(self, root: Element) -> Compiler:
        settings: dict[str, str] = {}
        for section in root.iterfind("compiler"):
            self.known(section, _COMPILER, "<compiler>")
            settings |= section.attrib
        if self.choice(settings, "coordinate", ("local", "global"), "local", "<compiler>") == "global":
            raise self.fail("coordinate of <compiler> is 'global', which MuJoCo has given up; local ones are read")
        sequence = settings.get("eulerseq", "xyz")
        if len(sequence) != 3 or not set(sequence) <= set("xyzXYZ"):
            raise self.fail(f"eulerseq of <compiler> is {quoted(sequence)}, not three of the letters xyzXYZ")
        return Compiler(
            degrees=self.choice(settings, "angle", ("radian", "degree"), "degree", "<compiler>") == "degree",
            eulerseq=sequence,
            autolimits=self.choice(settings, "autolimits", ("true", "false"), "true", "<compiler>") == "true",
            others=settings,
        )

    def _default(self, section: Element, above: str | None) -> None:
        """Read a default class and those in it; what a class holds counts for those in it, wherever it stands."""
        pending = [(section, above)]
        while pending:
            section, above = pending.pop(0)
            self.known(section, ("class",), "<default>")
            name = section.get("class", "" if above else _MAIN)
            if above is None and name != _MAIN:
                raise self.fail(f"the outermost <default> has the class {quoted(name)}; it can only be {_MAIN!r}")
            if not name or (above is not None and name in self._classes):
                raise self.fail(f"a <default> has the class {quoted(name)}, which is {'used' if name else 'no name'}")
            if above is not None:
                self._classes[name] = dict(self._classes[above])
            for element in section:
                if element.tag in _WITH_DEFAULTS:
                    if "name" in element.attrib or "class" in element.attrib:
                        raise self.fail(f"<{element.tag}> of the default class {quoted(name)} has a name or class")
                    where = f"<{element.tag}> of the default class {quoted(name)}"
                    self.one_orientation(element.attrib, where)
                    if element.tag == "joint":
                        self.joint_choices(element.attrib, where)
                    self._classes[name][element.tag] = _over(self._classes[name][element.tag], element.attrib)
                elif element.tag in ACTUATORS:
                    self._classes[name][_ANY_ACTUATOR] = {**self._classes[name][_ANY_ACTUATOR], **element.attrib}
                elif element.tag not in _OTHER_DEFAULTS:
                    raise self.fail(
                        f"the default class {quoted(name)} has a <{element.tag[:60]}>, which is not understood"
                    )
            pending[:0] = [(inner, name) for inner in section.iterfind("default")]


def _over(usual: Attributes, own: Attributes) -> dict[str, str]:
    """Attributes over others; an orientation in any notation puts aside that of the others."""
    if ORIENTATION & own.keys():
        usual = {key: value for key, value in usual.items() if key not in ORIENTATION}
    return {**usual, **own}


def _turn(axis: np.ndarray, angle: float) -> np.ndarray:
    return pin.AngleAxis(angle, axis).toRotationMatrix()


def turned_to(z: np.ndarray) -> np.ndarray:
    """(3, 3) the least rotation that turns the z axis to a unit vector; half a turn about x for the opposite."""
    across = np.array([-z[1], z[0], 0.0])
    length = math.hypot(*across)
    axis = across / length if length > 1e-10 else np.array([1.0, 0.0, 0.0])
    return _turn(axis, math.atan2(length, z[2]))
