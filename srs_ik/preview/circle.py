"""The circle on which the elbow can lie while the tip stays, and the feasible arm angles as arcs around it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from srs_ik.preview import palette, solids
from srs_ik.preview.robot import reach
from srs_ik.preview.solids import Solid
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.arm import Arm
    from srs_ik.solve.intervals import Interval

_POINT = 1e-3
"""A circle smaller than this share of the arm's reach is a point: the arm is stretched."""


class ElbowCircle(NamedTuple):
    """In the base frame, metres; on a near limb within millimetres."""

    centre: Array
    across: Array  # unit vector to where the elbow is at arm angle zero
    axis: Array  # unit vector from shoulder to wrist
    radius: float


def elbow_circle(arm: Arm, q: Array) -> ElbowCircle | None:
    """The circle of the elbow at a configuration; None if the arm is stretched, so that there is none."""
    zero, now = arm.joint_frames(np.zeros(7)), arm.joint_frames(q)

    def carried(joint: int, point: Array) -> Array:
        return (now[joint] @ np.linalg.inv(zero[joint]) @ [*point, 1.0])[:3]

    shoulder, elbow, wrist = arm.limb.shoulder, carried(3, arm.limb.elbow), carried(4, arm.limb.wrist)
    length = float(np.linalg.norm(wrist - shoulder))
    smallest = _POINT * reach(arm)
    if length < smallest:
        return None
    axis = (wrist - shoulder) / length
    centre = shoulder + axis * (axis @ (elbow - shoulder))
    radius = float(np.linalg.norm(elbow - centre))
    if radius < smallest:
        return None
    back = Rotation.from_rotvec(-arm.arm_angle(q) * axis)
    return ElbowCircle(centre, back.apply((elbow - centre) / radius), axis, radius)


def circle_solids(arm: Arm, q: Array) -> list[Solid]:
    """The circle; nothing where the arm is stretched."""
    circle = elbow_circle(arm, q)
    if circle is None:
        return []
    thickness = 0.0035 * reach(arm)
    line = solids.ring(circle.centre, circle.across, circle.axis, circle.radius, 0.0, 2.0 * np.pi, thickness)
    return [Solid(line, palette.CIRCLE)]


def arc_solids(
    arm: Arm, q: Array, intervals: Sequence[Interval], taken: Sequence[Interval] = ()
) -> dict[int, list[Solid]]:
    """For each branch that has any, its intervals as arcs in the plane of the circle, each branch a step farther out.

    `q` is any configuration of their pose; arcs `taken`, at which bodies meet, are dark and thin beside the others.
    """
    circle = elbow_circle(arm, q)
    if circle is None:
        return {}
    thickness, step = 0.006 * reach(arm), 0.02 * reach(arm)
    arcs: dict[int, list[Solid]] = {}
    branches = sorted({interval.branch for interval in (*intervals, *taken)})
    for interval in (*intervals, *taken):
        radius = circle.radius + step * (1.5 + branches.index(interval.branch))
        free = not any(interval is other for other in taken)
        thick, colour = (thickness, palette.BRANCHES[interval.branch]) if free else (0.4 * thickness, palette.FORBIDDEN)
        arc = solids.ring(circle.centre, circle.across, circle.axis, radius, interval.lower, interval.upper, thick)
        arcs.setdefault(interval.branch, []).append(Solid(arc, colour))
    return arcs
