"""Arm angles at which a spherical joint reaches a limit, the end of its reach or a singularity: roots of forms."""

import math

from srs_ik.kernels.algebra.joint_vectors import short_way
from srs_ik.kernels.algebra.vectors import along, dot, load3, norm, scale, sub
from srs_ik.kernels.exact.gaps import turned_with
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import limb as at
from srs_ik.kernels.limb.spherical import middle_angle, sines

TOUCH = 1e-12
"""A linear form that misses its value by less than this, relative to its swing, touches it."""

NEXT_TO_END = 1.0 - 5e-7
"""Cosines of middle joints with a larger magnitude are compared by what is left to 1."""

ROUNDING = 5e-15
"""Outer axes count as parallel at a sine that is smaller than the tolerance by this, whatever is rounded."""

WIDE_ARC = 1e-6
"""An arc of arm angles on which outer axes count as parallel, rad, is looked at closely if it is wider."""

PI = math.pi
TURN = 2.0 * math.pi


@kernel
def insert(x, values, n):
    """Insert a number into the sorted first n values; return how many they are then."""
    i = n
    while i > 0 and values[i - 1] > x:
        values[i] = values[i - 1]
        i -= 1
    values[i] = x
    return n + 1


@kernel
def add_event(psi, events, n):
    """Insert an arm angle, wrapped to [-pi, pi), into the sorted first n events."""
    psi -= TURN * math.floor((psi + PI) / TURN)
    return insert(psi - TURN if psi >= PI else psi, events, n)


@kernel
def add_roots(x, circle, value, slack, events, n):
    """Insert the arm angles at which a vector on a circle has the product `value` with x, or almost: within a slack."""
    return put_roots(dot(x, circle[1]), dot(x, circle[2]), value - dot(x, circle[0]), (1e-15, slack), events, n)


@kernel
def put_roots(c, s, rest, least, events, n):
    """Insert the arm angles at which c cos + s sin = rest; `least` are the smallest swing and the slack."""
    r = math.sqrt(c * c + s * s)
    if r < least[0] or abs(rest) > r * (1.0 + TOUCH) + least[1]:
        return n
    middle = math.atan2(s, c)
    apart = math.atan2(math.sqrt(max((r - rest) * (r + rest), 0.0)), rest)
    n = add_event(middle + apart, events, n)
    return add_event(middle - apart, events, n)


@kernel
def end_of_middle(P, k, end):
    """The end of the range of a middle joint's cosine that its lower (0) or upper (1) limit is next to: 1.0 or -1.0.

    With it, how far the limit is from that end, with all digits.
    """
    half = 0.5 * (P[(at.LOWER if end == 0 else at.UPPER) + int(P[k + at.FIRST_JOINT]) + 1] - P[k + at.PHASE])
    span = 2.0 - P[k + at.TOP_GAP] - P[k + at.BOTTOM_GAP]
    if P[k + at.BOUND_2_LOWER + end] > 0.0:
        return 1.0, P[k + at.TOP_GAP] + span * math.sin(half) ** 2
    return -1.0, P[k + at.BOTTOM_GAP] + span * math.cos(half) ** 2


@kernel
def beyond_middle(P, k, end, centre, square):
    """By how much the cosine of a middle joint is beyond a limit of it, where the vector a3 is `centre` and more.

    What is more is across that, and has this square length. Next to a singular angle a cosine has lost its digits.
    """
    a1, value = load3(P, k + at.A1), P[k + at.BOUND_2_LOWER + end]
    if abs(value) < NEXT_TO_END:
        return dot(a1, centre) - value
    way, gap = end_of_middle(P, k, end)
    return way * short_of_end(scale(way, a1), gap, centre, square)


@kernel
def short_of_end(axis, gap, centre, square):
    """By how much the cosine between an axis and a vector is beyond 1 - gap, where the vector is `centre` and more.

    What is more is across that, and has this square length. The gap has all its digits, and they are kept.
    """
    off = sub(axis, centre)
    return gap - 0.5 * (dot(off, off) + square)


