"""What bodies leave of the intervals of a pose; of those of a near limb, by a bound.

At the same joint angles, the links of a near limb and of its nearest exact limb have the same orientation, and are no
farther apart than twice the misses of the axes that carry them: the drift. So the true posture is one of the exact limb
whose wrist is off by the drift at most. That turns its line shoulder-wrist, bends its elbow, and with these moves its
links by no more than is summed up here.
"""

import math

import numpy as np

from srs_ik.kernels.algebra.vectors import across, load3, norm, sub
from srs_ik.kernels.collision.arcs import add_all, add_arc, cut
from srs_ik.kernels.collision.forbidden import forbid
from srs_ik.kernels.collision.seen import frames_of_elbow, still_frames
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.collision import DRIFT, MARGIN, MOST_ARCS, REACH_FORE, REACH_UPPER
from srs_ik.kernels.layout.limb import AXES, ELBOW_CENTRE, FAR, FOREARM, NEAR, SHOULDER_CENTRE
from srs_ik.kernels.limb.triangle import elbow_at, elbow_bend, shoulder_to_wrist


@kernel
def bend_between(P, d, other):
    """Difference of the bends at two distances shoulder-wrist, as far as the limb reaches, rad."""
    c, s, _ = elbow_bend(P, d)
    c2, s2, _ = elbow_bend(P, min(max(other, P[NEAR]), P[FAR]))
    return abs(math.atan2(s, c) - math.atan2(s2, c2))


@kernel
def drifted(P, target, slack):
    """How far the links turning with the arm angle may be off, m, and the arm angle, rad: half a turn where by any."""
    drift = slack[DRIFT]
    if drift == 0.0:
        return 0.0, 0.0
    d = norm(shoulder_to_wrist(P, target.R, target.p))
    least = max(d - drift, P[NEAR])
    if drift >= d or least <= 0.0:
        return math.inf, math.pi
    bent = max(bend_between(P, d, d - drift), bend_between(P, d, d + drift))
    forearm = norm(across(load3(P, FOREARM), load3(P, AXES + 9)))
    turned = math.asin(drift / d) + bent * forearm / least
    reach = sub(load3(P, ELBOW_CENTRE), load3(P, SHOULDER_CENTRE))
    upper = norm(reach)
    off = max(slack[REACH_UPPER] * turned, (upper + slack[REACH_FORE]) * turned + slack[REACH_FORE] * bent) + drift
    elbow = upper * turned + drift
    from_line = elbow_from_line(P, target.place)
    return off, (math.asin(elbow / from_line) if elbow < from_line else math.pi)


@kernel
def elbow_from_line(P, place_):
    """Distance of the elbow centre from the line shoulder-wrist, the smaller of both elbows."""
    reach = sub(load3(P, ELBOW_CENTRE), load3(P, SHOULDER_CENTRE))
    least = math.inf
    for elbow in range(2):
        t = elbow_at(P, place_, elbow)[2][0]
        least = min(least, norm(across(reach, t)))
    return least


@kernel
def widened(arcs, n, by, free):
    """Widen every piece of a set by an angle at both ends; return how many pieces there are."""
    if by == 0.0 or n == 0:
        return n
    if by >= math.pi:
        return add_all(arcs)
    for i in range(n):
        free[i, 0], free[i, 1] = arcs[i, 0], arcs[i, 1]
    count = n
    n = 0
    for i in range(count):
        n = add_arc(arcs, n, 0.5 * (free[i, 0] + free[i, 1]), 0.5 * (free[i, 1] - free[i, 0]) + by)
    return n


@kernel
def forbidden_arcs(P, target, world, slack, arcs, counts, free):
    """Write the forbidden arm angles of both elbows into arcs (2, MOST_ARCS, 2), and how many pieces they are."""
    still = still_frames(P, target)
    off, wide = drifted(P, target, slack)
    for elbow in range(2):
        frames = frames_of_elbow(P, target, world, still, elbow)
        n = forbid(world, elbow, frames, slack[MARGIN] + off, arcs[elbow], free)
        counts[elbow] = widened(arcs[elbow], n, wide, free)


@kernel
def left_of(P, target, found, world, slack, out):
    """Write what bodies leave of intervals (n, 3) of a pose into rows of out; return how many there are then."""
    arcs, counts = np.empty((2, MOST_ARCS, 2)), np.zeros(2, np.int64)
    forbidden_arcs(P, target, world, slack, arcs, counts, np.empty((MOST_ARCS, 2)))
    return cut(found, found.shape[0], arcs, counts, out)
