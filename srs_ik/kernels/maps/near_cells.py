"""Reachability and cells of near limbs, on their true chain.

Arcs of yaw follow from the angle of joint 1 at arm angles all along an interval, and closer around the largest and the
smallest: there is no closed form for where it turns.
"""

import math
from collections import namedtuple

import numpy as np

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.algebra.vectors import across, add, apply, load3, load9, norm, sub
from srs_ik.kernels.exact.events import TOUCH, TURN
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import limb as at
from srs_ik.kernels.layout.answer import GOOD_POSE, MOST_INTERVALS, OK, ROW, ROW_Q, ROW_STATUS
from srs_ik.kernels.layout.asked import Goal
from srs_ik.kernels.layout.maps import MOST_ARCS, NOT_REACHED, REACHED
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE
from srs_ik.kernels.limb.triangle import elbow_side, read_target
from srs_ik.kernels.maps.arcs import put_arc, write_arcs
from srs_ik.kernels.maps.cells import clear, write_measures
from srs_ik.kernels.maps.reach import is_bent_right, is_met_at
from srs_ik.kernels.near.at_angle import may_reach
from srs_ik.kernels.near.band import band_of, is_near_singularity, may_predict, widen
from srs_ik.kernels.near.intervals import has_none, intervals_through, true_intervals
from srs_ik.kernels.near.predicted import is_surely_out, predicted_intervals
from srs_ik.kernels.near.second_attempts import found_again
from srs_ik.kernels.pose.intervals import all_intervals
from srs_ik.kernels.pose.solve import solve_row_at

SPACING = 0.1
LEAST_LOOKS = 5
"""Arm angles at which joint 1 is looked at: so far apart, rad, and so many at least."""

CLOSE = 1e-5
"""The extremes of joint 1 are looked for this closely, rad of arm angle; they are off by about its square."""

ROUNDING = 1e-9
"""Of the reach."""

GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)

PROBED = 8
"""Arm angles, evenly spaced, that are tried before the intervals are looked for."""

Near = namedtuple("Near", ("J", "A", "found", "answers", "boxes", "slack"))
"""Work space of one thread: (6, 7), (16, 9), (MOST_INTERVALS, 3), (1, ROW), (1, SIZE), and how much
farther than its nearest exact limb the true chain may reach, m."""

Posed = namedtuple("Posed", ("T", "target"))
"""A pose: its 16 figures, and these as they are read."""


@kernel
def near_room(family, J, A):
    """Work space for near limbs."""
    slack = farther(row(family, at.LIMITED))
    return Near(J, A, np.empty((MOST_INTERVALS, 3)), np.empty((1, ROW)), np.empty((1, at.SIZE)), slack)


@kernel
def from_line(P, joint, centre):
    """How far the axis of a joint passes by a centre."""
    return norm(across(sub(centre, load3(P, at.POINTS + 3 * joint)), load3(P, at.AXES + 3 * joint)))


@kernel
def farther(P):
    """How much farther or closer than its nearest exact limb the true chain can bring the wrist to the shoulder.

    A point turns about an axis by no more than twice its distance from it, and the centres are such points.
    """
    wrist = add(load3(P, at.TIP_POSITION), apply(load9(P, at.TIP_ROTATION), load3(P, at.WRIST_IN_TIP)))
    total = from_line(P, 3, load3(P, at.ELBOW_CENTRE))
    for joint in range(3):
        total += from_line(P, joint, load3(P, at.SHOULDER_CENTRE)) + from_line(P, 4 + joint, wrist)
    return 2.0 * total + ROUNDING * P[at.FAR]


@kernel
def is_too_far(P, pose, space):
    """Whether the true chain cannot bring the wrist to where the pose wants it."""
    return abs(pose.target.place[5]) > space.slack or not may_reach(P, pose.target.place)


@kernel
def is_clear(P, side, psi, band):
    """Whether shoulder and wrist are so far from singular at an arm angle that a band tells something there."""
    return not is_near_singularity(P, side, psi, band, 1.0)


@kernel
def is_met_near(P, pose, band, family, space):
    """Whether an arm angle that is feasible for all that the band allows is so on the true chain."""
    box = row(space.boxes, 0)
    if not widen(P, band, -1.0, box):
        return False
    for elbow in range(2):
        if not is_bent_right(box, pose.target.place, elbow):
            continue
        side = elbow_side(P, pose.target.place, elbow)
        for i in range(PROBED):
            psi = TURN * i / PROBED
            if is_met_at(box, side, math.cos(psi), math.sin(psi)) and is_clear(P, side, psi, band):
                answer = row(space.answers, 0)
                solve_row_at(family, pose.T, psi, -1, Goal(False, NO_SEED, True), space.J, space.A, answer)
                if answer[ROW_STATUS] == OK:
                    return True
    return False


@kernel
def was_missed(P, target, space):
    """A posture that no curve has led to, and whether there is one."""
    if is_surely_out(P, target) or has_none(P, target, space.J, space.A):
        return NO_SEED, False
    q, _, lowest = found_again(P, target, -1, Goal(False, NO_SEED, True), space.J, space.A)
    return q, lowest < OUTSIDE


