"""Whether a pose is reached at all, as early as it can be told.

Most poses that are reached show it at one of a few arm angles. Those that are not, and the others, are told by the
feasible arm angles of shoulder and wrist: whether any of one joint is one of the other.
"""

import math
from collections import namedtuple

import numpy as np

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.algebra.vectors import dot, load3, swing
from srs_ik.kernels.exact.events import TURN
from srs_ik.kernels.exact.flat import is_as_good_as_flat
from srs_ik.kernels.exact.gaps import fits
from srs_ik.kernels.exact.intervals import joint_pieces
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import limb as at
from srs_ik.kernels.layout.answer import GOOD_POSE, MAX_EVENTS, MAX_PIECES, MOST_INTERVALS, SOLVED
from srs_ik.kernels.layout.maps import NOT_REACHED, REACHED, UNSURE
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.limb.in_line import may_split
from srs_ik.kernels.limb.limits import is_inside, tighten
from srs_ik.kernels.limb.poses import read_pose
from srs_ik.kernels.limb.spherical import middle_angle
from srs_ik.kernels.limb.triangle import elbow_side, place

Room = namedtuple("Room", ("events", "marks", "shoulder", "wrist", "found", "wide"))
"""Work space of one thread: arm angles, the marks between them, pieces of both joints, intervals, a wider limb."""

HALF = math.sqrt(0.5)
PROBES = ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (HALF, HALF), (-HALF, HALF), (-HALF, -HALF), (HALF, -HALF))
"""Cosine and sine of the arm angles that are tried first."""

LOOKS = 3
"""Arm angles that are tried in each piece of the shoulder."""

MIDDLE_SLACK = 1e-9
"""Rounding of the cosine of a middle angle."""

WIDER = 1e-6
"""Limits farther out by this, rad, tell poses that rounding may have hidden: at a singular limit it is the root."""


@kernel
def room(family):
    """Work space for `reach`."""
    wide = np.empty((1, at.SIZE))
    tighten(row(family, at.LOOSE), NO_SEED, math.inf, WIDER, row(wide, 0))
    return Room(
        np.empty(MAX_EVENTS),
        np.empty(MAX_EVENTS, np.int64),
        np.empty((2, MAX_PIECES, 2)),
        np.empty((2, MAX_PIECES, 2)),
        np.empty((MOST_INTERVALS, 3)),
        wide,
    )


@kernel
def is_bent_right(P, place_, elbow):
    """Whether the elbow keeps its limits on one of its two sides."""
    c, s = place_[2], -place_[3] if elbow == 1 else place_[3]
    c4 = P[at.COS_STRAIGHT] * c - P[at.SIN_STRAIGHT] * s
    s4 = P[at.SIN_STRAIGHT] * c + P[at.COS_STRAIGHT] * s
    return is_inside(P, 3, c4, s4, P[at.SLACK_LIMIT])


@kernel
def middle_may_fit(P, k, circle, slack):
    """Whether the middle joint of a spherical joint can be inside its limits anywhere on a circle of R a3.

    Away from its phase on either side, the angle between axes 1 and 3 grows: limits within half a turn of the phase
    bound its cosine.
    """
    joint = int(P[k + at.FIRST_JOINT]) + 1
    low, high = P[at.LOWER + joint] - P[k + at.PHASE], P[at.UPPER + joint] - P[k + at.PHASE]
    if P[at.RANGE_KIND + joint] == 0.0 or low < -math.pi or high > math.pi:
        return True
    a1 = load3(P, k + at.A1)
    constant, c, s = dot(a1, circle[0]), dot(a1, circle[1]), dot(a1, circle[2])
    radius = math.sqrt(c * c + s * s)
    at_low, at_high = P[k + at.BOUND_2_LOWER], P[k + at.BOUND_2_UPPER]
    if constant + radius < min(at_low, at_high) - slack:
        return False
    return low <= 0.0 <= high or constant - radius <= max(at_low, at_high) + slack


@kernel
def may_be_met(P, place_, side, elbow):
    """Whether elbow and middle joints can be inside their limits on one side of the elbow."""
    return (
        is_bent_right(P, place_, elbow)
        and middle_may_fit(P, at.SHOULDER, side[1][0], MIDDLE_SLACK)
        and middle_may_fit(P, at.WRIST, side[2][0], MIDDLE_SLACK)
    )


@kernel
def fits_at(P, k, motion, cosine, sine):
    """Whether a solution of a spherical joint keeps the limits at an arm angle."""
    v0, y0, _ = motion
    v = swing(v0, cosine, sine)
    c, s, reached = middle_angle(P, k, v)
    if not reached:
        return False
    y = swing(y0, cosine, sine)
    return fits(P, k, v, y, c, s, 0) or fits(P, k, v, y, c, s, 1)


@kernel
def is_met_at(P, side, cosine, sine):
    """Whether shoulder and wrist keep their limits at an arm angle."""
    return fits_at(P, at.SHOULDER, side[1], cosine, sine) and fits_at(P, at.WRIST, side[2], cosine, sine)


