"""What of a description was probably meant otherwise: figures in another unit than that of the format, or left out."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from typing import Any

from srs_ik.errors import listed, quoted
from srs_ik.robot.limb import SrsLimb
from srs_ik.robot.locked import ROUNDING
from srs_ik.robot.skeleton import limits_of

_WIDEST, _LARGEST = 16.0 * 2.0 * math.pi, 720.0
"""Limits farther apart than the first, rad, with figures up to the second are likely degrees; larger ones mean none."""

_LONG = 30.0
"""No arm is as long as this from shoulder over elbow to wrist, m; one of 3 cm is, in a file in millimetres."""


def odd_limits(limits: Mapping[str, tuple[float, float]]) -> list[str]:
    """What is odd about position limits of a description, rad, by joint: a clause for each kind."""
    wide = {
        name: upper - lower
        for name, (lower, upper) in limits.items()
        if upper - lower > _WIDEST and max(-lower, upper) <= _LARGEST
    }
    still = [name for name, range_ in limits.items() if range_ == (0.0, 0.0)]
    said = []
    if wide:
        said.append(
            f"limits are in radians, and those of {listed(list(wide))} are up to {max(wide.values()):g} rad apart, "
            "more than 16 turns: they look like degrees"
        )
    if still:
        said.append(f"{listed(still)} cannot move: lower and upper limit are 0, as where a file leaves them out")
    return said


def odd_size(limb: SrsLimb | None) -> list[str]:
    """That a limb is longer than any arm; at most one clause."""
    length = 0.0 if limb is None else limb.upper_arm + limb.forearm
    if length < _LONG:
        return []
    return [f"lengths are in metres, and the arm is {length:.4g} m long: are these millimetres?"]


def out_of_range(model: Any, joints: Iterable[str], locked: Mapping[str, float]) -> list[str]:
    """That joints of a model are locked where they cannot be: at zero, as nobody says where; at most one clause."""
    ranges = {name: limits_of(model, model.joints[model.getJointId(name)]) for name in joints if name not in locked}
    wrong = [
        f"{name} ({lower:g} to {upper:g})"
        for name, (lower, upper) in ranges.items()
        if not lower - ROUNDING <= 0.0 <= upper + ROUNDING
    ]
    return [f"locked at 0, where it cannot be: {listed(wrong)}; say where it is, by locked= or --lock"] if wrong else []


def tied_between(joints: Iterable[str], ties: Mapping[str, str], locked: Collection[str]) -> list[str]:
    """That joints between base and tip are tied to others, and stand at zero, as nobody says; at most one clause."""
    tied = [f"{name} {ties[name]}" for name in joints if name in ties and name not in locked]
    if not tied:
        return []
    return [f"on the way from base to tip {listed(tied)}, and is held at zero; say where it is, by locked= or --lock"]


def still_beyond(model: Any, last: str, joints: Iterable[str], tip: str, locked: Mapping[str, float]) -> list[str]:
    """That joints of a model between the last of an arm and its tip stand still, as nobody says; at most one clause.

    A hand moves its fingers; but an elbow that is behind what was taken for an arm shows that another arm was meant.
    """
    own = model.getJointId(last)
    beyond = [name for name in joints if name not in locked and own in model.supports[model.getJointId(name)]]
    if not beyond:
        return []
    return [
        f"the arm ends with {last}, and on the way to the tip {quoted(tip)} {listed(beyond)} stand"
        f"{'s' if len(beyond) == 1 else ''} still at zero: is this the arm that is meant?"
        " Say where they are by locked= or --lock, or name another tip"
    ]