@kernel
def reach_near(family, pose, space):
    """Whether a posture of a near limb inside the limits meets a pose: REACHED or NOT_REACHED.

    Most poses are told by its nearest exact limb and the band around it, in which the true chain lies. Next to
    singularities a search may find what the curves have passed by.
    """
    P = row(family, at.LIMITED)
    if is_too_far(P, pose, space):
        return NOT_REACHED
    band = band_of(P, pose.target.place)
    if may_predict(P, pose.target.place, band) and is_met_near(P, pose, band, family, space):
        return REACHED
    if is_surely_out(P, pose.target):
        return NOT_REACHED
    n = predicted_intervals(P, pose.target, space.found, space.J, space.A)
    if n < 0:
        n = true_intervals(P, pose.target, True, space.found, space.J, space.A)
    if n > 0:
        return REACHED
    if has_none(P, pose.target, space.J, space.A):
        return NOT_REACHED
    if all_intervals(family, pose.target, True, space.J, space.A, space.found) > 0:
        return REACHED
    _, _, lowest = found_again(P, pose.target, -1, Goal(False, NO_SEED, True), space.J, space.A)
    return REACHED if lowest < OUTSIDE else NOT_REACHED


@kernel
def first_angle_near(family, pose, psi, branch, near, space):
    """Joint 1 of a branch at an arm angle, in the turn next to an angle, and whether there is such a posture."""
    answer = row(space.answers, 0)
    solve_row_at(family, pose.T, psi, branch, Goal(False, NO_SEED, True), space.J, space.A, answer)
    q = answer[ROW_Q]
    return q - TURN * math.floor((q - near) / TURN + 0.5), answer[ROW_STATUS] == OK


@kernel
def extreme(family, pose, branch, between, sense, best, space):
    """The largest `sense` times joint 1 between two arm angles, about one that is larger than its neighbours."""
    low, high = between
    left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    x, met_x = first_angle_near(family, pose, left, branch, sense * best, space)
    y, met_y = first_angle_near(family, pose, right, branch, sense * best, space)
    while met_x and met_y and high - low > CLOSE:
        best = max(best, sense * x, sense * y)
        if sense * x > sense * y:
            high, right, y = right, left, x
            left = high - GOLDEN * (high - low)
            x, met_x = first_angle_near(family, pose, left, branch, sense * best, space)
        else:
            low, left, x = left, right, y
            right = low + GOLDEN * (high - low)
            y, met_y = first_angle_near(family, pose, right, branch, sense * best, space)
    return best


@kernel
def first_range_near(family, pose, interval, enough, space):
    """The lowest and highest angle of joint 1 over an interval; as soon as they are `enough` apart, those so far."""
    branch, lower, upper = interval
    count = LEAST_LOOKS + int((upper - lower) / SPACING)
    lowest, highest = math.inf, -math.inf
    at_lowest, at_highest = lower, lower
    q, some = 0.0, False
    for i in range(count):
        psi = lower + (upper - lower) * i / (count - 1)
        x, met = first_angle_near(family, pose, psi, branch, q, space)
        if not met:
            continue
        q, some = x, True
        if q < lowest:
            lowest, at_lowest = q, psi
        if q > highest:
            highest, at_highest = q, psi
        if highest - lowest >= enough:
            return lowest, highest, True
    if not some:
        return 0.0, 0.0, False
    gap = (upper - lower) / (count - 1)
    if gap > 0.0:
        about = max(at_highest - gap, lower), min(at_highest + gap, upper)
        highest = extreme(family, pose, branch, about, 1.0, highest, space)
        about = max(at_lowest - gap, lower), min(at_lowest + gap, upper)
        lowest = -extreme(family, pose, branch, about, -1.0, -lowest, space)
    return lowest, highest, True


@kernel
def write_yaws_near(family, pose, found, wanted, space, out):
    """`cells.write_yaws` of a near limb, for n intervals in `space.found` and, where it was found again, a posture.

    `found` holds n, that posture and whether it counts; `wanted` the limits of joint 1 and how many arcs there are.
    """
    (n, q, again), (limits, most) = found, wanted
    enough = TURN - (limits[1] - limits[0])
    if enough <= TOUCH:
        write_arcs(np.empty((1, 2)), -1, most, out)
        return
    arcs = np.empty((MOST_ARCS + n + 1, 2))
    count = put_arc(q[0], q[0], limits, arcs, 0) if again else 0
    for i in range(n if count >= 0 else 0):
        interval = (int(space.found[i, 0]), space.found[i, 1], space.found[i, 2])
        lowest, highest, some = first_range_near(family, pose, interval, enough, space)
        if some:
            count = put_arc(lowest, highest, limits, arcs, count)
        if count < 0:
            break
    write_arcs(arcs, count, most, out)


@kernel
def write_cell_near(family, pose, limits, most, space, out):
    """`cells.write_cell` of a near limb, without its margin."""
    clear(most, out)
    P = row(family, at.LIMITED)
    if is_too_far(P, pose, space):
        return
    n = all_intervals(family, pose.target, True, space.J, space.A, space.found)
    q, again = NO_SEED, False
    if n == 0:
        q, again = was_missed(P, pose.target, space)
        if again:
            n = intervals_through(P, pose.target, q, True, space.found, space.J, space.A)
    if n == 0:
        return
    write_measures(space.found, n, out)
    if most > 0:
        write_yaws_near(family, pose, (n, q, again), (limits, most), space, out)


@kernel
def reach_near_poses(family, poses, first, last, J, A, out):
    """`reach.reach_poses` of a near limb."""
    space = near_room(family, J, A)
    for i in range(first, last):
        T = row(poses, i)
        target, verdict = read_target(row(family, at.LIMITED), T)
        out[i] = -verdict if verdict != GOOD_POSE else reach_near(family, Posed(T, target), space)


@kernel
def measure_near_poses(family, poses, first, last, limits, most, space, out):
    """`cells.measure_poses` of a near limb, without margins."""
    for i in range(first, last):
        T = row(poses, i)
        target, verdict = read_target(row(family, at.LIMITED), T)
        if verdict == GOOD_POSE:
            write_cell_near(family, Posed(T, target), limits, most, space, row(out, i))
        else:
            clear(most, row(out, i))
