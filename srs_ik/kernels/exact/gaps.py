"""Which solutions of a spherical joint keep the limits between the arm angles at which that may change, in eights."""

import math

from srs_ik.kernels.algebra.lane_trig import turn
from srs_ik.kernels.algebra.lanes import ALL, as_bits, eight_of, root, where
from srs_ik.kernels.algebra.vectors import add, load3, norm, sub
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import limb as at
from srs_ik.kernels.limb.limits import LEVEL, TURN, is_inside, turn_to_middle, violation
from srs_ik.kernels.limb.spherical import angles, columns_at, eight_middles, middle_anchor, middle_angle, sines
from srs_ik.kernels.limb.splits import nearest_split

ROUNDING = 4e-15
"""What rounding makes of directions; over the sine of a middle angle, of the outer angles, rad."""

NARROW = 1e-6
"""A gap narrower than this, rad, is looked at by itself: next to what it lies between, rounding decides."""

AT_ITS_END = 2e-14
CLOSE_TO_END = 1e-13
"""A cosine this far out of the reach of oblique axes is at its end, as far as a pose with a folded elbow tells; no
farther than what such an angle makes of it, rad."""


@kernel
def splits_inside(P, k, turn_1, turn_3, toward, give):
    """Whether two outer joints, given by cosine and sine, keep their limits but for what rounding makes of their split.

    That is the more, the closer their axes are to one line: `give`, rad.
    """
    first = int(P[k + at.FIRST_JOINT])
    if give <= P[at.SLACK_LIMIT] or not is_inside(P, first, turn_1[0], turn_1[1], give):
        return False
    q1 = turn_to_middle(P, first, math.atan2(turn_1[1], turn_1[0]))
    q3 = turn_to_middle(P, first + 2, math.atan2(turn_3[1], turn_3[0]))
    a, b = nearest_split(P, k, first, toward * q1 + q3, toward, q1, q3)
    return abs(a - q1) <= 2.0 * give and max(violation(P, first, a), violation(P, first + 2, b)) <= P[at.SLACK_LIMIT]


@kernel
def fits(P, k, v, y, c, s, sign):
    """Whether one solution of the spherical joint at block k has turns inside the limits."""
    first = int(P[k + at.FIRST_JOINT])
    one, two, three, length = sines(P, k, v, y, c, s if sign == 0 else -s)
    slack = P[at.SLACK_LIMIT]
    if not is_inside(P, first + 1, two[0], two[1], slack):
        return False
    if P[at.BAND] != 0.0:
        slack = P[at.BAND] / math.sqrt(max(length, 1e-12))
        return is_inside(P, first, one[0], one[1], slack) and is_inside(P, first + 2, three[0], three[1], slack)
    if length > 0.0:
        if is_inside(P, first, one[0], one[1], slack) and is_inside(P, first + 2, three[0], three[1], slack):
            return True
        return splits_inside(P, k, one, three, 1.0 if c > 0.0 else -1.0, ROUNDING / math.sqrt(length))
    q = angles(P, k, v, y, c, s, sign, middle_anchor())
    return (
        violation(P, first, turn_to_middle(P, first, q[0])) == 0.0
        and violation(P, first + 2, turn_to_middle(P, first + 2, q[2])) == 0.0
    )


@kernel
def can_be(P, k, v, y, sign):
    """Whether one solution of the spherical joint at block k exists and keeps the limits."""
    c, s, reached = middle_angle(P, k, v)
    return reached and fits(P, k, v, y, c, s, sign)


@kernel
def turned_with(motion, psi):
    """The two columns of a spherical joint's rotation that its angles depend on, at an arm angle."""
    return columns_at(motion, math.cos(psi), math.sin(psi))


@kernel
def feasible_signs(P, k, motion, psi, wanted):
    """Which of the wanted solutions (bits 1: first, 2: second) of a spherical joint keep the limits at psi."""
    v, y = turned_with(motion, psi)
    c, s, reached = middle_angle(P, k, v)
    if not reached:
        return 0
    first = 1 if wanted & 1 and fits(P, k, v, y, c, s, 0) else 0
    return first | (2 if wanted & 2 and fits(P, k, v, y, c, s, 1) else 0)


