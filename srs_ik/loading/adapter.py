"""A ready adapter, ``robot.toml``, for an arm that was recognised in some description."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from srs_ik.errors import InvalidRobot, listed
from srs_ik.robot.arguments import check_path, check_xacro_args
from srs_ik.robot.card import RobotCard, read_card
from srs_ik.robot.description.files import label_of
from srs_ik.robot.limb import SrsLimb, Vector
from srs_ik.robot.sides import side_of
from srs_ik.robot.sources import card_of, places_of
from srs_ik.system.writing import write_whole

if TYPE_CHECKING:
    from srs_ik.arm import Arm

_SHORT = 1e-3
"""A hand shorter than this, metres, shows no direction."""

_WRITTEN = 12
"""Digits of a direction; with fewer it would not be a unit vector."""


def write_adapter(path: str | Path, source: str | Path, arm: Arm, xacro_args: Mapping[str, str] | None = None) -> None:
    """Write an adapter that `load` takes, with the frame conventions of an arm and a comment at each line to check.

    Side, limits and arguments of xacro of an adapter from which the arm was loaded are kept.

    Args:
        path: the file to write; it must not exist.
        source: name, path or address from which the arm was loaded.
        arm: the arm.
        xacro_args: arguments with which a xacro file was read.

    Raises:
        InvalidRobot: the file exists, its name does not end in ``.toml``, or it cannot be written; or the source is an
            adapter with a tool or a mount, whose frames no description has.
    """
    check_path("path", path)
    check_xacro_args(xacro_args)
    path = Path(path)
    if path.suffix != ".toml":
        raise InvalidRobot(
            f"an adapter is a file whose name ends in .toml, such as robot.toml, not {label_of(path)}", path
        )
    card = card_of(source)
    if card is not None and (card.tool or card.mount):
        lost = listed([f"[{name}]" for name in ("tool", "mount") if getattr(card, name)])
        raise InvalidRobot(f"{label_of(Path(source))} is an adapter with {lost}: copy it, and change the copy", path)
    places = [_as_written(place, path.absolute().parent) for place in places_of(source)]
    text = _text(arm, places, {**(card.xacro if card else {}), **(xacro_args or {})}, card)
    try:
        write_whole(path, text, replace=False)
    except FileExistsError:
        raise InvalidRobot(f"{label_of(path)} exists already; it is not overwritten", path) from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InvalidRobot(f"cannot write {label_of(path)}: {reason}", path) from error


def names_xacro(path: str | Path) -> bool:
    """True if a description that an adapter names is a xacro file, as far as its place says so."""
    return any(map(_is_xacro, read_card(path).places))


def hand_axes(limb: SrsLimb) -> tuple[Vector, Vector]:
    """Grasp and pronosupination direction, (3,) unit vectors in the tip frame, of a hand as one would draw it.

    That is out from the wrist to the tip, and turned as the axis of the elbow at zero. Where the tip lies in the wrist,
    it goes on along the forearm, or along the last axis of an XYX wrist.
    """
    R_tip_base = limb.T_base_tip_zero[:3, :3].T
    reach = limb.T_base_tip_zero[:3, 3] - limb.wrist
    if np.linalg.norm(reach) < _SHORT:
        reach = limb.wrist - limb.elbow
        if limb.wrist_kind == "XYX":
            reach = limb.axes[6] * np.copysign(1.0, limb.axes[6] @ reach)
    grasp = _unit(R_tip_base @ reach)
    candidates = [R_tip_base @ limb.axes[k] for k in (3, 5, 0)] + list(np.eye(3))
    across = next(c for c in candidates if np.linalg.norm(np.cross(grasp, c)) > 0.3)
    return grasp, _unit(across - grasp * (grasp @ across))


def _unit(vector: Vector) -> Vector:
    vector = vector / np.linalg.norm(vector)
    # Rounding that is not worth a digit in a file that people read.
    vector = np.where(np.abs(vector) < 1e-10, 0.0, vector)
    return vector / np.linalg.norm(vector)


def _as_written(place: str, folder: Path) -> str:
    if "://" in place:
        return place
    return Path(os.path.relpath(place, folder)).as_posix()


def _text(arm: Arm, places: list[str], xacro_args: Mapping[str, str], card: RobotCard | None) -> str:
    grasp, across = arm.hand or hand_axes(arm.limb)
    urdf = _string(places[0]) if len(places) == 1 else f"[{', '.join(map(_string, places))}]"
    side = card.side if card else side_of((arm.base, arm.tip, *arm.joint_names))
    corrected = {name for name in arm.joint_names if card and name in card.limits}
    # Whoever gets the adapter from somebody has to say that the program may run.
    xacro = "; a program: allow_xacro=True, --allow-xacro" if any(map(_is_xacro, places)) else ""
    lines = [
        "# Adapter of an arm: srs_ik.load() and srs-ik take this file. Check every line that says 'check'.",
        f"name = {_string(arm.name)}",
        f"urdf = {urdf}  # relative to this file{xacro}",
        f'side = "{side}"  # of a body: left, right or either; check',
        "",
        "[frames]",
        f"base = {_string(arm.base)}  # poses are given in this frame",
        f"tip = {_string(arm.tip)}  # poses are those of this frame; check",
        "",
        "[arm_angle]",
        f"reference = {_vector(arm.limb.reference)}  # in the base frame; arm angle 0: the elbow lies there",
        "",
        "[hand]  # in the tip frame",
        f"grasp = {_vector(grasp)}  # the direction in which the hand reaches out; check",
        f"pronosupination = {_vector(across)}  # across it; check",
    ]
    if arm.locked:
        lines += ["", "[locked]  # where joints stand that are no part of the arm: rad or m"]
        lines += [f"{_string(key)} = {_number(value)}" for key, value in arm.locked.items()]
    if xacro_args:
        lines += ["", "[xacro]  # arguments of the xacro file"]
        lines += [f"{_string(key)} = {_string(value)}" for key, value in xacro_args.items()]
    lines += ["", "# A tool that the description lacks, in the tip frame (metres, and radians as in a URDF):"]
    lines += ["# [tool]", "# xyz = [0.0, 0.0, 0.1]", "# rpy = [0.0, 0.0, 0.0]"]
    lines += ['# name = "gripper"  # of the new tip frame; without it "tool", or "tool_2" where the robot has that']
    lines += ["", "# Where the base frame stands in the room:"]
    lines += ["# [mount]", "# xyz = [0.0, 0.0, 0.0]", "# rpy = [0.0, 0.0, 0.0]"]
    lines += ['# name = "table"  # of the new base frame; without it "world", or "world_2" where the robot has that']
    lines += ["# gravity = [0.0, 0.0, -9.81]  # in the room, m/s^2; without it, gravity turns with the arm"]
    lines += ["", "# Limits as they are read, to be corrected (rad, rad/s, N m, rad/s^2; inf for none):"]
    lines += ["[limits]" if corrected else "# [limits]"]
    for k, joint in enumerate(arm.joint_names):
        figures = zip(
            ("lower", "upper", "velocity", "effort", "acceleration"),
            (arm.lower[k], arm.upper[k], arm.velocity_limit[k], arm.effort_limit[k], arm.acceleration_limit[k]),
            strict=True,
        )
        values = ", ".join(f"{key} = {_number(value)}" for key, value in figures)
        lines.append(f"{'' if joint in corrected else '# '}{_string(joint)} = {{ {values} }}")
    return "\n".join(lines) + "\n"


def _is_xacro(place: str) -> bool:
    return place.endswith(".xacro")


def _string(text: str) -> str:
    """A TOML string; its escapes are those of JSON."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _vector(values: Iterable[float]) -> str:
    return "[" + ", ".join(_number(round(float(x), _WRITTEN)) for x in values) + "]"


def _number(value: float) -> str:
    value = float(value) + 0.0
    return ("inf" if value > 0.0 else "-inf") if math.isinf(value) else repr(value)
