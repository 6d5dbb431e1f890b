"""Where a curve goes over from one branch into another: shoulder, elbow or wrist pass their singularity there."""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.joint_vectors import along7, difference, dot7, short_way
from srs_ik.kernels.algebra.minimum import lowest_of_cubic
from srs_ik.kernels.algebra.roots import has_settled, next_parameter, start_crossing, tell_figure
from srs_ik.kernels.curves.ends import meet, on_chord, on_curve, sample_before
from srs_ik.kernels.curves.follow import tangent_at
from srs_ik.kernels.curves.in_step import ARC, load_sample
from srs_ik.kernels.curves.told import TOLD_MIDDLES, TOLD_SINES
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.limb.branches import phase_of, sine_of

CHANGE = 2
CHANGE_AT = 0
CHANGE_MIDDLE = 1
"""A change of branch: parameter of the curve, and which middle angle changes sides: 0 shoulder, 1 elbow, 2 wrist."""

MOST_CHANGES = 6
"""A middle angle changes sides no more than twice between two samples."""

CHANGE_STEPS = 60
DIP_STEPS = 8
"""Steps that find where an angle changes sides, and where one that stays on its side comes closest to the other."""

FORETOLD = 4.0
"""What is so many times as far from zero as from what was foretold does not reach zero."""

FROM_ENDS = 0.01
"""Where a figure is lowest between two samples is looked for no closer to them than this part of the way."""


@kernel
def put_change(changes, n, x, middle):
    """Insert a change among n sorted ones; their number."""
    i = n
    while i > 0 and changes[i - 1, CHANGE_AT] > x:
        changes[i, CHANGE_AT], changes[i, CHANGE_MIDDLE] = changes[i - 1, CHANGE_AT], changes[i - 1, CHANGE_MIDDLE]
        i -= 1
    changes[i, CHANGE_AT], changes[i, CHANGE_MIDDLE] = x, middle
    return n + 1


@kernel
def met_change(P, by, curve, middle, x, y):
    """`change_between` by Newton's method for the pose and the angle together: parameter, and whether that is met."""
    rows = curve.rows
    low = sample_before(curve, 0.5 * (x + y))
    if x < rows[low, 0] or y > rows[low + 1, 0]:
        return x, False
    a, b = on_chord(rows, low, x), on_chord(rows, low, y)
    joint, phase = 1 + 2 * middle, phase_of(P, middle)
    at_a, at_b = math.sin(a[joint] - phase), math.sin(b[joint] - phase)
    if at_a * at_b >= 0.0:
        return x, False
    share = at_a / (at_a - at_b)
    turned = a[joint] + share * short_way(b[joint] - a[joint])
    angle = phase + math.pi * math.floor((turned - phase) / math.pi + 0.5)
    _, found, met = meet(P, by, rows, low, along7(a, share, difference(a, b)), joint, angle)
    return found, met and x < found < y


@kernel
def change_between(P, by, curve, middle, a, b):
    """The parameter between two, each with its sine, at which a middle angle changes sides."""
    (x, at_x), (y, at_y) = a, b
    found, met = met_change(P, by, curve, middle, x, y)
    if met:
        return found
    side = -1.0 if at_x >= 0.0 else 1.0
    crossing = start_crossing(x, side * at_x, y, side * at_y)
    for _ in range(CHANGE_STEPS):
        if has_settled(crossing):
            break
        wanted = next_parameter(crossing)
        q, _ = on_curve(P, by, 0, curve, wanted)
        crossing = tell_figure(crossing, wanted, side * sine_of(P, q, middle))
    return crossing[0]


@kernel
def rate_of_sine(P, by, q, middle, chord):
    """How fast the sine of a middle angle changes along a curve that goes on as a chord does."""
    t, _ = tangent_at(P, by, q)
    joint = 1 + 2 * middle
    return math.cos(q[joint] - phase_of(P, middle)) * math.copysign(t[joint], t[joint] * dot7(t, chord))


@kernel
def dip_between(P, by, curve, middle, a, b):
    """A parameter between two samples of one side at which a middle angle is on the other: it, its sine, if any.

    A sample is given as its parameter and its posture.
    """
    (x_a, q_a), (x_b, q_b) = a, b
    chord = difference(q_a, q_b)
    side = 1.0 if sine_of(P, q_a, middle) >= 0.0 else -1.0
    first = (x_a, side * sine_of(P, q_a, middle), side * rate_of_sine(P, by, q_a, middle, chord))
    last = (x_b, side * sine_of(P, q_b, middle), side * rate_of_sine(P, by, q_b, middle, chord))
    for _ in range(DIP_STEPS):
        if first[2] >= 0.0 or last[2] <= 0.0:
            break
        x, foretold = lowest_of_cubic(first, last, FROM_ENDS)
        q, _ = on_curve(P, by, 0, curve, x)
        height = side * sine_of(P, q, middle)
        if height < 0.0:
            return x, side * height, True
        if height > FORETOLD * abs(height - foretold):
            break
        here = (x, height, side * rate_of_sine(P, by, q, middle, chord))
        if here[2] < 0.0:
            first = here
        else:
            last = here
    return x_a, 0.0, False


@kernel
def may_dip(P, middle, a, b, told):
    """Whether a middle angle falls towards its singularity behind one sample and rises from it before the next.

    A sample is given as its posture, the rates of middle angles that both tell as rows of `told`.
    """
    joint, phase = 1 + 2 * middle, phase_of(P, middle)
    side = math.copysign(1.0, told[0][TOLD_SINES + middle])
    rate_a = side * math.cos(a[joint] - phase) * told[0][TOLD_MIDDLES + middle]
    rate_b = side * math.cos(b[joint] - phase) * told[1][TOLD_MIDDLES + middle]
    return rate_a < 0.0 < rate_b


@kernel
def find_changes(P, by, curve, i, told, changes):
    """Write the changes of branch between samples i - 1 and i, in their order, into rows of changes; their number.

    `told` holds what samples tell.
    """
    x_a, x_b = curve.rows[i - 1, 0], curve.rows[i, 0]
    q_a, q_b = load_sample(curve.rows[i - 1]), load_sample(curve.rows[i])
    n = 0
    for middle in range(3):
        at_a, at_b = told[i - 1, TOLD_SINES + middle], told[i, TOLD_SINES + middle]
        if (at_a >= 0.0) != (at_b >= 0.0):
            n = put_change(changes, n, change_between(P, by, curve, middle, (x_a, at_a), (x_b, at_b)), middle)
        elif abs(at_a + at_b) < ARC * (x_b - x_a) and may_dip(P, middle, q_a, q_b, (told[i - 1], told[i])):
            x, at_x, found = dip_between(P, by, curve, middle, (x_a, q_a), (x_b, q_b))
            if found:
                n = put_change(changes, n, change_between(P, by, curve, middle, (x_a, at_a), (x, at_x)), middle)
                n = put_change(changes, n, change_between(P, by, curve, middle, (x, at_x), (x_b, at_b)), middle)
    return n
