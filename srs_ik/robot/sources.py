"""What a robot may be given as: a known name, a file, an address, XML text, or the object of another library."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from srs_ik.errors import InvalidRobot, did_you_mean, listed, quoted
from srs_ik.inputs.numbers import as_flag
from srs_ik.robot import zoo
from srs_ik.robot.arguments import check_path, check_xacro_args
from srs_ik.robot.card import Placement, RobotCard, read_card
from srs_ik.robot.description import RobotModel, load_model
from srs_ik.robot.description.model import is_xml
from srs_ik.robot.limb import Vector
from srs_ik.robot.locked import as_locked
from srs_ik.robot.places import DESCRIPTION, Found, described_names, is_fetched, locate, missing


@dataclass(frozen=True)
class NamedRobot:
    """A robot that `load` knows by name."""

    name: str  # what `load` takes
    description: str  # one line for lists
    base: str  # name of its base frame
    tip: str  # name of its tip frame
    origin: str  # where its description comes from
    install: str = ""  # what has to be done before it can be loaded, a pip command where one will do; empty if nothing
    fetched: bool = False  # whether its description comes over the network on first use


@dataclass(frozen=True, eq=False)
class Description:
    """A robot, and how it is meant to be used as far as its source says so."""

    robot: RobotModel  # the model of the whole robot
    name: str  # name for an arm of it
    base: str | None = None  # name of the intended base frame, or None
    tip: str | None = None  # name of the intended tip frame, or None
    reference: Vector | None = None  # (3,) arm-angle reference in the frame `base`, or None
    hand: Vector | None = None  # (2, 3) grasp and pronosupination direction in the frame `tip`, or None
    # limits that are not those of the model, by joint
    limits: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    locked: Mapping[str, float] = field(
        default_factory=dict
    )  # where joints stand that are no part of the arm, rad or m
    tool: Placement | None = None  # frame of a tool in the frame `tip`, or None
    mount: Placement | None = None  # the frame `base` in its surroundings, or None


def robots() -> list[str]:
    """Names of the robots that can be loaded without a file: the built-in ones, then those that come from elsewhere.

    The descriptions of robot_descriptions are not among them; their names end in ``_description``.
    """
    return [*zoo.robots(), *zoo.adapters()]


def catalogue() -> list[NamedRobot]:
    """The robots of `robots`, in its order, each with whether it can be loaded in this installation."""
    return [_entry(zoo.card(name)) for name in robots()]


def _entry(card: RobotCard) -> NamedRobot:
    description = card.sources.get("description")
    origin = description.url if description else "this package"
    install = missing(card.places, card.name)
    if "ROS_PACKAGE_PATH" in install:
        install = f"git clone {origin}, and put the folder in which you do on ROS_PACKAGE_PATH"
    fetched = not install and is_fetched(card.places[0])
    return NamedRobot(card.name, card.description, card.base, card.tip, origin, install, fetched)


def describe(
    source: Any, urdf: Any = None, xacro_args: Mapping[str, str] | None = None, allow_xacro: bool = False
) -> Description:
    """Read a robot from anything that `load` takes.

    A xacro file is a program. One is run where it is named as such by `source` or `urdf`, or stands behind a name that
    this package or robot_descriptions knows; one that somebody's adapter names is run only if that is allowed.

    Args:
        source: a name, the path of an adapter (``.toml``) or an address; else path, text or object as in
            `srs_ik.robot.description.load_model`. A name wins over a file of that name in the working directory; a path
            object is always a file.
        urdf: what the description of a robot with a name or an adapter is, if not what they say.
        xacro_args: arguments of a xacro file, beside those of an adapter.
        allow_xacro: whether to run a xacro file that an adapter names.

    Raises:
        InvalidRobot: there is no such robot or file, the description is faulty, or it is a xacro file that nobody has
            asked to run.
        MissingExtra: the name needs a package that is not installed.
    """
    check_xacro_args(xacro_args)
    may_run = as_flag(allow_xacro, "allow_xacro", InvalidRobot)
    card = card_of(source)
    if card is not None:
        return _of_card(card, urdf, xacro_args, may_run or _is_known(source))
    if urdf is not None:
        raise InvalidRobot("urdf= is the description of a robot that is given by its name or by an adapter")
    if isinstance(source, str) and not is_xml(source):
        if "://" in source:
            return _at(source, xacro_args)
        if not _is_path(source):
            if not source.endswith(DESCRIPTION):
                raise _unknown(source)
            return _at(f"robot_descriptions://{source}", xacro_args)
    robot = load_model(source, xacro_args)
    return Description(robot, robot.name)


def places_of(source: str | os.PathLike[str]) -> tuple[str, ...]:
    """Where the description behind a name, path or address may be, as a card says it.

    Raises:
        InvalidRobot: a text is no name, path or address, or the source is of another kind.
    """
    check_path("source", source)
    card = card_of(source)
    if card is not None:
        return card.places
    if isinstance(source, str) and not _is_path(source):
        if is_xml(source):
            raise InvalidRobot("a text has no place; write it into a file first")
        return (f"robot_descriptions://{source}",)
    return (source,) if isinstance(source, str) and "://" in source else (str(Path(source).absolute()),)


def _is_known(source: Any) -> bool:
    """True for the name of a robot of this package."""
    return isinstance(source, str) and not is_xml(source) and source in (*zoo.robots(), *zoo.adapters())


def card_of(source: Any) -> RobotCard | None:
    """The card that a source is or has, or None."""
    if _is_known(source):
        return zoo.card(source)
    if isinstance(source, str | os.PathLike) and not (isinstance(source, str) and is_xml(source)):
        path = Path(source)
        if path.suffix == ".toml":
            return read_card(path)
    return None


def _of_card(card: RobotCard, urdf: Any, xacro_args: Mapping[str, str] | None, allow_xacro: bool) -> Description:
    if urdf is None:
        found = _located(card)
        if found.path.suffix == ".xacro" and not allow_xacro:
            message = (
                f"the adapter of {card.name!r} names the xacro file {found.path}, which is a program: if you trust it, "
                "allow_xacro=True or --allow-xacro runs it"
            )
            raise InvalidRobot(message, card.name)
        arguments = _arguments(found.path, xacro_args, {**found.xacro_args, **card.xacro})
        robot = load_model(found.path, arguments, found.packages)
    else:
        robot = load_model(urdf, _arguments(urdf, xacro_args, card.xacro))
    return Description(
        robot=robot,
        name=card.name,
        base=card.base,
        tip=card.tip,
        reference=None if card.reference is None else np.array(card.reference),
        hand=None if card.grasp is None else np.array([card.grasp, card.pronosupination]),
        limits=card.limits,
        locked=as_locked(card.locked, robot.model, robot.followers),
        tool=card.tool,
        mount=card.mount,
    )


def _located(card: RobotCard) -> Found:
    """The description of a card; where it is not here, the error says where it comes from."""
    try:
        return locate(card.places, card.name)
    except InvalidRobot as error:
        origin = card.sources.get("description")
        if origin is None:
            raise
        own = f"load({card.name!r}, urdf=...) takes a file of your own"
        raise InvalidRobot(f"{error}; {card.name!r} comes from {origin.url}, and {own}", card.name) from error


def _at(place: str, xacro_args: Mapping[str, str] | None) -> Description:
    found = locate([place], place.rpartition("://")[2])
    robot = load_model(found.path, _arguments(found.path, xacro_args, found.xacro_args), found.packages)
    return Description(robot, robot.name)


def _arguments(source: Any, asked: Mapping[str, str] | None, usual: Mapping[str, str]) -> Mapping[str, str] | None:
    """Arguments of a xacro file: those that are asked for, and for the rest the usual ones, which only it has."""
    return (
        {**usual, **(asked or {})}
        if isinstance(source, str | os.PathLike) and os.fspath(source).endswith(".xacro")
        else asked
    )


def _is_path(text: str) -> bool:
    separators = [separator for separator in (os.sep, os.altsep) if separator]
    if any(separator in text for separator in separators) or Path(text).suffix:
        return True
    try:
        return bool(text) and Path(text).exists()
    except (OSError, ValueError):
        return False


def _unknown(name: str) -> InvalidRobot:
    known = robots()
    described = {described.removesuffix(DESCRIPTION): described for described in described_names()}
    hint = did_you_mean(described.get(name, name), [*known, *described.values()])
    made = [each for each in known if not hint and name.casefold() in zoo.card(each).description.casefold().split()]
    hint = hint or (f" (perhaps {listed(made)})" if made else "")
    return InvalidRobot(
        f"{quoted(name)} is neither a file nor the name of a robot{hint}; there are {listed(known)}; "
        f"others have a path, or NAME{DESCRIPTION}",
        name,
    )
