"""The card of a robot, ``robot.toml``: what a description does not say, and what an adapter says otherwise."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal

from srs_ik.errors import InvalidRobot, did_you_mean, listed, quoted
from srs_ik.inputs.rotations import warn_of_degrees
from srs_ik.system import bounds

CARD_FILE = "robot.toml"
"""Usual name of a card, and that of the one which makes a folder of the package a robot."""

Vector = tuple[float, float, float]

_TEXTS = re.compile(
    r'''"""(?:\\.|[^\\])*?(?:"""|\Z)|\'{3}.*?(?:\'{3}|\Z)|"(?:\\.|[^"\\\n])*+"?|'[^'\n]*+'?|\#[^\n]*+''',
    re.DOTALL | re.VERBOSE,
)
"""Texts and comments of TOML, in which dots mean nothing; one without an end is where its parser stops."""

_TOO_DOTTED = re.compile(rf"(?<![\w-])(?:[\w-]++[ \t]*+\.[ \t]*+){{{bounds.CARD_KEYS}}}")

_SIDES = ("left", "right", "either")
_LIMITS = ("lower", "upper", "velocity", "effort", "acceleration")
_UNIT_TOLERANCE = 1e-9
"""How far a direction may be from unit length, or two of them from a right angle; wide enough for 10 written digits."""


@dataclass(frozen=True)
class Source:
    """Where a group of figures in a robot's files comes from."""

    figures: str  # which figures these are
    title: str  # title of the publication, with its authors or publisher
    year: int | None = None  # year of publication; None if it bears none
    url: str = ""  # address at its publisher or in a public repository; empty if it has none
    page: str = ""  # page, table or file in it; empty if the whole is meant
    note: str = ""  # what was done with the figures; empty if they are taken as they are


@dataclass(frozen=True)
class Placement:
    """A fixed transform as a URDF writes one.

    Attributes:
        xyz: metres.
        rpy: angles about the fixed x, then y, then z axis, rad.
        name: name of the frame that it places; "tool" or "world" if None, numbered where the robot has that.
        gravity: its acceleration in the frame around a mount, m/s^2; as it is in the description if None.
    """

    xyz: Vector
    rpy: Vector
    name: str | None = None
    gravity: Vector | None = None


@dataclass(frozen=True)
class RobotCard:
    """Which chain of a robot to use, and how; everything that is None or empty is left as the description has it."""

    name: str  # short name
    # where its description may be, the first that is there counts: absolute paths, or addresses as in
    # `srs_ik.robot.places`
    places: tuple[str, ...]
    base: str  # name of the base frame
    tip: str  # name of the tip frame
    description: str = ""  # one line for lists
    # "left" or "right" for an arm of that side of a body, else "either"
    side: Literal["left", "right", "either"] = "either"
    # arm-angle reference, a unit vector in the base frame; the arm angle is 0 where the elbow lies towards it
    reference: Vector | None = None
    grasp: Vector | None = None  # direction in which the hand grasps, a unit vector in the tip frame
    # direction that says how the hand is turned about ``grasp``, a unit vector in the tip frame and perpendicular to
    # ``grasp``
    pronosupination: Vector | None = None
    # for each joint in question those of "lower", "upper" (rad), "velocity" (rad/s) and "effort" (N m) that are not as
    # in the description
    limits: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    locked: Mapping[str, float] = field(default_factory=dict)  # where joints outside the arm stand, rad or m
    xacro: Mapping[str, str] = field(default_factory=dict)  # arguments for a description that is a xacro file
    tool: Placement | None = None  # frame of a tool in the tip frame
    mount: Placement | None = None  # the base frame in a frame of the surroundings
    # origin of each group of figures, by a short name of the group
    sources: Mapping[str, Source] = field(default_factory=dict)

    @property
    def urdf(self) -> Path:
        """Path of the description of a card that has it beside itself."""
        return Path(self.places[0])


def read_card(path: str | Path) -> RobotCard:
    """Reads a ``robot.toml``; paths in it are relative to it.

    Raises:
        InvalidRobot: the file cannot be read, is no TOML, has unknown keys, lacks one, or holds a value of the wrong
            type, or a direction that is no unit vector.
    """
    path = Path(path)
    return _Reader(path).card(_parse(path))


def _parse(path: Path) -> dict[str, Any]:
    try:
        if path.exists() and not path.is_file():
            raise InvalidRobot(f"{path} is not a regular file", source=path)
        with path.open("rb") as file:
            content = file.read(bounds.CARD_BYTES + 1)
    except (OSError, ValueError) as error:  # the latter for a path that no system takes
        reason = getattr(error, "strerror", None) or error
        raise InvalidRobot(f"cannot read {path}: {reason}", source=path) from error
    if len(content) > bounds.CARD_BYTES:
        raise InvalidRobot(f"{path} is larger than {bounds.CARD_BYTES // 2**10} KiB, too large for a card", source=path)
    try:
        # Some editors begin a file with a mark of its encoding.
        text = content.decode("utf-8-sig")
        if _TOO_DOTTED.search(_TEXTS.sub("t", text)):
            message = f"{path} has a key of more than {bounds.CARD_KEYS} parts; those of a card have two"
            raise InvalidRobot(message, source=path)
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # tomllib's own error, bytes that are no UTF-8, or deep nesting
        reason = quoted(" ".join(str(error).split()))[1:-1]
        raise InvalidRobot(f"{path} is not valid TOML: {reason}", source=path) from error


class _Reader:
    """Takes the values out of one parsed card, each with its check; the file's name goes into every message."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def card(self, content: dict[str, Any]) -> RobotCard:
        optional = ("description", "side", "arm_angle", "hand", "limits", "locked", "xacro", "tool", "mount", "sources")
        self._expect_keys(content, "", ("name", "urdf", "frames"), optional)
        frames = self._table(content, "frames", ("base", "tip"))
        hand = self._table(content, "hand", ("grasp", "pronosupination")) if "hand" in content else None
        arm_angle = self._table(content, "arm_angle", ("reference",)) if "arm_angle" in content else None
        card = RobotCard(
            name=self._text(content, "name"),
            places=self._places(content),
            base=self._text(frames, "base", "frames"),
            tip=self._text(frames, "tip", "frames"),
            description=self._text(content, "description") if "description" in content else "",
            side=self._side(content),
            reference=self._direction(arm_angle, "reference", "arm_angle") if arm_angle else None,
            grasp=self._direction(hand, "grasp", "hand") if hand else None,
            pronosupination=self._direction(hand, "pronosupination", "hand") if hand else None,
            limits=self._limits(content),
            locked=self._locked(content),
            xacro=self._xacro(content),
            tool=self._placement(content, "tool"),
            mount=self._placement(content, "mount", ("gravity",)),
            sources=self._sources(content),
        )
        if card.grasp and card.pronosupination:
            cosine = sum(a * b for a, b in zip(card.grasp, card.pronosupination, strict=True))
            if abs(cosine) > _UNIT_TOLERANCE:
                raise self._error("'grasp' and 'pronosupination' in [hand] must be perpendicular")
        return card

    def _places(self, content: dict[str, Any]) -> tuple[str, ...]:
        value = content["urdf"]
        places = value if isinstance(value, list) else [value]
        if not places or not all(isinstance(place, str) and place.strip() for place in places):
            raise self._error(f"'urdf' must be a path or an address, or a list of them, not {quoted(value)}")
        folder = self._path.absolute().parent
        return tuple(place if "://" in place else str(folder / place) for place in places)

    def _side(self, content: dict[str, Any]) -> Literal["left", "right", "either"]:
        side = self._text(content, "side") if "side" in content else "either"
        if side not in _SIDES:
            raise self._error(f"'side' must be one of {', '.join(_SIDES)}, not {quoted(side)}")
        return side  # type: ignore[return-value]

    def _limits(self, content: dict[str, Any]) -> Mapping[str, Mapping[str, float]]:
        groups = self._group(content, "limits")
        limits = {}
        for joint in groups:
            where = f"limits.{quoted(joint)[1:-1]}"
            table = self._table(groups, joint, (), _LIMITS, where)
            figures = {key: self._number(table[key], f"{key!r} in [{where}]", finite=False) for key in table}
            limits[joint] = MappingProxyType(figures)
        return MappingProxyType(limits)

    def _locked(self, content: dict[str, Any]) -> Mapping[str, float]:
        positions = self._group(content, "locked")
        return MappingProxyType({key: self._number(positions[key], f"{quoted(key)} in [locked]") for key in positions})

    def _xacro(self, content: dict[str, Any]) -> Mapping[str, str]:
        arguments = self._group(content, "xacro")
        return MappingProxyType({key: self._text(arguments, key, "xacro") for key in arguments})

    def _placement(self, content: dict[str, Any], key: str, more: tuple[str, ...] = ()) -> Placement | None:
        if key not in content:
            return None
        table = self._table(content, key, (), ("xyz", "rpy", "name", *more))
        xyz, rpy = (self._three(table[k], f"{k!r} in [{key}]") if k in table else (0.0,) * 3 for k in ("xyz", "rpy"))
        if max(map(abs, xyz + rpy)) > bounds.FARTHEST:
            raise self._error(f"'xyz' and 'rpy' in [{key}] are metres and rad, and none is beyond {bounds.FARTHEST:g}")
        warn_of_degrees(f"{self._path}: 'rpy' in [{key}]", rpy)
        gravity = self._three(table["gravity"], f"'gravity' in [{key}]") if "gravity" in table else None
        if gravity is not None and max(map(abs, gravity)) > bounds.FARTHEST:
            raise self._error(f"'gravity' in [{key}] is in m/s^2, and none of it is beyond {bounds.FARTHEST:g}")
        return Placement(xyz, rpy, self._text(table, "name", key) if "name" in table else None, gravity)

    def _sources(self, content: dict[str, Any]) -> Mapping[str, Source]:
        groups = self._group(content, "sources")
        sources = {}
        for group in groups:
            where = f"sources.{quoted(group)[1:-1]}"
            table = self._table(groups, group, ("figures", "title"), ("year", "url", "page", "note"), where)
            year = table.get("year")
            if year is not None and (isinstance(year, bool) or not isinstance(year, int)):
                raise self._error(f"'year' in [{where}] must be a whole number, not {quoted(year)}")
            texts = {key: self._text(table, key, where) for key in table if key != "year"}
            sources[group] = Source(year=year, **texts)
        return MappingProxyType(sources)

    def _group(self, content: dict[str, Any], key: str) -> dict[str, Any]:
        """A table whose keys are free; empty if it is not there."""
        table = content.get(key, {})
        if not isinstance(table, dict):
            raise self._error(f"'{key}' must be a table, not {quoted(table)}")
        return table

    def _table(
        self,
        content: dict[str, Any],
        key: str,
        required: tuple[str, ...],
        optional: tuple[str, ...] = (),
        where: str = "",
    ) -> dict[str, Any]:
        where = where or key
        table = content[key]
        if not isinstance(table, dict):
            raise self._error(f"'{where}' must be a table, not {quoted(table)}")
        self._expect_keys(table, where, required, optional)
        return table

    def _expect_keys(
        self, table: dict[str, Any], where: str, required: tuple[str, ...], optional: tuple[str, ...]
    ) -> None:
        place = f" in [{where}]" if where else ""
        known = required + optional
        for key in table:
            if key not in known:
                hint = did_you_mean(key, known)
                raise self._error(f"unknown key {quoted(key)}{place}{hint}; known are {listed(known)}")
        for key in required:
            if key not in table:
                raise self._error(f"the key {quoted(key)}{place} is missing")

    def _text(self, table: dict[str, Any], key: str, where: str = "") -> str:
        value = table[key]
        if not isinstance(value, str) or not value.strip():
            place = f" in [{where}]" if where else ""
            raise self._error(f"{quoted(key)}{place} must be a text that is not empty, not {quoted(value)}")
        return value

    def _number(self, value: Any, what: str, finite: bool = True) -> float:
        # bool is a kind of int in Python, but true is no figure.
        try:
            figure = math.nan if isinstance(value, bool) or not isinstance(value, int | float) else float(value)
        except OverflowError:
            raise self._error(f"{what} is larger than numbers of the machine") from None
        if math.isnan(figure):
            raise self._error(f"{what} must be a number, not {quoted(value)}")
        if finite and math.isinf(figure):
            raise self._error(f"{what} must be finite")
        return figure

    def _three(self, value: Any, what: str) -> Vector:
        if not isinstance(value, list) or len(value) != 3 or any(type(x) not in (int, float) for x in value):
            raise self._error(f"{what} must be three numbers, not {quoted(value)}")
        x, y, z = (self._number(number, what) for number in value)
        return (x, y, z)

    def _direction(self, table: dict[str, Any], key: str, where: str) -> Vector:
        vector = self._three(table[key], f"{quoted(key)} in [{where}]")
        if not abs(math.hypot(*vector) - 1.0) <= _UNIT_TOLERANCE:
            raise self._error(f"{quoted(key)} in [{where}] must be a unit vector, not {quoted(table[key])}")
        return vector

    def _error(self, what: str) -> InvalidRobot:
        return InvalidRobot(f"{self._path}: {what}", source=self._path)
