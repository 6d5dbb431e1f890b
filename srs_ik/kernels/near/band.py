"""How far the true chain of a near limb may be from its nearest exact limb: the shift, and the band that it makes."""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.joint_vectors import difference
from srs_ik.kernels.algebra.lane_trig import turn, turns_of
from srs_ik.kernels.algebra.lanes import ALL, eight_of
from srs_ik.kernels.algebra.pointers import copy
from srs_ik.kernels.algebra.vectors import dot, load3
from srs_ik.kernels.chain.eight import highest
from srs_ik.kernels.chain.kinematics import forward_kinematics, tip_frame
from srs_ik.kernels.chain.newton import arm_angle
from srs_ik.kernels.chain.shoulder_turns import count_met, count_postures
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import limb as at
from srs_ik.kernels.limb.branches import branch_of, side_posture
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.limb.in_line import ROUNDED
from srs_ik.kernels.limb.limits import beyond, set_joint_limits, set_limit, turn_to_middle
from srs_ik.kernels.limb.postures_eight import eight_postures
from srs_ik.kernels.limb.surface import level_place
from srs_ik.kernels.limb.triangle import elbow_side, place, shoulder_to_wrist

WIDEST_BAND = 0.3
WIDEST_OUTER = 0.6
"""Wider bands, of joints 2, 4 and 6 and of the others, tell too little."""

WIDER = 2.0
"""Where shoulder and wrist are so many bands from singular, the closed form leads to each branch's one posture."""

ANY_ELBOW = 0b11
"""Both sides of the elbow, as bits."""

WELL_BENT = 0.5
"""Sine of a middle angle from which on shifts are measured."""

OBLIQUE = 1e-2
"""Cosine between neighbouring axes of a shoulder or wrist from which on a joint's limit is no circle about its axis."""

LOOKS = 12
SPREAD = 1.15
REST = 0.03
"""The elbow's cosine at a pose is looked at at so many straight elbows a branch of shoulder and wrist; it is off by no
more than the most that is found, but for the first factor, and this part of the most that it is off at any pose."""

TOGETHER = 3.0
"""Where one joint is on its limit and the others are outside by no more than so many bands, all may keep them."""

ALMOST_NOTHING = 1e-4
"""With a narrower band, rad, there are as many intervals as the nearest exact limb has, each end close to its own."""


@kernel
def sines_of_middles(P, q):
    """How far shoulder and wrist are from singular."""
    return abs(math.sin(q[1] - P[at.SHOULDER + at.PHASE])), abs(math.sin(q[5] - P[at.WRIST + at.PHASE]))


@kernel
def certain_posture(P, side, branch, psi):
    """The posture of the nearest exact limb at an arm angle."""
    q, _, _ = side_posture(P, side, psi, (branch >> 1) & 1, branch & 1, False, NO_SEED, True)
    return q


@kernel
def cosine_off(P, c4, sw):
    """By how much the cosine of the elbow's bend at a configuration differs from that of the closed form.

    Of one, or of eight: c4 is the cosine, sw the way from shoulder to wrist.
    """
    near2, far2 = P[at.NEAR] * P[at.NEAR], P[at.FAR] * P[at.FAR]
    return (2.0 * dot(sw, sw) - near2 - far2) / (far2 - near2) - c4


@kernel
def put_shift(P, q, out):
    """Write how far a configuration is from the closed form at its pose and arm angle into out (SHIFTS,).

    Those of joints are zero where shoulder or wrist are close to singular, or the closed form is out of reach.
    """
    x, y, z, p = forward_kinematics(P, q)
    R = (x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2])
    place_ = place(P, R, p)
    branch = branch_of(P, q)
    s2, s6 = sines_of_middles(P, q)
    out[at.SHIFT_COSINE] = cosine_off(P, math.cos(q[3] - P[at.STRAIGHT]), shoulder_to_wrist(P, R, p))
    out[at.SHIFT_CLOSED], out[at.SHIFT_BEND] = place_[2], 0.0
    if min(s2, s6) < WELL_BENT or place_[5] != 0.0:
        return
    psi = arm_angle(P, q, place_[0], place_[1])
    d = difference(q, certain_posture(P, elbow_side(P, place_, branch >> 2), branch, psi))
    out[at.SHIFT_BEND] = place_[3]
    for j in range(7):
        out[j] = share_of(j, s2, s6) * abs(d[j])


