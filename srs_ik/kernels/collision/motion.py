"""Bodies on the true chain at a posture, and along a straight line of joint angles between two postures.

Between two postures no point moves farther than the joints that carry it take it: each joint by its distance from the
point times its turn. Where a pair of bodies is farther apart than that, and what is to be left between them, the whole
stretch is clear; else it is halved.

Source: F. Schwarzer, M. Saha, J.-C. Latombe, Adaptive Dynamic Collision Checking for Single and Multiple Articulated
Robots in Complex Environments, T-RO 21(3), 2005.
"""

import math

from srs_ik.kernels.algebra.joint_vectors import along7
from srs_ik.kernels.algebra.lane_trig import seven_turns
from srs_ik.kernels.algebra.vectors import add, apply, load3, load9, norm, sub
from srs_ik.kernels.chain.kinematics import first_line, joint_line
from srs_ik.kernels.collision.forbidden import distance_of, fixed_clearance
from srs_ik.kernels.collision.seen import see_balls, see_group
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.collision import BASE, DRIFT, EXTENT, FORE, MARGIN, NO_GROUP, PLACE, TIP, UPPER, U, X, Y
from srs_ik.kernels.layout.limb import ELBOW_CENTRE, SHOULDER_CENTRE, TIP_POSITION, TIP_ROTATION, WRIST_IN_TIP

CLEAR = 0
HALVE = 1
HIT = 2

DEEPEST = 12
"""A stretch is halved so often at most."""

STILL_FRAME = ((1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0))


@kernel
def carried(P, q):
    """How rows are seen at a posture, in the base frame: those of `seen.frame_of`, and elbow and wrist centre."""
    turns = seven_turns(q)
    _, _, M, b = first_line(P, turns[0])
    _, _, M, b = joint_line(P, 1, turns[1], M, b)
    _, _, M, b = joint_line(P, 2, turns[2], M, b)
    upper = (M, b)
    centre = load3(P, ELBOW_CENTRE)
    elbow = add(apply(M, centre), b)
    _, _, M, b = joint_line(P, 3, turns[3], M, b)
    fore = (M, b)
    centre = add(load3(P, TIP_POSITION), apply(load9(P, TIP_ROTATION), load3(P, WRIST_IN_TIP)))
    wrist = add(apply(M, centre), b)
    _, _, M, b = joint_line(P, 4, turns[4], M, b)
    _, _, M, b = joint_line(P, 5, turns[5], M, b)
    _, _, M, b = joint_line(P, 6, turns[6], M, b)
    return ((STILL_FRAME, (M, b)), (upper, fore)), elbow, wrist


@kernel
def see_posture(P, q, world):
    """Look at the balls of all groups at a posture; frames for the rest, and shoulder, elbow and wrist centre."""
    frames, elbow, wrist = carried(P, q)
    still, turning = frames
    see_balls(world, 0, still, turning)
    return frames, (load3(P, SHOULDER_CENTRE), elbow, wrist)


@kernel
def reach_from(world, g, centre, drift):
    """Largest distance of a sphere's centre of a group from a point; on a near limb, from axes that miss it."""
    local = world.local
    return norm(sub((local[g, U], local[g, X], local[g, Y]), centre)) + local[g, EXTENT] + drift


@kernel
def moved_by(world, g, inner, centres, turns, drift):
    """How far joints outside of a place, that of the body that stands still, move the spheres of a group at most, m.

    The joints at each of the centres of shoulder, elbow and wrist turn by `turns` in sum, rad; their axes may miss it
    by the drift, m.
    """
    place = world.groups[g, PLACE]
    total = 0.0
    if place == TIP and inner != TIP:
        total = turns[2] * reach_from(world, g, centres[2], drift)
    if place != UPPER and place != BASE and inner != FORE and inner != TIP:
        # What turned at the wrist may be that much farther from the elbow by then.
        total += turns[1] * (reach_from(world, g, centres[1], drift) + total)
    if place != BASE and inner == BASE:
        total += turns[0] * (reach_from(world, g, centres[0], drift) + total)
    return total


@kernel
def is_outer(a, b):
    """Whether place a is farther out on the arm than place b."""
    return a != b and (b == BASE or a == TIP or (a == FORE and b == UPPER))


@kernel
def pair_motion(world, a, b, centres, turns, drift):
    """How far two groups may come closer to each other, m."""
    place_a, place_b = world.groups[a, PLACE], world.groups[b, PLACE]
    if place_a == place_b:
        return 0.0
    if is_outer(place_a, place_b):
        return moved_by(world, a, place_b, centres, turns, drift)
    return moved_by(world, b, place_a, centres, turns, drift)


@kernel
def look_at(P, q, world, turns, slack):
    """Whether pairs stay clear while joints turn so far from a posture at most: verdict, row of pairs, clearance."""
    frames, centres = see_posture(P, q, world)
    still, turning = frames
    pairs, margin = world.pairs, slack[MARGIN]
    verdict, pair, least = CLEAR, NO_GROUP, math.inf
    for k in range(pairs.shape[0]):
        a, b = pairs[k, 0], pairs[k, 1]
        apart = distance_of(world.local, a, b)
        if apart >= least:
            continue
        needed = margin + pair_motion(world, a, b, centres, turns, slack[DRIFT])
        if apart > needed:
            continue
        see_group(world, a, 0, still, turning)
        see_group(world, b, 0, still, turning)
        value = fixed_clearance(world, a, b, min(least, needed + 1e-9))
        if value > needed:
            continue
        verdict = max(verdict, HIT if value < margin else HALVE)
        if value < least:
            pair, least = k, value
    return verdict, pair, least


@kernel
def look_along(P, start, step, world, slack):
    """Whether a line of joint angles keeps clear: verdict, where on it (0 to 1), row of pairs, clearance there.

    What cannot be told on the shortest stretch counts as a hit.
    """
    shoulder = abs(step[0]) + abs(step[1]) + abs(step[2])
    wrist = abs(step[4]) + abs(step[5]) + abs(step[6])
    part, depth = 0, 0
    while True:
        half = 0.5 ** (depth + 1)
        middle = (2 * part + 1) * half
        turns = (half * shoulder, half * abs(step[3]), half * wrist)
        verdict, pair, least = look_at(P, along7(start, middle, step), world, turns, slack)
        if verdict == HIT or (verdict == HALVE and depth == DEEPEST):
            return HIT, middle, pair, least
        if verdict == HALVE:
            part, depth = 2 * part, depth + 1
            continue
        # On to the next stretch, as long as it may be.
        part += 1
        while depth > 0 and part % 2 == 0:
            part, depth = part // 2, depth - 1
        if depth == 0 and part > 0:
            return CLEAR, 0.0, NO_GROUP, math.inf
