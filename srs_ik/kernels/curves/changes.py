"""Where a curve goes over from one branch into another: shoulder, elbow or wrist pass their singularity there."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from srs_ik.kernels.algebra.joint_vectors import along7, difference, dot7, largest, short_way, store7, with_joint
from srs_ik.kernels.algebra.lanes import as_bits, gather, scatter, where
from srs_ik.kernels.algebra.minimum import lowest_of_cubic
from srs_ik.kernels.algebra.pointers import copy, read7, row
from srs_ik.kernels.algebra.roots import has_settled, next_parameter, start_crossing, tell_figure
from srs_ik.kernels.algebra.vectors import norm
from srs_ik.kernels.chain.eight import put_eight, sines_of_eight, take_ways
from srs_ik.kernels.chain.newton import elbow_across
from srs_ik.kernels.curves.ends import ON_LIMIT, infeasibility, inside_of_blur, on_chord, on_curve, sample_before
from srs_ik.kernels.curves.follow import BLURRED, arc_between, meet, null_vector
from srs_ik.kernels.curves.in_step import ARC, TURNING_WRIST, between_eight, load_end, load_sample, share_beside
from srs_ik.kernels.curves.told import (
    TOLD_MIDDLES,
    TOLD_PSI,
    TOLD_RATE,
    TOLD_SINES,
    angle_at,
    arm_angles,
    rate_at,
    turns_back,
)
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import FAR
from srs_ik.kernels.limb.branches import NO_BRANCH, phase_of, sine_of
from srs_ik.kernels.limb.goal import NO_SEED

HARDLY_OFF = 2e-3
"""With the elbow farther off the line S-W than this part of the reach, the arm angle changes by less than 1e-9 rad as a
curve goes on by `spans.JUST_OUTSIDE`."""

CHANGE = 11
CHANGE_AT, CHANGE_PSI, CHANGE_RATE, CHANGE_MIDDLE, CHANGE_POSTURE = range(5)
"""A change of branch: parameter of the curve, arm angle and its rate there, which middle angle changes sides (0
shoulder, 1 elbow, 2 wrist), and the posture."""

MET = CHANGE + 1
MET_ROW = CHANGE
MOST_MET = 64
"""A change that is met in step, the row of the sample behind it (-1 if it is not met after all), and room for them."""

SAME = 1e-12
"""A posture that keeps its limits without having been moved by more than this, rad, tells what it told before."""

MOST_CHANGES = 6
"""A middle angle changes sides no more than twice between two samples."""

MOST_BACK = 8
"""Next to the line S-W an arm angle may turn by half a turn within 2^-8 of the way between two samples."""

FAR_ON = 0.5 * math.pi
"""Arm angles of two places farther apart than this, rad, may be so the other way around."""

TURNING = 1e-9
"""An arm angle that goes back by more than this, rad, has turned around."""

CHANGE_STEPS = 60
DIP_STEPS = 8
"""Steps that find where an angle changes sides, and where one that stays on its side comes closest to the other."""

FORETOLD = 4.0
"""What is so many times as far from zero as from what was foretold does not reach zero."""

DIPS = 0.5
"""A middle angle that dips between two samples by less than this part of what is left at the closer one, as the
tangents at both tell, does not change sides there."""

FROM_ENDS = 0.01
"""Where a figure is lowest between two samples is looked for no closer to them than this part of the way."""


class Place(NamedTuple):
    """A place on a curve."""

    at: Any  # its parameter, arm angle and the rate of that along the curve
    q: Any  # its posture


@kernel
def place_at(P, by, x, q):
    """The place of a posture at a parameter."""
    return Place((x, angle_at(P, by, q), rate_at(P, by, q)), q)


@kernel
def put_change(changes, n, there, middle):
    """Insert a change, at a place, among n sorted ones; their number."""
    x, psi, rate = there.at
    i = n
    while i > 0 and changes[i - 1, CHANGE_AT] > x:
        copy(row(changes, i - 1), row(changes, i), CHANGE)
        i -= 1
    changes[i, CHANGE_AT], changes[i, CHANGE_PSI], changes[i, CHANGE_RATE] = x, psi, rate
    changes[i, CHANGE_MIDDLE] = middle
    store7(row(changes, i), CHANGE_POSTURE, there.q)
    return n + 1


@kernel
def place_beside(P, by, curve, change, x):
    """The place next to a change of branch, at a parameter: that of the change, unless its elbow is almost on S-W.

    There the arm angle changes fast: it is that of the parameter alone, if that has one. Where limits count it keeps
    them, if rounding alone leaves it outside.
    """
    q = at_change = read7(row(change, CHANGE_POSTURE))
    almost_on = norm(elbow_across(P, q, by.target.place[0])) < HARDLY_OFF * P[FAR]
    if almost_on:
        there, off = on_curve(P, by, 0, curve, x)
        q = there if off < NO_BRANCH else q
    q = inside_of_blur(P, by, q, BLURRED)
    if almost_on or largest(difference(at_change, q)) > SAME:
        return place_at(P, by, x, q)
    return Place((x, change[CHANGE_PSI], change[CHANGE_RATE]), q)


@kernel
def met_change(P, by, curve, middle, x, y):
    """`change_between` by Newton's method for the pose and the angle together: that, and whether it is met."""
    rows = curve.rows
    low = sample_before(curve, 0.5 * (x + y))
    a, b = on_chord(rows, low, x), on_chord(rows, low, y)
    if x < rows[low, 0] or y > rows[low + 1, 0]:
        return (x, a), False
    start, end = load_end(rows[low]), load_end(rows[low + 1])
    joint, phase = 1 + 2 * middle, phase_of(P, middle)
    at_a, at_b = math.sin(a[joint] - phase), math.sin(b[joint] - phase)
    if at_a * at_b >= 0.0:
        return (x, a), False
    share = at_a / (at_a - at_b)
    turned = a[joint] + share * short_way(b[joint] - a[joint])
    angle = phase + math.pi * math.floor((turned - phase) / math.pi + 0.5)
    width = rows[low + 1, 0] - rows[low, 0]
    arc = arc_between(P, by, start, end, (x - rows[low, 0] + share * (y - x)) / width)
    q, share, met = meet(P, by, (start[0], end[0]), arc, joint, angle)
    found = rows[low, 0] + share * width
    return (found, q), met and x < found < y