@kernel
def share_of(j, s2, s6):
    """What a band counts of the angle of joint j: of joints 1, 3, 5 and 7 the part that turns something."""
    return s2 if j in (0, 2) else (s6 if j in (4, 6) else 1.0)


@kernel
def may_meet_limits(P, view, branch, psi):
    """Whether the true chain may keep its limits next to an arm angle."""
    q = certain_posture(P, view.sides[branch >> 2], branch, psi)
    s2, s6 = sines_of_middles(P, q)
    within = True
    for j in range(7):
        off = share_of(j, s2, s6) * beyond(P, j, turn_to_middle(P, j, q[j]))
        within = within and off < TOGETHER * view.band[j]
    return within


@kernel
def turns_at(circle, x, value, within):
    """Whether the product of a vector on a circle with x turns around no farther from a value than within."""
    c, s = dot(x, circle[1]), dot(x, circle[2])
    return abs(math.sqrt(c * c + s * s) - abs(value - dot(x, circle[0]))) < within


@kernel
def may_turn_at_limit(P, view):
    """Whether a joint may turn around so close to a limit that the true chain has an interval more there, or a gap."""
    within = TOGETHER * widest(view.band)
    turns = False
    for i in range(4):
        side, k = view.sides[i >> 1], at.SHOULDER if i & 1 == 0 else at.WRIST
        v, _, r = side[1] if i & 1 == 0 else side[2]
        first = int(P[k + at.FIRST_JOINT])
        for end in range(2):
            if P[at.RANGE_KIND + first] != 0.0:
                x = load3(P, k + at.BOUND_1_LOWER + 3 * end)
                turns = turns or turns_at(v, x, P[k + at.A2_A3], within)
            if P[at.RANGE_KIND + first + 1] != 0.0:
                turns = turns or turns_at(v, load3(P, k + at.A1), P[k + at.BOUND_2_LOWER + end], within)
            if P[at.RANGE_KIND + first + 2] != 0.0:
                x = load3(P, k + at.BOUND_3_LOWER + 3 * end)
                turns = turns or turns_at(r, x, P[k + at.A1_A2], within)
    return turns


@kernel
def of_joint(P, j, share):
    """The band of joint j, with one over the sine of the bend given."""
    return P[at.BANDS + 2 * j] + P[at.BANDS + 2 * j + 1] * share


@kernel
def band_with(P, bend):
    """The band of each joint where the elbow's bend has a given sine."""
    x = 1.0 / bend if bend > 0.0 else math.inf
    return (
        of_joint(P, 0, x),
        of_joint(P, 1, x),
        of_joint(P, 2, x),
        of_joint(P, 3, x),
        of_joint(P, 4, x),
        of_joint(P, 5, x),
        of_joint(P, 6, x),
    )


@kernel
def band_of(P, place_):
    """The band of each joint at a pose."""
    return band_with(P, place_[3])


@kernel
def farthest_off(P, place_):
    """By how much the cosine of the bend may be closer to a flat elbow's than the closed form says, at a pose.

    Any, where a shoulder or wrist that is looked at is singular.
    """
    level = level_place(place_)
    sides = elbow_side(P, level, 0), elbow_side(P, level, 1)
    branches = eight_of(0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0)
    later = eight_of(0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0)
    most = 0.0
    for i in range(0, LOOKS, 2):
        c, s = turn(2.0 * math.pi / LOOKS * (i + later))
        q, sure = eight_postures(P, sides, branches, c, s)
        if sure != ALL:
            return 2.0
        x, y, z, p = tip_frame(P, turns_of(q))
        R = (x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2])
        most = max(most, highest(-level[2] * cosine_off(P, turn(q[3] - P[at.STRAIGHT])[0], shoulder_to_wrist(P, R, p))))
    return SPREAD * most + REST * P[at.COSINE_OFF]


