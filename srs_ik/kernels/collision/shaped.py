"""Free arm angles on real shapes: what spheres forbid is looked at again, and only what shapes do not free is kept.

Each pair of bodies is looked at in the arcs that its own spheres forbid. Bodies that the arm angle turns as one, and
those that it does not move, are looked at once for all branches of an elbow; bodies that spin beside, for each branch.

Source: F. Schwarzer, M. Saha, J.-C. Latombe, Adaptive Dynamic Collision Checking for Single and Multiple Articulated
Robots in Complex Environments, T-RO 21(3), 2005, with a bound for one arm angle.
"""

from __future__ import annotations

from typing import NamedTuple

from srs_ik.kernels.collision.arcs import PI, add_complement, add_piece, angles_of, cut_one, shared
from srs_ik.kernels.collision.forbidden import forbid_pair
from srs_ik.kernels.collision.looks import (
    ABOUT_LINE,
    ALONG_CHAIN,
    AT_SPIN,
    Question,
    Spins,
    look,
    only_spins,
    spin_axis,
    way_about_line,
    way_of_spin,
)
from srs_ik.kernels.collision.seen import frames_of_elbow, still_frames
from srs_ik.kernels.collision.shapes import UNKNOWN, forget, is_whole
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import shapes as at

FINEST = 5e-4
"""Between what is free and what is not, so much is left undecided, rad."""

SPACING = 0.04
"""Between postures that hit something free ones are not looked for within this, rad."""

MOST_LOOKS = 400
"""So many arm angles of one part are looked at; what is left is undecided."""

BESIDE = 1e-9
"""What is forbidden is forbidden so far beside it, rad: no end of it counts as free."""

UNLOOKED = -1
"""Of spins that have not been looked at."""


class Room(NamedTuple):
    """Work space of a search."""

    arcs: object  # (8, MOST_ARCS, 2) sets of arm angles
    waiting: object  # (MOST_WAITING, 4) parts of an arc that wait to be looked at
    spins: object  # (K, MOST_SPINS, 2) for each pair of bodies, spins of the first at which they meet
    spin_counts: object  # (K,) integers, how many pieces these are; negative where that is not known
    rest: object  # (R, REST) output: what is left of pairs that are more than their solids


@kernel
def block(blocked, n, lower, upper):
    """Add a piece to a set, and a little beside it."""
    return add_piece(blocked, n, max(lower - BESIDE, -PI), min(upper + BESIDE, PI))


@kernel
def certify(question, lower, upper, blocked, n, waiting):
    """Add what is not shown to be free of a piece to a set: number of pieces, and the width left undecided, rad."""
    undecided = 0.0
    waiting[0, 0], waiting[0, 1], waiting[0, 2], waiting[0, 3] = lower, upper, 0.0, 0.0
    count, looks = 1, 0
    while count > 0:
        count -= 1
        a, b, before, behind = waiting[count, 0], waiting[count, 1], waiting[count, 2], waiting[count, 3]
        if (looks > 0 and b - a < FINEST) or looks >= MOST_LOOKS or count + 2 >= at.MOST_WAITING:
            n = block(blocked, n, a, b)
            undecided += b - a
            continue
        if before > 0.0 and behind > 0.0 and b - a < SPACING:
            n = block(blocked, n, a, b)
            continue
        middle, half, looks = 0.5 * (a + b), max(0.5 * (b - a), BESIDE), looks + 1
        reach = look(question, middle, half)
        hit = 0.0
        if reach <= 0.0:
            hit, reach = 1.0, -reach
            n = block(blocked, n, max(a, middle - reach), min(b, middle + reach))
        if reach >= half:
            continue
        if middle + reach < b:
            waiting[count, 0], waiting[count, 1], waiting[count, 2], waiting[count, 3] = middle + reach, b, hit, behind
            count += 1
        if a < middle - reach:
            waiting[count, 0], waiting[count, 1], waiting[count, 2], waiting[count, 3] = a, middle - reach, before, hit
            count += 1
    return closed_up(blocked, n), undecided


