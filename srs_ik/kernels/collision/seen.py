"""Bodies as they are seen from the line shoulder-wrist: along it, and across it at arm angle zero."""

from __future__ import annotations

import math
from typing import NamedTuple

from srs_ik.kernels.algebra.vectors import apply, cross, dot, load3, rotation, scale, sub, times
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import collision as at
from srs_ik.kernels.layout.limb import AXES, ELBOW_CENTRE, SHOULDER_CENTRE, TIP_POSITION
from srs_ik.kernels.limb.triangle import elbow_at


class World(NamedTuple):
    """The tables of bodies, and work space for how they are seen."""

    bodies: object  # (rows, BODY_ROW), the balls around the groups first
    groups: object  # (G, GROUP) integers
    pairs: object  # (n, 2) groups that may meet; one that turns is the first
    local: object  # (rows, LOCAL_ROW) work space: the rows as they are seen
    ready: object  # (G,) integers, work space: for which elbow the rows of a group are seen


STILL = 3
"""In `ready`: seen for both elbows."""


@kernel
def still_frames(P, target):
    """How rows at the base and at the tip are seen: matrix and shift of each."""
    t, h0, _, _, hand, _ = target.place
    b0 = cross(t, h0)
    M = (t[0], t[1], t[2], h0[0], h0[1], h0[2], b0[0], b0[1], b0[2])
    shoulder = load3(P, SHOULDER_CENTRE)
    moved = sub(sub(target.p, apply(hand, load3(P, TIP_POSITION))), shoulder)
    return (M, scale(-1.0, apply(M, shoulder))), (times(M, hand), apply(M, moved))


@kernel
def turning_frames(P, place_, elbow):
    """How rows of the upper arm and of the forearm are seen at arm angle zero: matrix and shift of each."""
    c4, s4, (t, h, n) = elbow_at(P, place_, elbow)
    # The normal of the arm is h x t.
    M = (t[0], t[1], t[2], h[0], h[1], h[2], -n[0], -n[1], -n[2])
    shoulder = load3(P, SHOULDER_CENTRE)
    bend = rotation(load3(P, AXES + 9), c4, s4)
    joint = load3(P, ELBOW_CENTRE)
    moved = sub(sub(joint, apply(bend, joint)), shoulder)
    return (M, scale(-1.0, apply(M, shoulder))), (times(M, bend), apply(M, moved))


@kernel
def see(world, i, frame):
    """Look at one row of spheres."""
    bodies, local = world.bodies, world.local
    M, b = frame
    v = apply(M, (bodies[i, 0], bodies[i, 1], bodies[i, 2]))
    local[i, at.U] = v[0] + b[0]
    local[i, at.X] = v[1] + b[1]
    local[i, at.Y] = v[2] + b[2]
    local[i, at.RHO] = math.sqrt(local[i, at.X] * local[i, at.X] + local[i, at.Y] * local[i, at.Y])
    local[i, at.EXTENT] = bodies[i, 3]


@kernel
def see_plane(world, i, frame):
    """Look at one plane of a solid at the base."""
    bodies, local = world.bodies, world.local
    M, b = frame
    v = apply(M, (bodies[i, 0], bodies[i, 1], bodies[i, 2]))
    local[i, at.U], local[i, at.X], local[i, at.Y] = v
    local[i, at.RHO] = math.sqrt(v[1] * v[1] + v[2] * v[2])
    local[i, at.EXTENT] = bodies[i, 3] + dot(v, b)


@kernel
def see_rows(world, g, stamp, frame):
    """Look at the rows of a group, unless that has been done."""
    if world.ready[g] == stamp:
        return
    world.ready[g] = stamp
    planes = world.groups[g, at.KIND] == at.PLANES
    for i in range(world.groups[g, at.FIRST], world.groups[g, at.LAST]):
        if planes:
            see_plane(world, i, frame)
        else:
            see(world, i, frame)


@kernel
def is_turning(world, g):
    """Whether a group turns with the arm angle."""
    return world.groups[g, at.PLACE] >= at.UPPER


@kernel
def frame_at(place, still, turning):
    """How rows of a place are seen."""
    if place == at.BASE:
        return still[0]
    if place == at.TIP:
        return still[1]
    return turning[1] if place == at.FORE else turning[0]


@kernel
def frame_of(world, g, still, turning):
    """How the rows of a group are seen."""
    return frame_at(world.groups[g, at.PLACE], still, turning)


@kernel
def see_group(world, g, elbow, still, turning):
    """Look at the rows of a group, unless that has been done for this elbow."""
    stamp = elbow + 1 if is_turning(world, g) else STILL
    see_rows(world, g, stamp, frame_of(world, g, still, turning))


@kernel
def see_balls(world, elbow, still, turning):
    """Look at the balls around the groups: at all of them for the first elbow, then at those that turn."""
    for g in range(world.groups.shape[0]):
        if elbow == 0:
            world.ready[g] = 0
        if elbow == 0 or is_turning(world, g):
            see(world, g, frame_of(world, g, still, turning))


@kernel
def frames_of_elbow(P, target, world, still, elbow):
    """How rows are seen with an elbow, that still and turning, once the balls around the groups are looked at."""
    turning = turning_frames(P, target.place, elbow)
    see_balls(world, elbow, still, turning)
    return still, turning


@kernel
def frames_of_either(P, target, world, elbow):
    """The same with one elbow alone: what stands still is seen with the first one."""
    still = still_frames(P, target)
    frames = frames_of_elbow(P, target, world, still, 0)
    return frames_of_elbow(P, target, world, still, 1) if elbow == 1 else frames