@kernel
def end_of_reach(P, k, end):
    """What a3 comes closest to at an end of the middle joint's reach, a1 (0) or -a1 (1), and 1 - the cosine there."""
    if end == 0:
        return load3(P, k + at.A1), P[k + at.TOP_GAP]
    return scale(-1.0, load3(P, k + at.A1)), P[k + at.BOTTOM_GAP]


@kernel
def add_approach(axis, gap, circle, slack, events, n):
    """Insert the arm angles at which a vector on a circle has the cosine 1 - gap with an axis, or almost: by an angle.

    The gap has all its digits, and the arm angles keep them where the circle passes the axis closely.
    """
    c, s = dot(axis, circle[1]), dot(axis, circle[2])
    size = math.sqrt(c * c + s * s)
    wanted = math.sqrt(2.0 * gap)
    if size < 1e-15 * (wanted + slack):
        return n
    closest = along(along(circle[0], c / size, circle[1]), s / size, circle[2])
    least = norm(sub(axis, closest))
    # From the closest point on, the square of the distance grows by this times the square of the sine of half the way.
    most = 4.0 * size
    square = (wanted - least) * (wanted + least)
    touch = 2.0 * (size * TOUCH + slack * (wanted + slack))
    if square < -touch or square > most + touch:
        return n
    middle, away = math.atan2(s, c), 2.0 * math.asin(math.sqrt(min(max(square / most, 0.0), 1.0)))
    n = add_event(middle + away, events, n)
    return add_event(middle - away, events, n)


@kernel
def add_middle(P, k, circle, end, events, n):
    """Insert the arm angles at which a middle joint is on its lower (0) or upper (1) limit."""
    a1, value = load3(P, k + at.A1), P[k + at.BOUND_2_LOWER + end]
    if abs(value) >= NEXT_TO_END:
        way, gap = end_of_middle(P, k, end)
        return add_approach(scale(way, a1), gap, circle, P[at.SLACK_LIMIT], events, n)
    return add_roots(a1, circle, value, P[at.SLACK_LIMIT], events, n)


@kernel
def add_limit(P, x, circle, value, events, n):
    """Insert the arm angles at which a joint is on a limit, or those at which it is a band away from it."""
    band, slack = P[at.BAND], P[at.SLACK_LIMIT]
    if band == 0.0:
        return add_roots(x, circle, value, slack, events, n)
    n = add_roots(x, circle, value - band, slack, events, n)
    return add_roots(x, circle, value + band, slack, events, n)


@kernel
def add_joined(P, k, circle, joint, events, n):
    """Insert the arm angles at which a band joins what is ahead of a narrow range and what is behind it."""
    x, y = P[at.COS_LOWER + joint] + P[at.COS_UPPER + joint], P[at.SIN_LOWER + joint] + P[at.SIN_UPPER + joint]
    sine2, size2 = 4.0 * P[at.BAND] * P[at.BAND], x * x + y * y
    if P[at.BAND] <= 0.0 or P[at.RANGE_KIND + joint] != 1.0 or sine2 >= size2:
        return n
    gap = 1.0 - math.sqrt(1.0 - sine2 / size2)
    n = add_approach(load3(P, k + at.A1), gap, circle, P[at.SLACK_LIMIT], events, n)
    return add_approach(scale(-1.0, load3(P, k + at.A1)), gap, circle, P[at.SLACK_LIMIT], events, n)


@kernel
def sum_at(P, k, motion, psi):
    """At an arm angle, the sum of the outer joints of a spherical joint that is singular there, and the sign of q1."""
    v, y = turned_with(motion, psi)
    c, s, _ = middle_angle(P, k, v)
    _, _, three, _ = sines(P, k, v, y, c, s)
    return math.atan2(three[1], three[0]), 1.0 if c > 0.0 else -1.0