@kernel
def is_met(P, side):
    """Whether one of the first arm angles is feasible."""
    for cosine, sine in PROBES:
        if fits_at(P, at.SHOULDER, side[1], cosine, sine) and fits_at(P, at.WRIST, side[2], cosine, sine):
            return True
    return False


@kernel
def is_met_in_pieces(P, side, pieces, n, sign):
    """Whether an arm angle inside the n pieces of the shoulder is feasible, of those that are looked at."""
    for i in range(n):
        lower, upper = pieces[sign, i, 0], pieces[sign, i, 1]
        for k in range(1, LOOKS + 1):
            psi = lower + (upper - lower) * k / (LOOKS + 1)
            if is_met_at(P, side, math.cos(psi), math.sin(psi)):
                return True
    return False


@kernel
def overlap(a, n_a, sign_a, b, n_b, sign_b, slack):
    """Whether any of n_a pieces of one solution meets any of n_b pieces of another, around the circle, and where."""
    for i in range(n_a):
        for j in range(n_b):
            for turns in range(-1, 2):
                lower = max(a[sign_a, i, 0], b[sign_b, j, 0] + turns * TURN)
                upper = min(a[sign_a, i, 1], b[sign_b, j, 1] + turns * TURN)
                if lower <= upper + slack:
                    return True, 0.5 * (lower + upper)
    return False, 0.0


@kernel
def shared_angle(P, side, s, space):
    """Whether shoulder and wrist share a feasible arm angle, and one of them.

    The pieces of the shoulder are in `space`; s is their number for each of its solutions.
    """
    w = joint_pieces(P, at.WRIST, side[2], 3, space.events, space.marks, space.wrist)
    for i in range(2):
        for j in range(2):
            some, psi = overlap(space.shoulder, s[i], i, space.wrist, w[j], j, P[at.SLACK_JOIN])
            if some:
                return True, psi
    return False, 0.0


@kernel
def shoulder_pieces(P, side, space):
    """Write the feasible arm angles of the shoulder's two solutions into `space`; how many pieces each has."""
    return joint_pieces(P, at.SHOULDER, side[1], 3, space.events, space.marks, space.shoulder)


@kernel
def any_overlap(P, side, space):
    """Whether shoulder and wrist share a feasible arm angle."""
    s = shoulder_pieces(P, side, space)
    return s[0] + s[1] > 0 and shared_angle(P, side, s, space)[0]


@kernel
def reach_side(P, wide, place_, side, elbow, space):
    """`reach` on one side of the elbow."""
    s = shoulder_pieces(wide, side, space)
    if s[0] + s[1] == 0:
        return NOT_REACHED
    bent = is_bent_right(P, place_, elbow)
    if bent and (
        is_met_in_pieces(P, side, space.shoulder, s[0], 0) or is_met_in_pieces(P, side, space.shoulder, s[1], 1)
    ):
        return REACHED
    some, psi = shared_angle(wide, side, s, space)
    if not some:
        return NOT_REACHED
    if bent and (is_met_at(P, side, math.cos(psi), math.sin(psi)) or any_overlap(P, side, space)):
        return REACHED
    return UNSURE


@kernel
def reach(family, place_, space):
    """Whether a posture of an exact limb inside the limits meets a pose: REACHED, NOT_REACHED or UNSURE.

    Unsure are poses that limits farther out by a trace would let be reached, and those next to singular ones that no
    interval reaches: there the whole search has to tell. `space` is that of `room`.
    """
    if abs(place_[5]) >= SOLVED:
        return NOT_REACHED
    # Rounding may hide a posture from the strict tolerances.
    P, wide = row(family, at.LOOSE), row(space.wide, 0)
    first = elbow_side(P, place_, 0)
    may_0 = may_be_met(wide, place_, first, 0)
    if may_0 and is_bent_right(P, place_, 0) and is_met(P, first):
        return REACHED
    second = elbow_side(P, place_, 1)
    may_1 = may_be_met(wide, place_, second, 1)
    if may_1 and is_bent_right(P, place_, 1) and is_met(P, second):
        return REACHED
    verdict_0 = reach_side(P, wide, place_, first, 0, space) if may_0 else NOT_REACHED
    if verdict_0 == REACHED:
        return REACHED
    verdict_1 = reach_side(P, wide, place_, second, 1, space) if may_1 else NOT_REACHED
    if verdict_1 == REACHED:
        return REACHED
    unsure = verdict_0 == UNSURE or verdict_1 == UNSURE
    return UNSURE if unsure or is_as_good_as_flat(place_) or may_split(P, place_) else NOT_REACHED


@kernel
def reach_poses(family, poses, first, last, out):
    """Write whether poses first to last - 1 of (N, 4, 4) are reached into out (N,), or minus a verdict."""
    space = room(family)
    for i in range(first, last):
        R, p, verdict = read_pose(row(poses, i))
        if verdict != GOOD_POSE:
            out[i] = -verdict
        else:
            out[i] = reach(family, place(row(family, at.LIMITED), R, p), space)