@kernel
def almost_fits(P, k, motion, psi, sign):
    """Whether one solution of a spherical joint keeps the limits at an arm angle where its reach may end."""
    v, y = turned_with(motion, psi)
    c, s, _ = middle_angle(P, k, v)
    up, down = norm(sub(v, load3(P, k + at.A1))), norm(add(v, load3(P, k + at.A1)))
    if P[k + at.TOP_GAP] - 0.5 * up * up > min(AT_ITS_END, CLOSE_TO_END * up):
        return False
    if P[k + at.BOTTOM_GAP] - 0.5 * down * down > min(AT_ITS_END, CLOSE_TO_END * down):
        return False
    return fits(P, k, v, y, c, s, sign)


@kernel
def eight_outside(P, joint, turn_, slack):
    """`limits.is_inside` of eight angles, given by cosine and sine, with a slack each: bits of those that are not."""
    kind = P[at.RANGE_KIND + joint]
    if kind == 0.0:
        return 0
    c, s = turn_
    cl, sl = P[at.COS_LOWER + joint], P[at.SIN_LOWER + joint]
    cu, su = P[at.COS_UPPER + joint], P[at.SIN_UPPER + joint]
    low, high = cl * s - sl * c < -slack, su * c - cu * s < -slack
    if kind == 1.0:
        x, y = cl + cu, sl + su
        apart = (slack < 0.0) | (4.0 * slack * slack < x * x + y * y)
        return as_bits(low | high | (apart & (x * c + y * s < -LEVEL)))
    return as_bits(low & high)


@kernel
def eight_misfits(P, k, v, y, c, s):
    """Bits of eight solutions of a spherical joint outside the limits, and of those that have to be looked at alone."""
    first = int(P[k + at.FIRST_JOINT])
    q1, q2, q3, length = sines(P, k, v, y, c, s)
    slack = P[at.SLACK_LIMIT] + 0.0 * length
    outside = eight_outside(P, first + 1, q2, slack)
    if P[at.BAND] != 0.0:
        slack = P[at.BAND] / root(where(length > 1e-12, length, 1e-12))
    outside |= eight_outside(P, first, q1, slack) | eight_outside(P, first + 2, q3, slack)
    return outside, ALL ^ as_bits(length > 0.0)


@kernel
def eight_signs(P, k, motion, psi):
    """`feasible_signs` at eight arm angles: bits of those whose first solution fits, whose second, of unsure ones."""
    cos_psi, sin_psi = turn(psi)
    v, y = columns_at(motion, cos_psi, sin_psi)
    c, s, missed = eight_middles(P, k, v)
    first, unsure = eight_misfits(P, k, v, y, c, s)
    second, also = eight_misfits(P, k, v, y, c, -s)
    return ALL ^ first, ALL ^ second, unsure | also | as_bits(missed)


@kernel
def end_of_gap(events, n, i):
    """The arm angle that ends the gap behind event i of n."""
    return events[i + 1] if i + 1 < n else events[0] + TURN


@kernel
def middle_of_gap(events, n, i):
    """The middle of the gap behind event i of n, or of the last one."""
    i = min(i, n - 1)
    return 0.5 * (events[i] + end_of_gap(events, n, i))


@kernel
def mark_gaps(P, k, motion, wanted, events, n, marks):
    """Mark the gap behind each of n events of a spherical joint with its feasible signs."""
    for begin in range(0, n, 8):
        psi = eight_of(
            middle_of_gap(events, n, begin),
            middle_of_gap(events, n, begin + 1),
            middle_of_gap(events, n, begin + 2),
            middle_of_gap(events, n, begin + 3),
            middle_of_gap(events, n, begin + 4),
            middle_of_gap(events, n, begin + 5),
            middle_of_gap(events, n, begin + 6),
            middle_of_gap(events, n, begin + 7),
        )
        first, second, unsure = eight_signs(P, k, motion, psi)
        for i in range(begin, min(begin + 8, n)):
            bit = i - begin
            width = end_of_gap(events, n, i) - events[i]
            if width <= 0.0:
                marks[i] = -1
            elif (unsure >> bit) & 1 or width < NARROW:
                marks[i] = feasible_signs(P, k, motion, middle_of_gap(events, n, i), wanted)
            else:
                marks[i] = wanted & (((first >> bit) & 1) | (((second >> bit) & 1) << 1))
    # Equal events leave no gap between them: it takes after the gap before it, and so parts and joins nothing. Twice
    # around, for the last ones and the first may be equal.
    before = -1
    for i in range(2 * n):
        if marks[i % n] < 0:
            marks[i % n] = before
        before = marks[i % n]
