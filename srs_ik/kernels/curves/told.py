"""What the samples of a curve tell: branch, arm angle, and how fast that and middle joints change; where it turns."""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.joint_vectors import along7, difference, dot7, short_way
from srs_ik.kernels.algebra.lane_trig import angle_of, turn, turns_of
from srs_ik.kernels.algebra.lanes import as_bits, eight_of, one_of, root, scatter
from srs_ik.kernels.algebra.minimum import lowest_of_cubic
from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.algebra.vectors import along, cross, dot, load3, rotate, sub
from srs_ik.kernels.chain.eight import branches_of, sines_of_eight, take_ways
from srs_ik.kernels.chain.kinematics import turn_about_line
from srs_ik.kernels.chain.newton import arm_angle
from srs_ik.kernels.chain.newton_eight import curve_ways, reduced
from srs_ik.kernels.curves.follow import between, correct, tangent_at
from srs_ik.kernels.curves.in_step import (
    SAMPLE,
    SAMPLE_WAY,
    TURNING_WRIST,
    are_ways,
    between_eight,
    load_sample,
    on_cubic,
    on_way,
    one_of_seven,
    short_ways,
)
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import AXES, ELBOW_CENTRE, POINTS, SHOULDER_CENTRE
from srs_ik.kernels.limb.branches import sine_of
from srs_ik.kernels.limb.goal import NO_SEED

TOLD = 9
TOLD_BRANCH, TOLD_PSI, TOLD_RATE, TOLD_MIDDLES = range(4)
TOLD_SINES = 6
"""What a sample tells: its branch, its arm angle, rad, the rates of that and of joints 2, 4, 6 along the curve, and the
sines of these joints from their phases on."""

ARM_ANGLE = -1
"""The arm angle, where joints are numbered from 0 on."""

ROUNDS = 16
TURNED = 1e-12
"""Rounds of eight looks, at most, and how well an angle is to be known where it turns, rad."""

CLOSER = 7.0 / 24.0
"""The looks of a round are spread over this part of what is between two of the round before."""

UNTOLD = (0.0, 0.0)
"""Rates at two postures that are not known."""

SHORTEST = 1e-6
"""On a way between samples that is shorter than this, rad, no arm angle turns around twice."""

FINEST = 1e-9
"""The turn is between two postures this close together, as a part of the chord."""


@kernel
def angle_at(P, by, q):
    """The arm angle of a posture for the pose."""
    return arm_angle(P, q, by.target.place[0], by.target.place[1])


@kernel
def moved_on(P, joint, turn_, point, rate, speed):
    """A point that moves, turned about the line of a joint that turns itself: where it is then, and how it moves."""
    c, s = turn_
    axis = load3(P, AXES + 3 * joint)
    point = turn_about_line(P, joint, c, s, point)
    arm = sub(point, load3(P, POINTS + 3 * joint))
    return point, along(rotate(axis, c, s, rate), speed, cross(axis, arm))


@kernel
def across_line(P, place_, turns, way):
    """The elbow across the line S-W, towards arm angles of 0 and of 90 degrees, and how both change along a way."""
    t, h0 = place_[0], place_[1]
    elbow, rate = moved_on(P, 2, turns[2], load3(P, ELBOW_CENTRE), (0.0, 0.0, 0.0), way[2])
    elbow, rate = moved_on(P, 1, turns[1], elbow, rate, way[1])
    elbow, rate = moved_on(P, 0, turns[0], elbow, rate, way[0])
    upper_arm, b0 = sub(elbow, load3(P, SHOULDER_CENTRE)), cross(t, h0)
    return (dot(upper_arm, h0), dot(upper_arm, b0)), (dot(rate, h0), dot(rate, b0))


@kernel
def arm_angles(P, place_, q, way):
    """The arm angles of eight postures, and how fast they change along ways from these."""
    turns = turn(q[0]), turn(q[1]), turn(q[2])
    (c, s), (c_rate, s_rate) = across_line(P, place_, turns, way)
    share = 1.0 / (c * c + s * s)
    size = root(share)
    return angle_of(size * c, size * s), share * (c * s_rate - s * c_rate)


