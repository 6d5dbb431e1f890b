"""Elbows as good as flat: all the bends that a pose cannot tell from each other.

A bend x changes the length of the arm by x^2 / 8 of it, so rounding hides bends up to 1e-8 or so. But it turns the
upper arm by x / 2, and an outer joint next to its singularity turns far with that. So a feasible posture of a pose with
a flat elbow may be one at another bend.
"""

import math

import numpy as np

from srs_ik.kernels.algebra.pointers import copy, row, scratch
from srs_ik.kernels.exact.bend_crossings import MOST_CROSSINGS, MOST_CURVES, bends_of_crossings
from srs_ik.kernels.exact.bend_events import MOST_EVENTS, bend_in_line, bends_at
from srs_ik.kernels.exact.bends import bent_place
from srs_ik.kernels.exact.events import TURN
from srs_ik.kernels.exact.gaps import ROUNDING, can_be
from srs_ik.kernels.exact.intervals import find_intervals, join_touching, write_interval
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import limb as at
from srs_ik.kernels.layout.answer import MAX_PIECES, SOLVED
from srs_ik.kernels.layout.limb import SIZE
from srs_ik.kernels.limb.branches import best_branch
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE
from srs_ik.kernels.limb.in_line import may_split
from srs_ik.kernels.limb.limits import is_inside, tighten
from srs_ik.kernels.limb.triangle import shoulder_columns, side_frames, wrist_columns

NEARLY_FLAT = 3e-6
"""Bends of the elbow below this, rad from straight or from folded, cannot be told apart within 1e-11 of reach."""

ALMOST_FLAT = 1e-3
"""Bends below this are told so badly that next to a singular shoulder or wrist the ends of intervals move with that."""

SMALLEST_BEND = 2.5e-10
"""The smallest bend that is tried, but for none."""

LARGEST_BEND = 4e-6
UNTOLD_REACH = 1e-11
"""The largest bend that is tried of a flat elbow; a smaller one where it would take more than this off the reach, m."""

LEVELS = 26
CLOSER = 0.5
"""Around a bend that brings outer axes into line others are tried, each closer to it by this factor."""

SAME_BEND = 1e-11
"""Bends that differ by a smaller part of them are one."""

NOTABLE = 2e-7
GROWTH, LONGEST_STEP = 0.4, 0.02
NARROW = 4.0 * NOTABLE
"""Ends of intervals are looked for this closely, in steps that grow with the way by this part of it, up to the longest,
rad; an interval narrower than the last is as good as one arm angle."""

HIDING = 1e-9
"""Limits that are so much farther out, rad, tell postures that rounding hides."""


@kernel
def is_as_good_as_flat(place_):
    """Whether a pose leaves the bend of the elbow open."""
    return place_[3] < NEARLY_FLAT


@kernel
def is_almost_flat(place_):
    """Whether a pose tells the bend of the elbow badly, or leaves it open."""
    return place_[3] < ALMOST_FLAT


@kernel
def joined(a, n, b, m, out):
    """Write the union of two lists of intervals into rows of out, branch after branch and sorted; their number."""
    count = 0
    for branch in range(8):
        first = count
        for i in range(n + m):
            psi = a[i] if i < n else b[i - n]
            if int(psi[0]) == branch:
                count = write_interval(out, first, count, branch, psi[1], psi[2])
        if count > first:
            count = join_touching(out, first, count)
    return count


@kernel
def merge(P, place_, x, found, both, out, n):
    """Join the intervals at a bend to the first n in rows of out; their number."""
    m = find_intervals(P, bent_place(place_, x), -1, found)
    n = min(joined(out, n, found, m, both), out.shape[0])
    copy(row(both, 0), row(out, 0), 3 * n)
    return n


@kernel
def span_of_bends(P, place_):
    """The smallest and the largest bend that are tried of a pose whose elbow is as good as flat, as sines."""
    reach, own = P[at.FAR] if place_[2] > 0.0 else P[at.NEAR], place_[3]
    untold = math.sqrt(8.0 * UNTOLD_REACH * reach / ((P[at.FAR] - P[at.NEAR]) * (P[at.FAR] + P[at.NEAR])))
    untold = max(min(LARGEST_BEND, untold), SMALLEST_BEND)
    return math.sqrt(max(own * own - untold * untold, 0.0)), math.sqrt(own * own + untold * untold)


@kernel
def take_centres(P, place_, span, centres):
    """Fill in the bends at which outer axes come into line, each once; their number."""
    n = 0
    for i in range(8):
        x = bend_in_line(P, place_, at.SHOULDER if i < 4 else at.WRIST, (i >> 1) & 1, i & 1, span)
        known = x < 0.0
        for j in range(n):
            known = known or abs(x - centres[j]) <= SAME_BEND * x
        if not known:
            centres[n] = x
            n += 1
    return n


@kernel
def is_pinned(P):
    """Whether limits leave an outer joint less room than rounding takes of it at the smallest bends."""
    k = at.INVERSE_HALF_RANGE
    narrowest = max(max(P[k], P[k + 2]), max(P[k + 4], P[k + 6]))
    return narrowest > 2.0 * SMALLEST_BEND / ROUNDING


