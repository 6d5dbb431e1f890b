"""How far bodies have moved against each other between three postures of a curve, and whether they stay apart there."""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.vectors import add, apply, apply_transposed, norm, sub, times
from srs_ik.kernels.collision.forbidden import distance_of, fixed_clearance
from srs_ik.kernels.collision.motion import CLEAR, HALVE, HIT, carried
from srs_ik.kernels.collision.seen import frame_of, see_balls, see_group
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.collision import MARGIN

BEYOND = 1.25
"""How much farther than at the ends of a step bodies are taken to move within it."""

FARTHEST = 2.0
"""A rotation turns no two points of a ball farther than this many radii against each other."""


@kernel
def seen_from(world, a, b, frames):
    """Where the ball around a group is for one that carries group b, at a posture, and how it is turned."""
    still, turning = frames
    M_a, shift_a = frame_of(world, a, still, turning)
    M_b, shift_b = frame_of(world, b, still, turning)
    centre = (world.bodies[a, 0], world.bodies[a, 1], world.bodies[a, 2])
    back = (M_b[0], M_b[3], M_b[6], M_b[1], M_b[4], M_b[7], M_b[2], M_b[5], M_b[8])
    return apply_transposed(M_b, sub(add(apply(M_a, centre), shift_a), shift_b)), times(back, M_a)


@kernel
def turned(A, B):
    """How far a point of a ball of radius 1 moves from one rotation to another at most."""
    trace = 0.0
    for i in range(9):
        trace += A[i] * B[i]
    return math.sqrt(max(3.0 - trace, 0.0))


@kernel
def relative_motion(world, a, b, three):
    """How far points of one group move against another from the middle of a step on, at most, m."""
    before, middle, behind = three
    centre, turn = seen_from(world, a, b, middle)
    most = 0.0
    for end in (before, behind):
        there, other = seen_from(world, a, b, end)
        most = max(most, norm(sub(there, centre)) + world.bodies[a, 3] * min(turned(turn, other), FARTHEST))
    return BEYOND * most


@kernel
def look_between(P, postures, world, slack):
    """Whether all pairs stay clear in a step, given by three postures.

    Returns:
        The verdict; the least clearance in the middle where it is not clear, m; and how far that pair moves, m.
    """
    before, _, _ = carried(P, postures[0])
    middle, _, _ = carried(P, postures[1])
    behind, _, _ = carried(P, postures[2])
    three = (before, middle, behind)
    still, turning = middle
    see_balls(world, 0, still, turning)
    pairs, margin = world.pairs, slack[MARGIN]
    verdict, least, moved = CLEAR, math.inf, 0.0
    for k in range(pairs.shape[0]):
        a, b = pairs[k, 0], pairs[k, 1]
        apart = distance_of(world.local, a, b)
        if apart >= least:
            continue
        moving = relative_motion(world, a, b, three)
        if apart > margin + moving:
            continue
        see_group(world, a, 0, still, turning)
        see_group(world, b, 0, still, turning)
        value = fixed_clearance(world, a, b, min(least, margin + moving + 1e-9))
        if value > margin + moving:
            continue
        verdict = max(verdict, HIT if value < margin else HALVE)
        if value < least:
            least, moved = value, moving
    return verdict, least, moved