@kernel
def rate_along(P, by, q, way):
    """How fast the arm angle changes along a way from a posture; 0 where it is anything."""
    turns = (math.cos(q[0]), math.sin(q[0])), (math.cos(q[1]), math.sin(q[1])), (math.cos(q[2]), math.sin(q[2]))
    (c, s), (c_rate, s_rate) = across_line(P, by.target.place, turns, way)
    size2 = c * c + s * s
    return (c * s_rate - s * c_rate) / size2 if size2 > 0.0 else 0.0


@kernel
def rate_at(P, by, q):
    """How fast the arm angle changes along a curve at a posture."""
    way, _ = tangent_at(P, by, q)
    return rate_along(P, by, q, way)


@kernel
def tell_one(P, by, q, told):
    """Write arm angle and rates of a posture."""
    way, _ = tangent_at(P, by, q)
    told[TOLD_PSI], told[TOLD_RATE] = angle_at(P, by, q), rate_along(P, by, q, way)
    for middle in range(3):
        told[TOLD_MIDDLES + middle] = way[1 + 2 * middle]
        told[TOLD_SINES + middle] = sine_of(P, q, middle)


@kernel
def tell_samples(P, by, curve, told):
    """Write what the samples of a curve tell, eight at a time."""
    rows, first, last = curve
    R, p, place_ = by.target
    for i in range(first, last, 8):
        # The last eight rows there are may begin before.
        k = min(i, rows.shape[0] - 8)
        q = take_ways(row(rows, k), 1, SAMPLE)
        eight = row(told, k)
        way = take_ways(row(rows, k), SAMPLE_WAY, SAMPLE)
        which = (1 << min(last - k, 8)) - 1
        if which & ~are_ways(way) != 0:
            way = curve_ways(reduced(P, turns_of(q), R, p))
        psi, rate = arm_angles(P, place_, q, way)
        sines = sines_of_eight(P, q)
        scatter(eight, TOLD_BRANCH, TOLD, branches_of(sines))
        scatter(eight, TOLD_PSI, TOLD, psi)
        scatter(eight, TOLD_RATE, TOLD, rate)
        scatter(eight, TOLD_MIDDLES, TOLD, way[1])
        scatter(eight, TOLD_MIDDLES + 1, TOLD, way[3])
        scatter(eight, TOLD_MIDDLES + 2, TOLD, way[5])
        scatter(eight, TOLD_SINES, TOLD, sines[0])
        scatter(eight, TOLD_SINES + 1, TOLD, sines[1])
        scatter(eight, TOLD_SINES + 2, TOLD, sines[2])
        sure = as_bits(abs(sines[2]) > TURNING_WRIST)
        for m in range(k, min(k + 8, last)):
            if (sure >> (m - k)) & 1 == 0:
                tell_one(P, by, load_sample(rows[m]), told[m])


@kernel
def turns_back(a, b):
    """Whether the arm angle turns around twice between two places of a curve, as a cubic foretells it.

    Or goes on by more than half a turn, which looks the same. A place is its parameter, arm angle and the rate of that.
    Returns the share of the way at which it goes back fastest, too.
    """
    (x, psi, rate), (next_x, next_psi, next_rate) = a, b
    length = next_x - x
    begins, ends, change = length * rate, length * next_rate, short_way(next_psi - psi)
    half, third = 2.0 * begins + ends - 3.0 * change, begins + ends - 2.0 * change
    if begins * ends <= 0.0 or third == 0.0 or length < SHORTEST:
        return 0.0, False
    share = half / (3.0 * third)
    return share, 0.0 < share < 1.0 and (begins - half * share) * begins < 0.0


@kernel
def goes_past(told, i, psi, blur):
    """Whether the arm angle goes from sample i - 1 to i without turning, past none that is wanted; how close it comes.

    Most samples are far from it: what is asked of all of them has to be quick.
    """
    ahead_a = short_way(told[i - 1, TOLD_PSI] - psi)
    ahead_b = ahead_a + short_way(told[i, TOLD_PSI] - told[i - 1, TOLD_PSI])
    rate, nearest = told[i - 1, TOLD_RATE], min(abs(ahead_a), abs(ahead_b))
    on = rate * told[i, TOLD_RATE] > 0.0 and rate * (ahead_b - ahead_a) >= 0.0
    return on and ahead_a * ahead_b > 0.0 and nearest > blur, nearest


@kernel
def lowest_of_eight(heights, met):
    """The lowest of eight heights that are met (bits); -1 where none is."""
    best = -1
    for i in range(8):
        if (met >> i) & 1 == 1 and (best < 0 or one_of(heights, i) < one_of(heights, best)):
            best = i
    return best


