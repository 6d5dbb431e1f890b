"""Arm angles at which an interval is looked at first: evenly spaced, and more where the joints move fast or jump."""

import math

from srs_ik.kernels.algebra.vectors import dot, load3, rotate
from srs_ik.kernels.exact.events import insert
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import limb as at

STEP = 2.0 * math.pi / 48.0
"""Widest spacing."""

SMALLEST_COUNT = 8
"""Fewest parts into which an interval is cut."""

BESIDE = 1e-8
"""So close on either side of a change of turns a sample is taken, rad: the cost may jump there."""

MAX_SAMPLES = 256
"""Most samples of an interval."""


@kernel
def add_sample(samples, n, x, lower, upper):
    """Insert an arm angle, if it lies inside, into the sorted first n samples."""
    if not lower < x < upper or n >= MAX_SAMPLES:
        return n
    return insert(x, samples, n)


@kernel
def add_swings(P, k, motion, lower, upper, samples, n):
    """Samples where a spherical joint passes close to its singularity, and joints 1 and 3 turn fast.

    There they move like the arc tangent of the distance over the closest distance, so the samples follow a tangent.
    """
    circle = motion[0]
    a1 = load3(P, k + at.A1)
    constant = dot(a1, circle[0])
    c, s = dot(a1, circle[1]), dot(a1, circle[2])
    r = math.sqrt(c * c + s * s)
    if r < 1e-9:
        return n
    for end in range(2):
        closest = constant + r if end == 0 else -(constant - r)
        middle = math.atan2(s, c) if end == 0 else math.atan2(-s, -c)
        width = math.sqrt(max(2.0 * (1.0 - closest), 1e-16)) / r
        if width > 0.5:
            continue
        for turns in range(-1, 2):
            for i in range(-4, 5):
                x = middle + 2.0 * math.pi * turns + width * math.tan(i * math.pi / 10.0)
                n = add_sample(samples, n, x, lower, upper)
    return n


@kernel
def add_changes(P, k, motion, joint, angle, lower, upper, samples, n):
    """Samples where a joint of the spherical joint at block k passes an angle, and on both sides of there.

    Where another joint passes one at once, both may keep their limits there alone.
    """
    a1, a2, a3 = load3(P, k + at.A1), load3(P, k + at.A2), load3(P, k + at.A3)
    c, s = math.cos(angle), math.sin(angle)
    place = joint - int(P[k + at.FIRST_JOINT])
    if place == 0:
        x, circle, value = rotate(a1, c, s, a2), motion[0], P[k + at.A2_A3]
    elif place == 1:
        x, circle, value = a1, motion[0], dot(a1, rotate(a2, c, s, a3))
    else:
        x, circle, value = rotate(a3, c, -s, a2), motion[2], P[k + at.A1_A2]
    c, s = dot(x, circle[1]), dot(x, circle[2])
    rest = value - dot(x, circle[0])
    r = math.sqrt(c * c + s * s)
    if abs(rest) < r:
        apart = math.atan2(math.sqrt((r - rest) * (r + rest)), rest)
        for turns in range(-1, 2):
            middle = math.atan2(s, c) + 2.0 * math.pi * turns
            for change in (middle + apart, middle - apart):
                for i in range(-1, 2):
                    n = add_sample(samples, n, change + i * BESIDE, lower, upper)
    return n


@kernel
def add_turns(P, side, seeded, lower, upper, samples, n):
    """Samples where a joint changes turns, for ranges of more than a turn.

    Next to a seed, that is where the nearer turn leaves the limits; else, half a turn from the middle of the range.
    """
    for joint in range(7):
        if joint == 3 or P[at.RANGE_KIND + joint] != 0.0 or P[at.INVERSE_HALF_RANGE + joint] == 0.0:
            continue
        k = at.SHOULDER if joint < 3 else at.WRIST
        motion = side[1] if joint < 3 else side[2]
        if seeded:
            n = add_changes(P, k, motion, joint, P[at.LOWER + joint], lower, upper, samples, n)
            n = add_changes(P, k, motion, joint, P[at.UPPER + joint], lower, upper, samples, n)
        else:
            n = add_changes(P, k, motion, joint, P[at.MIDDLE + joint] + math.pi, lower, upper, samples, n)
    return n


@kernel
def spread_evenly(lower, upper, widest, fewest, samples):
    """Fill in arm angles from end to end, no farther apart than `widest`; return their number."""
    samples[0] = lower
    if upper <= lower:
        return 1
    count = max(math.ceil((upper - lower) / widest), fewest)
    for i in range(1, count):
        samples[i] = lower + (upper - lower) * i / count
    samples[count] = upper
    return count + 1


@kernel
def take_samples(P, side, lower, upper, samples):
    """Fill in the sorted arm angles at which to look at an interval first, its ends included; return their number."""
    n = spread_evenly(lower, upper, STEP, SMALLEST_COUNT, samples)
    n = add_swings(P, at.SHOULDER, side[1], lower, upper, samples, n)
    n = add_swings(P, at.WRIST, side[2], lower, upper, samples, n)
    return add_turns(P, side, False, lower, upper, samples, n)