@kernel
def closed_up(pieces, n):
    """Join pieces with less than `FINEST` between them, which only adds to the set; return how many are left."""
    count = 0
    for i in range(n):
        if count > 0 and pieces[i, 0] - pieces[count - 1, 1] < FINEST:
            pieces[count - 1, 1] = pieces[i, 1]
        else:
            pieces[count, 0], pieces[count, 1] = pieces[i, 0], pieces[i, 1]
            count += 1
    return count


@kernel
def put_rest(rest, count, pair, branch, piece):
    """Append a row for whoever knows the shapes themselves; return how many there are, those without room too."""
    if count < rest.shape[0]:
        rest[count, at.REST_PAIR], rest[count, at.REST_BRANCH] = pair, branch
        rest[count, at.REST_LOWER], rest[count, at.REST_UPPER] = piece
    return count + 1


@kernel
def look_through(question, k, gaps, blocked, room, totals):
    """Look at the gaps that a pair's spheres leave open: number of blocked pieces, undecided width, rows of the rest.

    `gaps` and `blocked` are sets with their number of pieces; totals are the last two, so far.
    """
    undecided, rest = totals
    shapes = question.shapes
    whole = is_whole(shapes, question.pair[0], question.pair[1])
    pieces, n = blocked
    forget(shapes)
    for i in range(gaps[1]):
        a, b = gaps[0][i, 0], gaps[0][i, 1]
        if whole:
            n, width = certify(question, a, b, pieces, n, room.waiting)
            undecided += width
        else:
            own = room.arcs[6]
            m, _ = certify(question, a, b, own, 0, room.waiting)
            for j in range(m):
                rest = put_rest(room.rest, rest, k, question.branch, (own[j, 0], own[j, 1]))
    return n, undecided, rest


@kernel
def no_spins(room):
    """Stands for spins where these do not matter."""
    return Spins(room.arcs[0], 0, 1.0, 0)


@kernel
def spins_that_hit(asked, pair, k, room):
    """The spins of the first of two bodies at which it meets the other one; found once for an elbow."""
    P, target, _, frames, shapes, space, margin = asked
    joint, sign = spin_axis(shapes.of_body[pair[0], at.JOINT])
    if room.spin_counts[k] < 0:
        forget(shapes)
        way = way_of_spin(P, shapes, pair, frames)
        question = Question(P, target, shapes, frames, space, pair, -1, margin[0], ABOUT_LINE, way, no_spins(room))
        room.spin_counts[k], _ = certify(question, -PI, PI, room.spins[k], 0, room.waiting)
    return Spins(room.spins[k], room.spin_counts[k], sign, joint)


@kernel
def of_elbow(elbow, asked, wanted, blocked, room, totals):
    """Of the arm angles wanted, add those that bodies forbid which turn as one or stand still: as `look_through`."""
    P, target, world, frames, shapes, space, margin = asked
    n = 0
    for k in range(shapes.pairs.shape[0]):
        pair = (shapes.pairs[k, at.ONE], shapes.pairs[k, at.OTHER])
        row = shapes.pairs[k, at.WATCHED]
        if row == at.RANGED or shapes.of_body[pair[0], at.SPINS] or shapes.of_body[pair[1], at.SPINS]:
            continue
        arcs, gaps = room.arcs[2], room.arcs[4]
        count = forbid_pair(world, row, elbow, frames, margin[1], arcs, 0, room.arcs[3])
        if count == 0:
            continue
        m = shared((arcs, count), wanted, (blocked, n), gaps)
        way = way_about_line(shapes, pair, frames)
        question = Question(
            P, target, shapes, frames, space, pair, -1 - elbow, margin[0], ABOUT_LINE, way, no_spins(room)
        )
        n, undecided, rest = look_through(question, k, (gaps, m), (blocked, n), room, totals)
        totals = (undecided, rest)
    return n, totals[0], totals[1]