@kernel
def least_bend(P, place_):
    """Sine of the least bend that the true chain has at a pose, for certain; 0 where its elbow may be flat.

    Where the closed form's bend is so wide that no pose of the limb has a flat elbow with it, it is the closed form's.
    """
    gap = 1.0 - abs(place_[2])
    if gap > at.WELL_CLEAR * P[at.COSINE_OFF]:
        return place_[3]
    if gap < 2.0 * REST * P[at.COSINE_OFF]:
        return 0.0
    gap -= farthest_off(P, place_)
    return math.sqrt(gap * (2.0 - gap)) if gap > 0.0 else 0.0


@kernel
def outer_band(band):
    """The widest band of joints 1, 3, 5 and 7."""
    return max(band[0], band[2], band[4], band[6])


@kernel
def outer_band_of_limits(P, band):
    """The widest band of those of joints 1, 3, 5 and 7 that have limits."""
    most = 0.0
    for j in range(0, 7, 2):
        if P[at.RANGE_KIND + j] != 0.0:
            most = max(most, band[j])
    return most


@kernel
def widest(band):
    """The widest band of all joints."""
    return max(outer_band(band), band[1], band[3], band[5])


@kernel
def nearness(k, band):
    """How close to singular, rad, the spherical joint at block k may be for its band to tell something."""
    return max(band[0], band[1]) if k == at.SHOULDER else max(band[6], band[5])


@kernel
def is_oblique(P):
    """Whether neighbouring axes of shoulder or wrist are oblique."""
    s, w = at.SHOULDER, at.WRIST
    return max(abs(P[s + at.A1_A2]), abs(P[s + at.A2_A3]), abs(P[w + at.A1_A2]), abs(P[w + at.A2_A3])) > OBLIQUE


@kernel
def is_well_bent(P, place_):
    """Whether the elbow at a pose is neither almost straight nor folded, as far as the nearest exact limb tells."""
    return place_[5] == 0.0 and 1.0 - abs(place_[2]) > at.WELL_CLEAR * P[at.COSINE_OFF]


@kernel
def may_predict(P, place_, band):
    """Whether a band tells enough: not with the elbow almost straight or folded, nor of oblique axes."""
    narrow = widest(band) < ALMOST_NOTHING
    tells = max(band[1], band[3], band[5]) < WIDEST_BAND and outer_band(band) < WIDEST_OUTER
    return tells and is_well_bent(P, place_) and (narrow or not is_oblique(P))


@kernel
def may_predict_limits(P, place_, band):
    """Whether a band, of the least bend, tells enough of where limits are: what has no limits need not be told."""
    narrow = widest(band) < ALMOST_NOTHING
    tells = max(band[1], band[3], band[5]) < WIDEST_BAND and outer_band_of_limits(P, band) < WIDEST_OUTER
    return tells and place_[5] == 0.0 and (narrow or not is_oblique(P))


@kernel
def may_tell_none(P, place_, band):
    """Whether limits that are drawn out by a band leave out nothing: of the elbow it tells where the bend is, at most.

    Joints without limits need not be told.
    """
    told = max(band[1], band[5]) < WIDEST_BAND and outer_band_of_limits(P, band) < WIDEST_OUTER
    return told and is_well_bent(P, place_) and (widest(band) < ALMOST_NOTHING or not is_oblique(P))


@kernel
def turned_by_sideways(sine, off):
    """How far a middle angle with this sine may be off, rad, where axis 3 is turned sideways by some angle."""
    return sine - math.sqrt(sine * sine - off * off) if sine > off else off