@kernel
def turned_back(P, by, curve, a, b, again):
    """The next place from one to another, as `turns_back` takes them, at which the arm angle goes back, if it does.

    No sample lies between the two; `again` is whether it has been asked for places before. Returns the place, and
    whether there is one.
    """
    place_, q, found = b, NO_SEED, False
    for _ in range(MOST_BACK):
        if (found or again) and abs(short_way(place_[1] - a[1])) < FAR_ON:
            break
        share, goes_back = turns_back(a, place_)
        x = a[0] + share * (place_[0] - a[0])
        there, off = on_curve(P, by, 0, curve, x) if goes_back else (q, NO_BRANCH)
        there = inside_of_blur(P, by, there, BLURRED) if goes_back else q
        # Where limits cut it off, it is not there.
        if off >= NO_BRANCH or infeasibility(P, there, by.respect) >= ON_LIMIT:
            break
        place_, q, found = (x, angle_at(P, by, there), rate_at(P, by, there)), there, True
    return Place(place_, q), found


@kernel
def change_between(P, by, curve, middle, a, b):
    """The place between two parameters, each with its sine, at which a middle angle changes sides."""
    (x, at_x), (y, at_y) = a, b
    (found, q), met = met_change(P, by, curve, middle, x, y)
    if met:
        return place_at(P, by, found, q)
    side = -1.0 if at_x >= 0.0 else 1.0
    crossing = start_crossing(x, side * at_x, y, side * at_y)
    for _ in range(CHANGE_STEPS):
        if has_settled(crossing):
            break
        wanted = next_parameter(crossing)
        # A posture that does not meet its pose tells nothing: the change is before it.
        q, off = on_curve(P, by, 0, curve, wanted)
        crossing = tell_figure(crossing, wanted, side * sine_of(P, q, middle) if off < NO_BRANCH else NO_BRANCH)
    q, _ = on_curve(P, by, 0, curve, crossing[0])
    return place_at(P, by, crossing[0], q)


