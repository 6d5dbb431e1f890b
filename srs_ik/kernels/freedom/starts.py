"""Where searches for a posture start: on a grid over the turns that a pose leaves free and the arm angle.

On the nearest exact limb shoulder and wrist are each for themselves at a turn and an arm angle, so that one table of
both holds the postures of four branches. A start is a posture that costs less than those beside it.

Searches take the least costly start first, and leave out what lies next to one that was taken. The first rows of the
starts are a heap for that. One that is taken changes places with the last of them, so that none is lost and another
search can go through all of them again.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.joint_vectors import with_joint
from srs_ik.kernels.algebra.lanes import LANES, as_bits, gather, scatter
from srs_ik.kernels.algebra.pointers import read7, row
from srs_ik.kernels.algebra.vectors import apply, cross, load3, load9, norm, rotation, sub, times
from srs_ik.kernels.freedom.constraints import THIN
from srs_ik.kernels.freedom.halves import STEEP, dips, write_costs, write_halves
from srs_ik.kernels.freedom.singular import add_both_singular, add_singular
from srs_ik.kernels.freedom.turns import strip, strip_count
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.freedom import (
    ARM_ANGLES,
    BRANCH_COST,
    ELBOW_ANGLE,
    ELBOW_COST,
    HALF,
    INSIDE,
    LINE,
    MOST_STARTS,
    MOST_TAKEN,
    REACHED,
    SHIFT,
    START,
    START_COST,
    START_LEANS,
    STRIPS,
    Sought,
)
from srs_ik.kernels.layout.limb import (
    AXES,
    FAR,
    IS_CLOSED,
    LOWER,
    POINTS,
    SHOULDER,
    TIP_POSITION,
    TIP_ROTATION,
    UPPER,
    WRIST,
)
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE, elbow_part
from srs_ik.kernels.limb.triangle import elbow_side, place

OUT_OF_REACH = 0.1
"""Turns that bring the wrist this far out of reach, by the reach, are no starts."""

NO_NEARER = 2.0
"""A search does not come so much nearer to the seed than what its start costs, rad."""

NO_START = 3.5
"""A start that costs so much more than one inside the limits, rad, is of no use, neither first nor late."""

ROOM, ROOM_OF_NEAR = 1e-3, 0.1
"""A start so far inside the limits, rad, is a posture, or next to one on a limb that is almost exact."""

NO_WIDER = 0.25
"""A search from inside the limits does not widen the margin that its start has by so much."""

SCATTERED = 7
"""So many arm angles farther a start of the next roll lies where all of them cost the same."""

SAME_PLACE = 1e-6
"""Elbow and direction of the wrist that differ by less, rad, are the same."""

CLOSER = 3
"""So many times as many arm angles are looked at where a turn stands for all its rolls."""

LOOSE = 1e-3
"""Joint 7 turns the tip about the free axis where that is no farther from its own, rad and parts of the reach."""

OFF = 0.9
"""On a limb that is almost exact, joint 7 starts so far to either side of where it is wanted, too, rad. With the elbow
on a limit, equations almost depend on each other there: a search may fail from one start, and not from another."""

FEW = 4
"""Where fewer turns of a cone reach than so many, each side of the elbow counted, what is nearest to a seed is looked
for at many more."""

NOWHERE = (0.0, 0.0, 0.0)
TURN = 2.0 * math.pi

MOST_OUTSIDE = 0.3
"""An elbow farther outside its limits, rad, is no start."""

APART = 0.4
"""Starts this close to each other, rad in every joint, lead to the same posture."""

MOST_ATTEMPTS = 60
"""Searches at most, where none has found a posture yet."""

NONE_LEFT = 1e300
"""Cost where no start is left."""


@kernel
def costs_of_no_use(sought, table):
    """Between which costs of starts no search is better than the posture that is known, or the best start inside."""
    if sought.seeded:
        return (math.sqrt(table[INSIDE]) + NO_START) ** 2, math.inf
    return sought.known.cost + NO_WIDER, 0.0


@kernel
def is_inside(P, q):
    """Whether a start is so far inside the limits that a posture of the limb itself is."""
    room = ROOM if P[IS_CLOSED] == 1.0 else ROOM_OF_NEAR
    j = 0
    while j < 7 and P[LOWER + j] + room < q[j] < P[UPPER + j] - room:
        j += 1
    return j == 7


@kernel
def is_loose(P, axis):
    """Whether joint 7 turns the tip about the free axis: then the roll fixes that joint alone."""
    joint = load3(P, AXES + 18)
    off = norm(cross(joint, sub(load3(P, TIP_POSITION), load3(P, POINTS + 18))))
    return norm(cross(joint, apply(load9(P, TIP_ROTATION), axis))) < LOOSE and off < LOOSE * P[FAR]


@kernel
def fill_row(P, pose, elbow, sought, table):
    """Write what postures of a pose on one side of the elbow are and cost, if they may be of use; whether they may.

    The shoulder has written its part already where the wrist's place is that of the turn before.
    """
    seeded, wish = sought.seeded, sought.wish
    place_ = place(P, pose[0], pose[1])
    if abs(place_[5]) > OUT_OF_REACH * P[FAR]:
        return False
    side = elbow_side(P, place_, elbow)
    e, cost = elbow_part(P, side[0], seeded, wish[3], True)
    if cost >= OUTSIDE:
        outside = cost - OUTSIDE
        if outside > MOST_OUTSIDE:
            return False
        cost = STEEP * outside + ((e - wish[3]) ** 2 if seeded else 0.0)
    table[REACHED] += 1.0
    useless = costs_of_no_use(sought, table)
    if useless[0] < cost < useless[1]:
        return False
    line = place_[0]
    moved = max(abs(table[ELBOW_ANGLE] - e), norm(sub(load3(table, LINE), line)), abs(table[SHIFT] - sought.shift))
    if not moved < SAME_PLACE:
        write_halves(P, SHOULDER, side[1], sought, table)
        table[ELBOW_ANGLE], table[LINE], table[LINE + 1], table[LINE + 2] = e, line[0], line[1], line[2]
        table[SHIFT] = sought.shift
    table[ELBOW_COST] = cost
    write_halves(P, WRIST, side[2], sought, table)
    return True


@kernel
def write_minima(P, table, at_turn, sought, starts, n):
    """Write the postures of a branch that cost less than those beside them in arm angle; return how many there are.

    Not in roll, too: where a valley lies across the grid, its ends are no dips of the grid.

    Args:
        P: packed limb.
        table: (TABLE,) from `fill_row`.
        at_turn: number of the turn, and the branch: 2 for the other shoulder, plus 1 for the other wrist.
        sought: what starts are for.
        starts: (MOST_STARTS, START) output, n of them written.
        n: see above.
    """
    k, branch = at_turn
    halves = branch >> 1, 2 + (branch & 1)
    write_costs(table, halves, sought.seeded)
    useless = costs_of_no_use(sought, table)
    for first in range(0, ARM_ANGLES, LANES):
        low = dips(table, first, useless)
        for lane in range(LANES):
            at = first + lane
            if (low >> lane) & 1 == 0 or n >= MOST_STARTS - MOST_TAKEN:
                continue
            before, cost, behind = table[BRANCH_COST + at], table[BRANCH_COST + 1 + at], table[BRANCH_COST + 2 + at]
            # Where the elbow is the tightest joint, many arm angles may cost the same: then one is taken.
            if cost == behind and (cost < before or at != SCATTERED * k % ARM_ANGLES):
                continue
            for j in range(3):
                starts[n, j] = table[(halves[0] * HALF + j) * ARM_ANGLES + at]
                starts[n, 4 + j] = table[(halves[1] * HALF + j) * ARM_ANGLES + at]
            starts[n, 3] = table[ELBOW_ANGLE]
            starts[n, START_COST] = cost
            if cost < table[INSIDE] and is_inside(P, row(starts, n)):
                table[INSIDE] = cost
            n += 1
    return n


@kernel
def add_turn(P, pose, k, elbow, sought, desk, n):
    """Write the starts of turn k on one side of the elbow; return how many there are."""
    if fill_row(P, pose, elbow, sought, desk.table):
        for branch in range(4):
            n = write_minima(P, desk.table, (k, branch), sought, desk.starts, n)
    return n


@kernel
def shifted(sought, part):
    """The same at arm angles that begin at a part of the way between two: those of the next roll are between these."""
    return Sought(sought.seeded, sought.wish, sought.known, sought.loose, part * TURN / ARM_ANGLES)


@kernel
def add_shifted(P, pose, elbow, sought, desk, n):
    """Write the starts of a turn at closer arm angles, where joint 7 makes all its rolls; return how many there are."""
    for k in range(CLOSER):
        off = 0.0 if P[IS_CLOSED] == 1.0 else OFF * (k - 1)
        wish = with_joint(sought.wish, 6, sought.wish[6] + off)
        here = Sought(sought.seeded, wish, sought.known, True, 0.0)
        n = add_turn(P, pose, k, elbow, shifted(here, k / CLOSER), desk, n)
    return n


@kernel
def add_strip(P, pose, freedom, given, sought, desk, n):
    """Write the starts of a strip of rolls on one side of the elbow; return how many there are."""
    elbow, (lower, upper) = given
    R, p = pose
    if sought.loose:
        roll = 0.5 * (lower + upper)
        turn = rotation(freedom.axis, math.cos(roll), math.sin(roll))
        return add_shifted(P, (times(R, turn), p), elbow, sought, desk, n)
    # At its ends, the elbow is on a limit or straight: there may be more postures than beside them.
    count = strip_count(lower, upper, sought.seeded)
    for k in range(count):
        roll = lower + (upper - lower) * k / (count - 1)
        turn = rotation(freedom.axis, math.cos(roll), math.sin(roll))
        n = add_turn(P, (times(R, turn), p), k, elbow, shifted(sought, 0.5 * (k % 2)), desk, n)
    return n


@kernel
def starts_of_roll(P, pose, freedom, sought, desk):
    """Write a start for every dip of the cost over arm angles at rolls, of all branches; return their number."""
    n = 0
    desk.table[ELBOW_ANGLE] = math.inf
    desk.table[INSIDE] = sought.known.cost
    for elbow in range(2):
        for i in range(STRIPS):
            found, ends = strip(P, pose, freedom, elbow, i)
            if found:
                n = add_strip(P, pose, freedom, (elbow, ends), sought, desk, n)
    n = add_both_singular(P, pose, freedom.axis, sought, desk.starts, n)
    if sought.loose and sought.seeded and freedom.cone <= THIN:
        n = add_singular(P, pose, sought, desk.starts, n)
    for i in range(n):
        desk.starts[i, START_LEANS] = 0.0
    return n


@kernel
def add_turns(P, pose, given, sought, desk, n):
    """Write the starts of turns from one to before another; return how many there are."""
    R, p = pose
    freedom, turns, (first, last) = given
    for elbow in range(2):
        before = NOWHERE
        for k in range(first, last):
            turn = load9(row(turns, k), 0)
            if not sought.loose:
                n = add_turn(P, (times(R, turn), p), 0, elbow, sought, desk, n)
                continue
            # Of those that only roll the tip about its axis, one is enough.
            axis = apply(turn, freedom.axis)
            if norm(sub(axis, before)) > SAME_PLACE:
                n = add_shifted(P, (times(R, turn), p), elbow, sought, desk, n)
            before = axis
    return n


@kernel
def starts_of_turns(P, pose, given, sought, desk, n):
    """Write starts as `starts_of_roll` at turns, behind n others; return the number of all."""
    freedom, turns, few = given
    first = n
    desk.table[INSIDE] = min(desk.table[INSIDE], sought.known.cost)
    desk.table[REACHED] = 0.0
    n = add_turns(P, pose, (freedom, turns, (0, few)), sought, desk, n)
    if sought.seeded and desk.table[REACHED] < FEW:
        n = add_turns(P, pose, (freedom, turns, (few, turns.shape[0])), sought, desk, n)
    for i in range(first, n):
        desk.starts[i, START_LEANS] = 1.0
    return n


@kernel
def are_close(a, b, width):
    """Whether two starts are this close to each other in every joint, rad."""
    return as_bits(abs(gather(a, 0, 1) - gather(b, 0, 1)) < width) & 0b1111111 == 0b1111111


@kernel
def figures(starts, i):
    """All figures of a start, as two times eight of which some are in both."""
    here = row(starts, i)
    return gather(here, 0, 1), gather(here, START - LANES, 1)


@kernel
def put(starts, i, start):
    """Write the figures of a start."""
    here = row(starts, i)
    scatter(here, 0, 1, start[0])
    scatter(here, START - LANES, 1, start[1])


@kernel
def change_places(starts, i, k):
    """Let two starts change places."""
    one = figures(starts, i)
    put(starts, i, figures(starts, k))
    put(starts, k, one)


@kernel
def sink(starts, i, n, cost):
    """Move a start of n down, until none below it costs less, by that column."""
    start, own = figures(starts, i), starts[i, cost]
    while 2 * i + 1 < n:
        k = 2 * i + 1
        if k + 1 < n and starts[k + 1, cost] < starts[k, cost]:
            k += 1
        if own <= starts[k, cost]:
            break
        put(starts, i, figures(starts, k))
        i = k
    put(starts, i, start)


@kernel
def line_up(starts, n, cost):
    """Make a heap of n starts, by their costs in that column."""
    for i in range(n // 2 - 1, -1, -1):
        sink(starts, i, n, cost)


@kernel
def take_next(starts, n, taken, cost, width):
    """The start of least cost that is so far from those that were taken: it, its cost, how many are left.

    Those that were taken are kept in the last rows; this one too. The cost is `NONE_LEFT` where there is none.
    """
    while n > 0:
        n -= 1
        change_places(starts, 0, n)
        sink(starts, 0, n, cost)
        here = row(starts, n)
        k = 0
        while k < taken and not are_close(here, row(starts, MOST_STARTS - 1 - k), width):
            k += 1
        if k == taken:
            put(starts, MOST_STARTS - 1 - k, figures(starts, n))
            return read7(here), here[cost], n
    return NO_SEED, NONE_LEFT, 0