@kernel
def band_at_limit(P, band, j, limit):
    """The band of joint 2, 4 or 6 at one of its limits.

    Next to a singular shoulder or wrist, what turns axis 3 sideways turns the middle joint, too. Where bands were
    measured, that is part of them.
    """
    if j == 3 or math.isinf(limit):
        return band[j]
    k = at.SHOULDER if j == 1 else at.WRIST
    off = nearness(k, band)
    sine = min(abs(math.sin(limit - P[k + at.PHASE])), WELL_BENT)
    return band[j] + turned_by_sideways(sine, off) - turned_by_sideways(WELL_BENT, off)


@kernel
def widen(P, band, factor, box):
    """Copy a packed limb to `box`, its limits drawn out by a band times a factor; whether it has any room."""
    copy(P, box, at.SIZE)
    box[at.BAND] = factor * outer_band_of_limits(P, band)
    for j in range(1, 7, 2):
        lower, upper = P[at.LOWER + j], P[at.UPPER + j]
        lower -= factor * band_at_limit(P, band, j, lower)
        upper += factor * band_at_limit(P, band, j, upper)
        if lower > upper:
            return False
        set_limit(box, j, lower, upper)
    set_joint_limits(box, at.SHOULDER, 0)
    set_joint_limits(box, at.WRIST, 4)
    return True


@kernel
def is_close_to_singular(P, k, circle, psi, band):
    """Whether axes 1 and 3 of a spherical joint are closer to parallel than the band at an arm angle."""
    a1 = load3(P, k + at.A1)
    cosine = dot(a1, circle[0]) + dot(a1, circle[1]) * math.cos(psi) + dot(a1, circle[2]) * math.sin(psi)
    near = 0.25 * band * band * (2.0 - P[k + at.TOP_GAP] - P[k + at.BOTTOM_GAP])
    return cosine > 1.0 - P[k + at.TOP_GAP] - near or cosine < P[k + at.BOTTOM_GAP] + near - 1.0


@kernel
def is_near_singularity(P, side, psi, band, factor):
    """Whether shoulder or wrist are so close to singular at an arm angle that a band times a factor tells nothing."""
    shoulder, wrist = factor * nearness(at.SHOULDER, band), factor * nearness(at.WRIST, band)
    at_shoulder = is_close_to_singular(P, at.SHOULDER, side[1][0], psi, shoulder)
    return at_shoulder or is_close_to_singular(P, at.WRIST, side[2][0], psi, wrist)


@kernel
def untold_elbows(P, place_, psi):
    """Sides of the elbow, as bits, on which a branch may have several postures at an arm angle, or none."""
    band = band_of(P, place_)
    if not may_predict(P, place_, band):
        return ANY_ELBOW
    elbows = 0
    for elbow in range(2):
        if is_near_singularity(P, elbow_side(P, place_, elbow), psi, band, WIDER):
            elbows |= 1 << elbow
    return elbows


@kernel
def is_told(P, place_, psi):
    """Whether each branch has one posture at an arm angle, next to the closed form's, as the band tells."""
    return untold_elbows(P, place_, psi) == 0


@kernel
def leave_out_met(P, target, psi, branches, A):
    """Branches of those given (bits) whose postures at an arm angle, as costs in A tell, may not all be there."""
    place_ = target.place
    band = band_of(P, place_)
    if P[at.MISS] < ROUNDED * P[at.FAR] or not may_predict(P, place_, band):
        return branches
    for i in range(4):
        first = 4 * (i >> 1) + (i & 1)
        pair = 0b101 << first
        if branches & pair == 0:
            continue
        side = elbow_side(P, place_, i >> 1)
        if is_close_to_singular(P, at.WRIST, side[2][0], psi, WIDER * nearness(at.WRIST, band)):
            continue
        met = count_met(P, first, A)
        if met >= 0 and met == count_postures(P, target, psi, side, i & 1):
            branches &= ~pair
    return branches