@kernel
def put_start(P, rows, i, middle, sines, met, n):
    """Append the start from which Newton's method meets a change between samples i - 1 and i; how many there are."""
    a, b = load_sample(rows[i - 1]), load_sample(rows[i])
    joint, phase = 1 + 2 * middle, phase_of(P, middle)
    start = along7(a, sines[0] / (sines[0] - sines[1]), difference(a, b))
    angle = phase + math.pi * math.floor((start[joint] - phase) / math.pi + 0.5)
    met[n, MET_ROW], met[n, CHANGE_MIDDLE] = i, middle
    store7(row(met, n), CHANGE_POSTURE, with_joint(start, joint, angle))
    return n + 1


@kernel
def meet_eight(P, by, met):
    """Bring eight starts to the changes, in whose rows they are; which are met, as bits."""
    middles = gather(met, CHANGE_MIDDLE, MET)
    none = 0.0 * middles
    shoulder, elbow = where(middles < 0.5, none + 1.0, none), where(middles < 0.5, none, none + 1.0)
    start = take_ways(met, CHANGE_POSTURE, MET)
    q, t, there = between_eight(P, by, start, (none, shoulder, none, elbow, none, none, none))
    psi, rate = arm_angles(P, by.target.place, q, t)
    there &= as_bits(abs(sines_of_eight(P, q)[2]) > TURNING_WRIST)
    put_eight(row(met, CHANGE_POSTURE), MET, there, q)
    scatter(met, CHANGE_PSI, MET, psi)
    scatter(met, CHANGE_RATE, MET, rate)
    return there