@kernel
def keeps_limits(P, place_, c, s, branch):
    """Whether a branch keeps the limits at an arm angle, given by cosine and sine, but for rounding."""
    base, arm, c4, s4 = side_frames(P, place_, branch >> 2, c, s)
    if not is_inside(P, 3, c4, s4, P[at.SLACK_LIMIT]):
        return False
    v, y = shoulder_columns(P, base, arm)
    if not can_be(P, at.SHOULDER, v, y, (branch >> 1) & 1):
        return False
    v, y = wrist_columns(P, place_, base, arm, c4, s4)
    return can_be(P, at.WRIST, v, y, branch & 1)


@kernel
def is_met(asked, psi):
    """Whether a branch of a pose with a flat elbow has a posture at an arm angle, at any bend.

    A joint that cannot move is on its limits at single bends, which rounding misses: only there it is made up for.

    `asked` holds the packed limb, the pose, the branch, the span of bends, and work space, (MOST_EVENTS,).
    """
    P, place_, branch, span, bends = asked
    n, pinned = bends_at(P, place_, psi, branch >> 2, span, bends), is_pinned(P)
    c, s = math.cos(psi), math.sin(psi)
    for i in range(2 * n - 1):
        x = bends[i // 2] if i % 2 == 0 else 0.5 * (bends[i // 2] + bends[i // 2 + 1])
        bent = bent_place(place_, x)
        if pinned:
            if keeps_limits(P, bent, c, s, branch):
                return True
        elif best_branch(P, bent, psi, branch, False, NO_SEED, True)[2] < OUTSIDE:
            return True
    return False


@kernel
def walk_on(asked, psi, way, room):
    """How far a branch goes on from a met arm angle, in growing steps: that, and where it is not met, or the room."""
    good, bad = 0.0, NOTABLE
    while bad < room and is_met(asked, psi + way * bad):
        good, bad = bad, bad + min(GROWTH * bad, LONGEST_STEP)
    return good, min(bad, room)


@kernel
def reach_on(asked, psi, way, room, beyond):
    """How far a branch goes on from an arm angle that is met, upwards (way 1.0) or downwards (-1.0): at most room, rad.

    `beyond` says whether the arm angle at the end of the room is met: then a gap next to that is looked for from there.
    """
    good, bad = walk_on(asked, psi, way, room)
    if bad == room and beyond:
        back, gap = walk_on(asked, psi + way * room, -way, room - good)
        if room - gap <= good and is_met(asked, psi + way * 0.5 * (good + room - back)):
            return room
        bad = room - gap if room - gap > good else room - back
    while bad - good > NOTABLE:
        middle = 0.5 * (good + bad)
        if is_met(asked, psi + way * middle):
            good = middle
        else:
            bad = middle
    return good


@kernel
def back_to_met(asked, psi, way, width):
    """How far back from an arm angle of a branch, in doubling steps, one is met; the width, rad, if none is."""
    back = NOTABLE
    while back < width and not is_met(asked, psi - way * back):
        back *= 2.0
    return min(back, width)


@kernel
def end_of(asked, eased, psi, way, width, room):
    """Where the interval of a branch ends that ends at psi at one bend, upwards (way 1.0) or downwards (-1.0), rad.

    With its width, and the room up to the next one, rad. Next to a singularity rounding may have put psi outside; where
    limits leave no arm angle but for rounding, the eased ones tell.
    """
    if is_met(asked, psi):
        return psi + way * reach_on(asked, psi, way, room, True)
    back = back_to_met(asked, psi, way, width)
    if back < width:
        inner = psi - way * back
        return inner + way * reach_on(asked, inner, way, back, False)
    if is_met(eased, psi):
        return psi
    back = back_to_met(eased, psi, way, width)
    if back >= width:
        return psi
    inner = psi - way * back
    return inner + way * reach_on(eased, inner, way, back, False)


@kernel
def ends_of(asked, eased, lower, upper, before, behind):
    """Where the interval of a branch ends at any bend that ends so at one, up to the intervals before and behind it."""
    if upper - lower > NARROW:
        width = upper - lower
        below = end_of(asked, eased, lower, -1.0, width, lower - before)
        return below, end_of(asked, eased, upper, 1.0, width, behind - upper)
    for i in range(3):
        psi = 0.5 * (lower + upper) + NOTABLE * (i if i < 2 else -1)
        if before < psi < behind and is_met(asked, psi):
            return psi - reach_on(asked, psi, -1.0, psi - before, True), psi + reach_on(
                asked, psi, 1.0, behind - psi, True
            )
    return lower, upper


@kernel
def take_met(asked, eased, rows):
    """Move to the front those intervals of a branch that are wide, or of which an arm angle is met; their number.

    Eased limits alone may tell of a narrow one, at a bend at which no other has it.
    """
    n = 0
    for i in range(rows.shape[0]):
        lower, upper = rows[i, 1], rows[i, 2]
        kept = upper - lower > NARROW
        for j in range(3):
            psi = lower + 0.5 * j * (upper - lower)
            kept = kept or is_met(asked, psi) or is_met(eased, psi)
        if kept:
            rows[n, 1], rows[n, 2] = lower, upper
            n += 1
    return n


@kernel
def stretch(limbs, place_, span, rows, out):
    """Take the ends of sorted intervals of all branches as far as any bend allows; write them to out; their number.

    `limbs` are the packed limb and the one with eased limits, of which the intervals are.
    """
    bends = np.empty(MOST_EVENTS)
    n, first, count = rows.shape[0], 0, 0
    while first < n:
        branch, last = int(rows[first, 0]), first
        while last + 1 < n and int(rows[last + 1, 0]) == branch:
            last += 1
        asked = (limbs[0], place_, branch, span, bends)
        eased = (limbs[1], place_, branch, span, bends)
        begin, last_met = count, first + take_met(asked, eased, rows[first : last + 1]) - 1
        for i in range(first, last_met + 1):
            before = rows[i - 1, 2] if i > first else rows[last_met, 2] - TURN
            behind = rows[i + 1, 1] if i < last_met else rows[first, 1] + TURN
            lower, upper = ends_of(asked, eased, rows[i, 1], rows[i, 2], before, behind)
            count = write_interval(out, begin, count, branch, lower, upper)
        if count > begin:
            count = join_touching(out, begin, count)
        first = last + 1
    return count


@kernel
def ease(P, box):
    """Copy a packed limb to `box` with limits a little farther out, but no farther than what is put on them.

    Where limits of several joints meet in one point, rounding leaves no room between them.
    """
    tighten(P, NO_SEED, math.inf, 0.5 * P[at.SLACK_LIMIT], box)


@kernel
def intervals_of_bends(family, place_, respect, out, n):
    """Join to the first n intervals in rows of out those that a pose has at other bends; their number.

    Where outer axes come into line at one of them, intervals move far next to it, and part. What lies between those of
    neighbouring bends is looked for at every end.
    """
    found, both = np.empty((8 * MAX_PIECES, 3)), np.empty((16 * MAX_PIECES, 3))
    centres = np.empty(8)
    P = row(family, at.LOOSE + (at.LIMITED if respect else at.FREE))
    eased = row(scratch(1, SIZE), 0)
    ease(P, eased)
    span = span_of_bends(P, place_)
    bends, curves = np.empty(MOST_CROSSINGS), np.empty((MOST_CURVES, 4))
    n = merge(eased, place_, place_[3], found, both, out, n)
    crossings = bends_of_crossings(eased, place_, span, curves, bends)
    for i in range(crossings):
        if i == 0 or bends[i] - bends[i - 1] > SAME_BEND * bends[i]:
            n = merge(eased, place_, bends[i], found, both, out, n)
            if i > 0:
                n = merge(eased, place_, 0.5 * (bends[i - 1] + bends[i]), found, both, out, n)
    for i in range(take_centres(P, place_, span, centres)):
        n = merge(eased, place_, centres[i], found, both, out, n)
        away = span[1]
        for _ in range(LEVELS):
            away *= CLOSER
            if centres[i] - away > span[0]:
                n = merge(eased, place_, centres[i] - away, found, both, out, n)
            if centres[i] + away < span[1]:
                n = merge(eased, place_, centres[i] + away, found, both, out, n)
    copy(row(out, 0), row(both, 0), 3 * n)
    return stretch((P, eased), place_, span, both[:n], out)


@kernel
def exact_intervals(family, target, respect, out):
    """Feasible intervals of one pose in closed form: how many, and whether they tell all.

    They do not where there are none and rounding may hide a posture.
    """
    place_ = target.place
    if abs(place_[5]) >= SOLVED:
        return 0, True
    P = row(family, at.LIMITED if respect else at.FREE)
    n = find_intervals(P, place_, -1, out)
    if is_almost_flat(place_):
        n = intervals_of_bends(family, place_, respect, out, n)
        return n, n > 0 or not respect
    if n > 0 or not respect:
        return n, True
    box = row(scratch(1, SIZE), 0)
    tighten(row(family, at.LOOSE), NO_SEED, math.inf, HIDING, box)
    hidden = find_intervals(box, place_, -1, out) > 0
    if hidden:
        # A pose whose postures all lie on limits leaves room by rounding alone.
        ease(row(family, at.LOOSE), box)
        n = find_intervals(box, place_, -1, out)
    return n, n > 0 or not (hidden or may_split(P, place_))


@kernel
def intervals_around(family, place_, found, out):
    """Write the one interval around a posture (branch, arm angle) that limits leave alone; one row."""
    branch, psi = found
    n = write_interval(out, 0, 0, branch, psi, psi)
    if is_almost_flat(place_):
        P = row(family, at.LOOSE)
        one, eased = np.empty((1, 3)), row(scratch(1, SIZE), 0)
        ease(P, eased)
        copy(row(out, 0), row(one, 0), 3)
        # A posture between limits that meet in one point has its arm angle alone, which no bend may have again.
        n = max(n, stretch((P, eased), place_, span_of_bends(P, place_), one, out))
    return n