@kernel
def add_split_ends(P, k, motion, psi, away, events, n):
    """Insert the arm angles at which a sum that is free to be split, from psi - away to psi + away, leaves its limits.

    The whole arm turns about an axis almost in line with joint 1 there, so the sum changes as the arm angle does.
    """
    first = int(P[k + at.FIRST_JOINT])
    step = min(0.5 * away, 0.5)
    total, toward = sum_at(P, k, motion, psi)
    other, _ = sum_at(P, k, motion, psi + step)
    way = 1.0 if short_way(other - total) > 0.0 else -1.0
    for end in range(2):
        low, high = P[at.LOWER + first], P[at.UPPER + first]
        limit = (high if toward > 0.0 else -low) if end == 1 else (low if toward > 0.0 else -high)
        limit += P[(at.UPPER if end == 1 else at.LOWER) + first + 2]
        if math.isfinite(limit):
            n = add_event(psi + way * (limit - total), events, n)
    return n


@kernel
def add_singular(P, k, motion, end, events, n):
    """Insert the arm angle at which axes 1 and 3 come closest to parallel, and those at which they count as parallel.

    The end says whether they point the same way there (0) or opposite ways (1). Passing it, joints 1 and 3 jump by half
    a turn within the branch; where the axes count as parallel, any split of their sum will do.
    """
    a1, circle = load3(P, k + at.A1), motion[0]
    sign = 1.0 if end == 0 else -1.0
    c, s = sign * dot(a1, circle[1]), sign * dot(a1, circle[2])
    size = math.sqrt(c * c + s * s)
    if sign * dot(a1, circle[0]) + size <= 1.0 - TOUCH:
        return n
    psi = math.atan2(s, c)
    if size > 1e-15:
        n = add_event(psi, events, n)
    # Sines of the angles from S-W: of axis 3, which goes around, and of axis 1, which stays.
    radius = norm(circle[1])
    least = radius - (size / radius if size > 0.0 else 0.0)
    width = P[at.SLACK_SINGULAR] - ROUNDING
    rest = (width - least) * (width + least)
    if rest <= 0.0:
        return n
    away = math.pi
    if rest < 4.0 * size:
        away = 2.0 * math.asin(math.sqrt(0.25 * rest / size))
        n = add_event(psi - away, events, add_event(psi + away, events, n))
    return add_split_ends(P, k, motion, psi, away, events, n) if away > WIDE_ARC else n


@kernel
def joint_events(P, k, motion, events):
    """Arm angles at which the spherical joint at block k reaches a limit, the end of its reach, or a singularity."""
    v, _, r = motion
    first = int(P[k + at.FIRST_JOINT])
    n = 0
    if P[at.RANGE_KIND + first] != 0.0:
        n = add_limit(P, load3(P, k + at.BOUND_1_LOWER), v, P[k + at.A2_A3], events, n)
        n = add_limit(P, load3(P, k + at.BOUND_1_UPPER), v, P[k + at.A2_A3], events, n)
    if P[at.RANGE_KIND + first + 1] != 0.0:
        n = add_middle(P, k, v, 0, events, n)
        n = add_middle(P, k, v, 1, events, n)
    if P[at.RANGE_KIND + first + 2] != 0.0:
        n = add_limit(P, load3(P, k + at.BOUND_3_LOWER), r, P[k + at.A1_A2], events, n)
        n = add_limit(P, load3(P, k + at.BOUND_3_UPPER), r, P[k + at.A1_A2], events, n)
    if P[at.BAND] > 0.0:
        n = add_joined(P, k, v, first, events, n)
        n = add_joined(P, k, v, first + 2, events, n)
    for end in range(2):
        if P[k + (at.TOP_GAP if end == 0 else at.BOTTOM_GAP)] == 0.0:
            n = add_singular(P, k, motion, end, events, n)
        else:
            axis, gap = end_of_reach(P, k, end)
            n = add_approach(axis, gap, v, P[at.SLACK_LIMIT], events, n)
    return n