@kernel
def meet_changes(P, by, rows, runs, told, met):
    """Meet the changes of shoulder and elbow between samples of runs, eight in step, in rows of met; their number.

    Steps in eight divide by what axes 5 to 7 span: the wrist's own changes are met one by one.
    """
    n = 0
    for index in range(runs.shape[0]):
        for i in range(int(runs[index, 3]) + 1, int(runs[index, 4])):
            for middle in range(2):
                sines = told[i - 1, TOLD_SINES + middle], told[i, TOLD_SINES + middle]
                if (sines[0] >= 0.0) != (sines[1] >= 0.0) and n < MOST_MET:
                    n = put_start(P, rows, i, middle, sines, met, n)
    for k in range(n, 8 * ((n + 7) // 8)):
        copy(row(met, n - 1), row(met, k), MET)
    for first in range(0, n, 8):
        there = meet_eight(P, by, row(met, first))
        for k in range(first, min(first + 8, n)):
            i = int(met[k, MET_ROW])
            start, end = load_sample(rows[i - 1]), load_sample(rows[i])
            share, beside = share_beside(start, end, read7(row(met[k], CHANGE_POSTURE)))
            met[k, CHANGE_AT] = rows[i - 1, 0] + share * (rows[i, 0] - rows[i - 1, 0])
            if (there >> (k - first)) & 1 == 0 or not beside or not 0.0 < share < 1.0:
                met[k, MET_ROW] = -1.0
    return n


@kernel
def row_of_met(met, i, middle):
    """The row of the change of a middle angle between samples i - 1 and i among those met; -1 where it is not."""
    found = -1
    for k in range(met.shape[0]):
        if int(met[k, MET_ROW]) == i and int(met[k, CHANGE_MIDDLE]) == middle:
            found = k
    return found


@kernel
def rate_of_sine(P, q, middle, rate):
    """How fast the sine of a middle angle changes that changes at some rate itself."""
    return math.cos(q[1 + 2 * middle] - phase_of(P, middle)) * rate


@kernel
def dip_between(P, by, curve, middle, a, b):
    """A parameter between two on one side at which a middle angle is on the other side: it, its sine, if any.

    They are given with their sines and how fast these change along the curve.
    """
    x_a, at_a, rate_a = a
    x_b, at_b, rate_b = b
    side = 1.0 if at_a >= 0.0 else -1.0
    first, last = (x_a, side * at_a, side * rate_a), (x_b, side * at_b, side * rate_b)
    low = sample_before(curve, 0.5 * (x_a + x_b))
    chord = difference(load_sample(curve.rows[low]), load_sample(curve.rows[low + 1]))
    for _ in range(DIP_STEPS):
        if first[2] >= 0.0 or last[2] <= 0.0:
            break
        x, foretold = lowest_of_cubic(first, last, FROM_ENDS)
        q, off = on_curve(P, by, 0, curve, x)
        if off >= NO_BRANCH:
            break
        height = side * sine_of(P, q, middle)
        if height < 0.0:
            return x, side * height, True
        if height > FORETOLD * abs(height - foretold):
            break
        # Newton's method has left the Jacobian.
        t, _ = null_vector(by.J, chord, by.A)
        rate = math.copysign(t[1 + 2 * middle], t[1 + 2 * middle] * dot7(t, chord))
        here = (x, height, side * rate_of_sine(P, q, middle, rate))
        if here[2] < 0.0:
            first = here
        else:
            last = here
    return x_a, 0.0, False


@kernel
def rates_of_sine(P, curve, i, told, middle):
    """How fast the sine of a middle angle changes at samples i - 1 and i."""
    rate_a = rate_of_sine(P, load_sample(curve.rows[i - 1]), middle, told[i - 1, TOLD_MIDDLES + middle])
    return rate_a, rate_of_sine(P, load_sample(curve.rows[i]), middle, told[i, TOLD_MIDDLES + middle])


@kernel
def may_change(P, curve, i, told, middle):
    """Whether a middle angle is on two sides at samples i - 1 and i, or comes so close to the other that it may be."""
    at_a, at_b = told[i - 1, TOLD_SINES + middle], told[i, TOLD_SINES + middle]
    if (at_a >= 0.0) != (at_b >= 0.0) or abs(at_a + at_b) >= ARC * (curve.rows[i, 0] - curve.rows[i - 1, 0]):
        return (at_a >= 0.0) != (at_b >= 0.0)
    rate_a, rate_b = rates_of_sine(P, curve, i, told, middle)
    side = math.copysign(curve.rows[i, 0] - curve.rows[i - 1, 0], at_a)
    fall, back = -side * rate_a, side * rate_b
    away, next_away = abs(at_a), abs(at_b)
    # Where the tangents meet: an angle that only passes by its singularity stays above that.
    return min(fall, back) > 0.0 and away - fall * (away - next_away + back) / (fall + back) < DIPS * min(
        away, next_away
    )


@kernel
def goes_on(P, curve, i, told, rise):
    """Whether the arm angle goes on to rise or to fall from sample i - 1 to i, and no branch may change there.

    `rise` is how it has changed before. The cubic between the two turns nowhere where no rate is too fast.
    """
    sign, way = math.copysign(1.0, rise), curve.rows[i, 0] - curve.rows[i - 1, 0]
    change = sign * short_way(told[i, TOLD_PSI] - told[i - 1, TOLD_PSI])
    begins, ends = sign * way * told[i - 1, TOLD_RATE], sign * way * told[i, TOLD_RATE]
    on = change > TURNING and min(begins, ends) > 0.0 and max(begins, ends) < 3.0 * change
    for middle in range(3):
        on = on and not may_change(P, curve, i, told, middle)
    return on


@kernel
def find_changes(P, by, curve, i, known, changes):
    """Write the changes of branch between samples i - 1 and i, in their order, into rows of changes; their number.

    `known` holds what samples tell, and the changes that have been met.
    """
    told, met = known
    x_a, x_b = curve.rows[i - 1, 0], curve.rows[i, 0]
    n = 0
    for middle in range(3):
        if not may_change(P, curve, i, told, middle):
            continue
        at_a, at_b = told[i - 1, TOLD_SINES + middle], told[i, TOLD_SINES + middle]
        if (at_a >= 0.0) != (at_b >= 0.0):
            k = row_of_met(met, i, middle)
            if k >= 0:
                at, q = (met[k, CHANGE_AT], met[k, CHANGE_PSI], met[k, CHANGE_RATE]), read7(row(met[k], CHANGE_POSTURE))
                n = put_change(changes, n, Place(at, q), middle)
            else:
                n = put_change(changes, n, change_between(P, by, curve, middle, (x_a, at_a), (x_b, at_b)), middle)
            continue
        rate_a, rate_b = rates_of_sine(P, curve, i, told, middle)
        x, at_x, found = dip_between(P, by, curve, middle, (x_a, at_a, rate_a), (x_b, at_b, rate_b))
        if found:
            n = put_change(changes, n, change_between(P, by, curve, middle, (x_a, at_a), (x, at_x)), middle)
            n = put_change(changes, n, change_between(P, by, curve, middle, (x, at_x), (x_b, at_b)), middle)
    return n
