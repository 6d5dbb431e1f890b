"""The built-in robots: one folder each, with a URDF and a ``robot.toml`` that says how to read it."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal

from srs_ik.errors import InvalidRobot, did_you_mean, listed

CARD_FILE = "robot.toml"
"""Name of the file that makes a folder a robot."""

Vector = tuple[float, float, float]

_SIDES = ("left", "right", "either")
_UNIT_TOLERANCE = 1e-9
"""How far a direction may be from unit length, or two of them from a right angle; wide enough for 10 written digits."""


@dataclass(frozen=True)
class Source:
    """Where a group of figures in a robot's files comes from.

    Attributes:
        figures: which figures these are.
        title: title of the publication, with its authors or publisher.
        year: year of publication; None if it bears none.
        url: address at its publisher or in a public repository; empty if it has none.
        page: page, table or file in it; empty if the whole is meant.
        note: what was done with the figures; empty if they are taken as they are.
    """

    figures: str
    title: str
    year: int | None = None
    url: str = ""
    page: str = ""
    note: str = ""


@dataclass(frozen=True)
class RobotCard:
    """What a robot's URDF does not say: which chain to use, how its hand lies, and where its figures come from.

    Attributes:
        name: short name, that of the folder.
        description: one line for lists.
        urdf: absolute path of the URDF file.
        base: name of the base frame.
        tip: name of the tip frame.
        side: "left" or "right" for an arm of that side of a body, else "either".
        reference: arm-angle reference, a unit vector in the base frame; the arm angle is 0 where the elbow lies
            towards it.
        grasp: direction in which the hand grasps, a unit vector in the tip frame.
        pronosupination: direction that says how the hand is turned about ``grasp``, a unit vector in the tip frame and
            perpendicular to ``grasp``.
        sources: origin of each group of figures, by a short name of the group.
    """

    name: str
    description: str
    urdf: Path
    base: str
    tip: str
    side: Literal["left", "right", "either"]
    reference: Vector
    grasp: Vector
    pronosupination: Vector
    sources: Mapping[str, Source]


def robots() -> list[str]:
    """Names of the built-in robots, sorted.

    Raises:
        InvalidRobot: the installation has lost its folder of robots.
    """
    return sorted(path.parent.name for path in _folder().glob(f"*/{CARD_FILE}"))


def card(name: str) -> RobotCard:
    """The card of a built-in robot.

    Raises:
        InvalidRobot: there is no such robot, or its card is damaged.
    """
    known = robots()
    if name not in known:
        raise InvalidRobot(
            f"there is no built-in robot {name!r}{did_you_mean(name, known)}; there are {listed(known)}", source=name
        )
    return read_card(_folder() / name / CARD_FILE)


def read_card(path: str | Path) -> RobotCard:
    """Reads a ``robot.toml``; the URDF that it names lies beside it.

    Raises:
        InvalidRobot: the file cannot be read, is no TOML, has unknown keys, lacks one, or holds a value of the wrong
            type, a direction that is no unit vector, or the name of a URDF that is not there.
    """
    path = Path(path)
    return _Reader(path).card(_parse(path))


def _folder() -> Path:
    package = Path(__file__).resolve().parent
    # A wheel carries the robots inside the package; in a checkout they lie beside it.
    for folder in (package / "robots", package.parent / "robots"):
        if folder.is_dir():
            return folder
    raise InvalidRobot(f"the folder of built-in robots is missing beside or inside {package}", source=package)


def _parse(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InvalidRobot(f"cannot read {path}: {error.strerror or error}", source=path) from error
    except ValueError as error:  # tomllib's own error, or bytes that are no UTF-8
        raise InvalidRobot(f"{path} is not valid TOML: {error}", source=path) from error


class _Reader:
    """Takes the values out of one parsed card, each with its check; the file's name goes into every message."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def card(self, content: dict[str, Any]) -> RobotCard:
        keys = ("name", "description", "urdf", "side", "frames", "arm_angle", "hand", "sources")
        self._expect_keys(content, "", keys)
        frames = self._table(content, "frames", ("base", "tip"))
        arm_angle = self._table(content, "arm_angle", ("reference",))
        hand = self._table(content, "hand", ("grasp", "pronosupination"))
        grasp = self._direction(hand, "grasp", "hand")
        pronosupination = self._direction(hand, "pronosupination", "hand")
        if abs(sum(a * b for a, b in zip(grasp, pronosupination, strict=True))) > _UNIT_TOLERANCE:
            raise self._error("'grasp' and 'pronosupination' in [hand] must be perpendicular")
        return RobotCard(
            name=self._name(content),
            description=self._text(content, "description"),
            urdf=self._urdf(content),
            base=self._text(frames, "base", "frames"),
            tip=self._text(frames, "tip", "frames"),
            side=self._side(content),
            reference=self._direction(arm_angle, "reference", "arm_angle"),
            grasp=grasp,
            pronosupination=pronosupination,
            sources=self._sources(content),
        )

    def _name(self, content: dict[str, Any]) -> str:
        name, folder = self._text(content, "name"), self._path.absolute().parent.name
        if name != folder:
            raise self._error(f"the name {name!r} must be that of its folder, {folder!r}")
        return name

    def _urdf(self, content: dict[str, Any]) -> Path:
        name = self._text(content, "urdf")
        urdf = self._path.absolute().parent / name
        if Path(name).name != name:
            raise self._error(f"'urdf' must be a plain file name beside the card, not {name!r}")
        if not urdf.is_file():
            raise self._error(f"its URDF file {name!r} is not there")
        return urdf

    def _side(self, content: dict[str, Any]) -> Literal["left", "right", "either"]:
        side = self._text(content, "side")
        if side not in _SIDES:
            raise self._error(f"'side' must be one of {', '.join(_SIDES)}, not {side!r}")
        return side  # type: ignore[return-value]

    def _sources(self, content: dict[str, Any]) -> Mapping[str, Source]:
        groups = content["sources"]
        if not isinstance(groups, dict) or not groups:
            raise self._error("'sources' must be a table with at least one group of figures")
        sources = {}
        for group in groups:
            where = f"sources.{group}"
            table = self._table(groups, group, ("figures", "title"), ("year", "url", "page", "note"), where)
            year = table.get("year")
            if year is not None and (isinstance(year, bool) or not isinstance(year, int)):
                raise self._error(f"'year' in [{where}] must be a whole number, not {year!r}")
            texts = {key: self._text(table, key, where) for key in table if key != "year"}
            sources[group] = Source(year=year, **texts)
        return MappingProxyType(sources)

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
            raise self._error(f"'{where}' must be a table, not {table!r}")
        self._expect_keys(table, where, required, optional)
        return table

    def _expect_keys(
        self, table: dict[str, Any], where: str, required: tuple[str, ...], optional: tuple[str, ...] = ()
    ) -> None:
        place = f" in [{where}]" if where else ""
        known = required + optional
        for key in table:
            if key not in known:
                raise self._error(f"unknown key {key!r}{place}{did_you_mean(key, known)}; known are {listed(known)}")
        for key in required:
            if key not in table:
                raise self._error(f"the key {key!r}{place} is missing")

    def _text(self, table: dict[str, Any], key: str, where: str = "") -> str:
        value = table[key]
        if not isinstance(value, str) or not value.strip():
            place = f" in [{where}]" if where else ""
            raise self._error(f"{key!r}{place} must be a text that is not empty, not {value!r}")
        return value

    def _direction(self, table: dict[str, Any], key: str, where: str) -> Vector:
        value = table[key]
        # bool is a kind of int in Python, but true is no coordinate.
        if (
            not isinstance(value, list)
            or len(value) != 3
            or not all(isinstance(number, int | float) and not isinstance(number, bool) for number in value)
        ):
            raise self._error(f"{key!r} in [{where}] must be three numbers, not {value!r}")
        x, y, z = (float(number) for number in value)
        if not abs(math.hypot(x, y, z) - 1.0) <= _UNIT_TOLERANCE:
            raise self._error(f"{key!r} in [{where}] must be a unit vector, not {value!r}")
        return (x, y, z)

    def _error(self, what: str) -> InvalidRobot:
        return InvalidRobot(f"{self._path}: {what}", source=self._path)