@kernel
def of_branch(branch, asked, wanted, ranged, blocked, room, totals):
    """The same of bodies that spin, of one branch; `ranged` are the arm angles outside of the ranges of joints."""
    P, target, world, frames, shapes, space, margin = asked
    pieces, n = blocked
    for k in range(shapes.pairs.shape[0]):
        pair = (shapes.pairs[k, at.ONE], shapes.pairs[k, at.OTHER])
        row = shapes.pairs[k, at.WATCHED]
        arcs, gaps = room.arcs[2], room.arcs[4]
        if row == at.RANGED:
            m = shared(ranged, wanted, (pieces, n), gaps)
        elif shapes.of_body[pair[0], at.SPINS] or shapes.of_body[pair[1], at.SPINS]:
            count = forbid_pair(world, row, branch >> 2, frames, margin[1], arcs, 0, room.arcs[3])
            m = shared((arcs, count), wanted, (pieces, n), gaps) if count > 0 else 0
        else:
            m = 0
        if m > 0:
            way, spins, mode = way_about_line(shapes, pair, frames), no_spins(room), ALONG_CHAIN
            if only_spins(shapes, pair[0], pair[1]) and is_whole(shapes, pair[0], pair[1]):
                spins, mode = spins_that_hit(asked, pair, k, room), AT_SPIN
            question = Question(P, target, shapes, frames, space, pair, branch, margin[0], mode, way, spins)
            n, undecided, rest = look_through(question, k, (gaps, m), (pieces, n), room, totals)
            totals = (undecided, rest)
    return n, totals[0], totals[1]


@kernel
def branches_of(found, elbow):
    """How many branches of an elbow have intervals; these are sorted."""
    count, last = 0, -1
    for i in range(found.shape[0]):
        branch = int(found[i, 0])
        if branch >> 2 == elbow and branch != last:
            count, last = count + 1, branch
    return count


@kernel
def free_by_shapes(P, target, world, shapes, found, ranges, margins, space, room, out):
    """Write what the solids of all pairs leave of intervals (n, 3) of a pose of an exact limb into rows of out.

    Intervals are sorted by branch. In `ranges` (m, 3), ranges of joints keep bodies apart; `margins` are what is to be
    left between shapes and between spheres, m; `space` and `room` are work space. Returns how many rows of out are
    written, the width left undecided, and how many rows of the rest there are.
    """
    still = still_frames(P, target)
    totals = (0.0, 0)
    count = 0
    for elbow in range(2):
        frames = frames_of_elbow(P, target, world, still, elbow)
        for i in range(shapes.from_line.shape[0]):
            shapes.from_line[i] = UNKNOWN
        for k in range(shapes.pairs.shape[0]):
            room.spin_counts[k] = UNLOOKED
        wanted, blocked = room.arcs[0], room.arcs[1]
        m = angles_of(found, found.shape[0], 0b1111 << 4 * elbow, wanted)
        if m == 0:
            continue
        asked = (P, target, world, frames, shapes, space, margins)
        n, undecided, rest = of_elbow(elbow, asked, (wanted, m), blocked, room, (0.0, totals[1]))
        totals = (totals[0] + undecided * branches_of(found, elbow), rest)
        for branch in range(4 * elbow, 4 * elbow + 4):
            m = angles_of(found, found.shape[0], 1 << branch, wanted)
            if m == 0:
                continue
            own = room.arcs[5]
            for i in range(n):
                own[i, 0], own[i, 1] = blocked[i, 0], blocked[i, 1]
            outside = room.arcs[7]
            inside = angles_of(ranges, ranges.shape[0], 1 << branch, room.arcs[3])
            outer = add_complement(outside, 0, room.arcs[3], inside)
            taken, undecided, rest = of_branch(branch, asked, (wanted, m), (outside, outer), (own, n), room, totals)
            totals = (undecided, rest)
            first = count
            for i in range(found.shape[0]):
                if int(found[i, 0]) == branch:
                    count = cut_one(branch, found[i, 1], found[i, 2], own, taken, out, first, count)
    return count, totals[0], totals[1]
