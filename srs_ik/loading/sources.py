"""What a robot may be given as: a known name, a file, XML text, or the object of another library."""

from __future__ import annotations

import importlib
import os
import pkgutil
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from srs_ik import zoo
from srs_ik.errors import InvalidRobot, MissingExtra, did_you_mean, listed
from srs_ik.limb import Vector
from srs_ik.urdf import RobotModel, load_model
from srs_ik.urdf.model import is_xml

_HUMAN_FILE = Path("share", "example-robot-data", "robots", "human_description", "robots", "human.urdf")
_HUMANS = {f"human_{side}": (f"{side}_clavicle", f"{side}_hand") for side in ("left", "right")}
# At zero the arm of this model hangs down: -y points along the fingers, z along the axis of the elbow.
_HUMAN_HAND = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, 1.0]])

_DESCRIPTION = "_description"


@dataclass(frozen=True)
class NamedRobot:
    """A robot that `load` knows by name.

    Attributes:
        name: what `load` takes.
        description: one line for lists.
        base: name of its base frame.
        tip: name of its tip frame.
        install: the pip command without which it cannot be loaded; empty if nothing is missing.
    """

    name: str
    description: str
    base: str
    tip: str
    install: str = ""


@dataclass(frozen=True, eq=False)
class Description:
    """A robot, and how it is meant to be used as far as its source says so.

    Attributes:
        robot: the model of the whole robot.
        name: name for an arm of it.
        base: name of the intended base frame, or None.
        tip: name of the intended tip frame, or None.
        reference: (3,) arm-angle reference in the frame `base`, or None.
        hand: (2, 3) grasp and pronosupination direction in the frame `tip`, or None.
    """

    robot: RobotModel
    name: str
    base: str | None = None
    tip: str | None = None
    reference: Vector | None = None
    hand: Vector | None = None


def robots() -> list[str]:
    """Names of the robots that can be loaded without a file: the built-in ones, then those of the extra ``robots``.

    The descriptions of robot_descriptions are not among them; their names end in ``_description``.
    """
    return [*zoo.robots(), *_HUMANS]


def catalogue() -> list[NamedRobot]:
    """The robots of `robots`, in its order, each with whether it can be loaded in this installation.

    Raises:
        InvalidRobot: the card of a built-in robot is damaged.
    """
    cards = [zoo.card(name) for name in zoo.robots()]
    entries = [NamedRobot(card.name, card.description, card.base, card.tip) for card in cards]
    for name, (base, tip) in _HUMANS.items():
        try:
            _human_file(name)
            install = ""
        except MissingExtra as error:
            install = error.command
        side = name.removeprefix("human_").capitalize()
        entries.append(NamedRobot(name, f"{side} arm of the human of example-robot-data", base, tip, install))
    return entries


def describe(source: Any) -> Description:
    """Read a robot from anything that `load` takes.

    Args:
        source: a name; else path, text or object as in `srs_ik.urdf.load_model`. A name wins over a file of that name
            in the working directory; a path object is always a file.

    Raises:
        InvalidRobot: there is no such robot or file, or the description is faulty.
        MissingExtra: the name needs a package that is not installed.
    """
    if isinstance(source, str) and not is_xml(source):
        if source in zoo.robots():
            card = zoo.card(source)
            hand = np.array([card.grasp, card.pronosupination])
            reference = np.array(card.reference)
            return Description(load_model(card.urdf), card.name, card.base, card.tip, reference, hand)
        if source in _HUMANS:
            base, tip = _HUMANS[source]
            return Description(load_model(_human_file(source)), source, base, tip, hand=_HUMAN_HAND)
        if not _is_path(source):
            source = _described_file(source)
    robot = load_model(source)
    return Description(robot, robot.name)


def _is_path(text: str) -> bool:
    separators = [separator for separator in (os.sep, os.altsep) if separator]
    if any(separator in text for separator in separators) or Path(text).suffix:
        return True
    try:
        return bool(text) and Path(text).exists()
    except (OSError, ValueError):
        return False


def _human_file(name: str) -> Path:
    """The file of example-robot-data, which installs no Python module that could be asked for it."""
    for path in _data_files():
        if path.is_file():
            return path
    raise MissingExtra("robots", f"the robot {name!r}")


def _data_files() -> Iterator[Path]:
    # Pip and conda both put it below the prefix in which they put Pinocchio's libraries.
    prefixes = [*Path(pin.__file__).resolve().parents, Path(sys.prefix)]
    yield from (prefix / _HUMAN_FILE for prefix in prefixes)
    try:
        files = metadata.files("example-robot-data") or ()
    except metadata.PackageNotFoundError:
        return
    yield from (Path(str(file.locate())) for file in files if file.match(str(_HUMAN_FILE)))


def _described_file(name: str) -> Path:
    """The URDF file of a name that is neither built in nor a file: one of robot_descriptions, if anything."""
    if not name.endswith(_DESCRIPTION):
        raise _unknown(name, robots())
    try:
        package = importlib.import_module("robot_descriptions")
    except ImportError:
        raise MissingExtra("robots", f"the robot {name!r} of robot_descriptions") from None
    known = [module.name for module in pkgutil.iter_modules(package.__path__) if module.name.endswith(_DESCRIPTION)]
    if name not in known:
        raise _unknown(name, known)
    try:
        path = getattr(importlib.import_module(f"robot_descriptions.{name}"), "URDF_PATH", None)
    except Exception as error:
        # The module fetches its files on import, which fails in as many ways as there are networks.
        reason = str(error).strip().partition("\n")[0] or type(error).__name__
        raise InvalidRobot(f"the files of {name!r} could not be fetched: {reason}", name) from error
    if path is None:
        raise InvalidRobot(f"robot_descriptions has {name!r} in other formats than URDF only", name)
    return Path(path)


def _unknown(name: str, known: list[str]) -> InvalidRobot:
    shown = name if len(name) <= 80 else name[:77] + "..."
    hint = did_you_mean(name, known)
    return InvalidRobot(f"{shown!r} is neither a file nor the name of a robot{hint}; there are {listed(known)}", shown)