@kernel
def foretold_turn(height, rates):
    """Where on the way between two postures an angle turns, as a share of it, and how low, as a cubic foretells it.

    It is as high as given at the second, and changes on the way at the first and at the last by the rates. Last comes
    whether it turns.
    """
    if not rates[0] < 0.0 < rates[1]:
        return 0.0, math.inf, False
    share, lowest = lowest_of_cubic((0.0, 0.0, rates[0]), (1.0, height, rates[1]), 0.0)
    return share, lowest, True


@kernel
def turning_between(P, by, a, b, rise, joint, rates):
    """The posture of a curve, from one to another close by, whose arm angle or joint is farthest to one side.

    Eight postures at a time tell the angle and its rate; the cubic around the farthest one foretells the turn, and
    tells where to look next. `rise` is the sign of the side (joint `ARM_ANGLE`: the arm angle), `rates` are those of
    the angle along the curve at both, if they are known.
    """
    chord = difference(a, b)
    length2 = dot7(chord, chord)
    length = math.sqrt(length2)
    start, end = (angle_at(P, by, a), angle_at(P, by, b)) if joint == ARM_ANGLE else (a[joint], b[joint])
    side = -rise * length
    share, height, turns = foretold_turn(-rise * short_way(end - start), (side * rates[0], side * rates[1]))
    low, high = 0.0, 1.0
    apart = CLOSER / 7.0 if turns else 1.0 / 7.0
    begin = min(max(share - 3.5 * apart, 0.0), 1.0 - 7.0 * apart)
    # By how much better a round foretells the turn than the one before: a cubic's error is of the fourth order.
    less = CLOSER**3 / 7.0**3 if turns else 1.0
    steps = eight_of(0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0)
    there = on_way(a, chord, begin + apart * steps)
    before = behind = 0.0, a, a
    foreseen = False
    for _ in range(ROUNDS):
        q, t, met = between_eight(P, by, there, chord)
        angles, speeds = arm_angles(P, by.target.place, q, t) if joint == ARM_ANGLE else (q[joint], t[joint])
        heights = -rise * short_ways(angles - start)
        slopes = -rise * speeds * length2 / dot7(t, chord)
        best = lowest_of_eight(heights, met)
        foreseen = False
        if best < 0:
            break
        other = best + 1 if one_of(slopes, best) < 0.0 else best - 1
        if other < 0:
            high = begin
        elif other > 7:
            low = begin + 7.0 * apart
        else:
            i, j = min(best, other), max(best, other)
            low, high = begin + apart * i, begin + apart * j
            fall, rises = one_of(slopes, i), one_of(slopes, j)
            if (met >> i) & (met >> j) & 1 == 1 and fall < 0.0 < rises:
                first, last = (low, one_of(heights, i), fall), (high, one_of(heights, j), rises)
                share, foretold = lowest_of_cubic(first, last, 0.0)
                error, height = less * abs(foretold - height), foretold
                before = low, one_of_seven(q, i), one_of_seven(t, i)
                behind = high, one_of_seven(q, j), one_of_seven(t, j)
                foreseen = min(abs(sine_of(P, before[1], 2)), abs(sine_of(P, behind[1], 2))) > TURNING_WRIST
                # The angle is flat where it turns: it is off by the square of what the turn is.
                if 8.0 * error * error < TURNED * apart * (rises - fall):
                    break
                less = CLOSER**3 / 7.0**3
                apart = CLOSER / 7.0 * (high - low)
                begin = min(max(share - 3.5 * apart, low), high - 7.0 * apart)
                there = on_way(a, chord, begin + apart * steps)
                if foreseen:
                    there = on_cubic(before, behind, chord, begin + apart * steps)
                continue
        share, height = begin + apart * best, one_of(heights, best)
        if high - low < FINEST:
            break
        begin, apart, less = low, (high - low) / 7.0, 1.0
        there = on_way(a, chord, begin + apart * steps)
    if share == 0.0:
        return a
    # Postures in step are off by what their singularities make of rounding.
    if foreseen:
        d = along7(NO_SEED, 1.0 / length, chord)
        turning, is_there = correct(P, by, on_cubic(before, behind, chord, share), d, dot7(d, a) + share * length)
    else:
        turning, is_there = between(P, by, (a, NO_SEED), (b, NO_SEED), share)
    return turning if is_there else a
