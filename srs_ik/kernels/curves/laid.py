"""Curves of a pose with an almost straight or folded elbow, laid out where its turns tell that there is room.

Where shoulder and wrist are away from singular, the curves of the true chain pass all turns with room (`outreach`) to
both sides of the best bend, and go from one side to the other at the turns at which room ends. So samples are told by
what is known at some turns, and brought to the true chain eight at a time: nothing has to be followed.
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import along7, difference, dot7, short_way
from srs_ik.kernels.algebra.pointers import copy, keep, row
from srs_ik.kernels.chain.eight import put_eight, take_ways
from srs_ik.kernels.curves import outreach
from srs_ik.kernels.curves.follow import reverse
from srs_ik.kernels.curves.in_step import SAMPLE, SAMPLE_WAY, load_sample, put_sample, to_curves, way_of_sample
from srs_ik.kernels.jit import kernel

BESIDE = 0.05
"""Of turns closer to an end of the room than this, rad, the end tells as much."""

FIRST_BENDS = (0.25, 0.52, 0.85, 1.3, 2.0)
MORE = 1.6
"""From where a curve turns around, the first bends of samples, in parts of its radius there: from one to the next it
turns by 14 degrees or less. Each other bend is wider than the one before by the last factor."""

LONGEST = 0.45
"""Length of a way between two samples that are laid out, rad."""

MOST_STATIONS = 160
CORRECTIONS = 8
"""Turns at which samples of a curve are laid out, and Newton's steps to the curve, at most."""

HARDLY = 1e-12
"""A step to a curve that is foreseen to be this short, rad, is not taken: there are no singularities nearby."""

ALONG = 0.95
LEAST_TURNED = 0.9
"""Cosines of the largest angles between a curve and the way to its next sample, and between it at both."""


@kernel
def put_node(nodes, n, reach, at_end):
    """Append what is known at a turn to a stretch with room, unless it is next to its end; the number of rows.

    A turn before an end that is next to it is left out for it.
    """
    if n > 0 and abs(short_way(reach[2] - nodes[n - 1, 2])) < BESIDE:
        if not at_end or n == 1:
            return n
        n -= 1
    copy(reach, row(nodes, n), outreach.REACH)
    return n + 1


@kernel
def spread(nodes, k, length, stations, first, n):
    """Append the turns, from one end of the room on, at which a curve is sampled that turns around there; their number.

    From row k of nodes on, as distances; not beyond the middle, nor where samples are as far apart as they may be.
    """
    turning2 = outreach.length2_of(nodes[k], outreach.REACH_TURNING)
    size = 0.25 * abs(nodes[k, outreach.REACH_RISE]) * outreach.across2_of(nodes[k]) / turning2
    before, bend = 0.0, 0.0
    stations[first + n] = 0.0
    n += 1
    for i in range(MOST_STATIONS // 4):
        bend = FIRST_BENDS[i] if i < 5 else MORE * bend
        at = size * bend * bend
        if at > 0.5 * length or (at - before) ** 2 * turning2 > LONGEST**2:
            break
        stations[first + n] = at
        before = at
        n += 1
    return n


@kernel
def put_stations(nodes, n, is_whole, ways, stations):
    """Write the turns, as distances from the first node, at which a curve is sampled; their number.

    `ways` holds the distances of the nodes.
    """
    length = ways[n - 1]
    longest = LONGEST / math.sqrt(outreach.length2_of(nodes[0], outreach.REACH_TURNING))
    m, back = 1, 1
    stations[0], stations[MOST_STATIONS] = 0.0, 0.0
    if not is_whole:
        m = spread(nodes, 0, length, stations, 0, 0)
        back = spread(nodes, n - 1, length, stations, MOST_STATIONS, 0)
    start, rest = stations[m - 1], length - stations[m - 1] - stations[MOST_STATIONS + back - 1]
    parts = max(math.ceil(rest / longest), 1)
    if m + parts + back > MOST_STATIONS:
        return -1
    for i in range(1, parts):
        stations[m] = start + rest * i / parts
        m += 1
    for i in range(back - 1, -1, -1):
        stations[m] = length - stations[MOST_STATIONS + i]
        m += 1
    return m


@kernel
def lay_stretch(nodes, n, is_whole, work, out):
    """Lay out the one curve of a stretch of turns with room, or the two of a whole circle: rows and curves in use.

    -1 for the rows where a curve is not told. Samples are not yet on the true chain. `work` is for ways and stations.
    """
    ways, stations = work
    rows, curves, start, count = out
    ways[0] = 0.0
    for i in range(1, n):
        ways[i] = ways[i - 1] + abs(short_way(nodes[i, 2] - nodes[i - 1, 2]))
    m = put_stations(nodes, n, is_whole, ways, stations)
    last = start + 2 * m - (0 if is_whole else 1)
    if m < 3 or last > rows.shape[0] or count + 2 > curves.shape[0]:
        return -1, count
    i = 0
    for k in range(m):
        while i < n - 2 and stations[k] > ways[i + 1]:
            i += 1
        a, b, share = nodes[i], nodes[i + 1], (stations[k] - ways[i]) / (ways[i + 1] - ways[i])
        (q, bending), room = outreach.best_at(a, b, share), outreach.room_at(a, b, share)
        at_end = not is_whole and k in (0, m - 1)
        if not (room > 0.0 or at_end):
            return -1, count
        bend = 0.0 if at_end else math.sqrt(room)
        put_sample(rows, start + k, 0.0, along7(q, bend, bending))
        # Back on the other side: of a stretch, from its last turn on.
        back = start + m + k if is_whole else last - 1 - k
        put_sample(rows, back, 0.0, along7(q, -bend, bending))
    if is_whole:
        curves[count, 0], curves[count, 1], curves[count, 2] = start, start + m, 1.0
        start += m
        count += 1
    curves[count, 0], curves[count, 1], curves[count, 2] = start, last, 1.0
    return last, count + 1


@kernel
def put_stretch(reaches, ends, n_ends, gaps, i, nodes):
    """Put together what is known on the stretch from an end of the room, behind which there is some, to the next one.

    Returns the number of rows.
    """
    signs = int(gaps[i]) // outreach.TURNS
    # The next one of the same signs, all around.
    j = i + 1 if i + 1 < n_ends else 0
    while int(gaps[j]) // outreach.TURNS != signs:
        j = j + 1 if j + 1 < n_ends else 0
    n = put_node(nodes, 0, ends[i], True)
    at = int(gaps[i])
    while at != int(gaps[j]):
        at = outreach.next_turn(at)
        n = put_node(nodes, n, reaches[at], False)
    return put_node(nodes, n, ends[j], True)


@kernel
def lay_predicted(which, reaches, ends, n_ends, gaps, out):
    """Lay out all curves of a pose, not yet on the true chain: rows and curves in use, -1 for the rows if not told."""
    nodes = np.empty((outreach.TURNS + 2, outreach.REACH))
    work = np.empty(outreach.TURNS + 2), np.empty(2 * MOST_STATIONS)
    rows, curves = out
    n, count = 0, 0
    ended = 0
    for i in range(n_ends):
        ended |= 1 << (int(gaps[i]) // outreach.TURNS)
        if n >= 0 and reaches[int(gaps[i]), outreach.REACH_ROOM] <= 0.0:
            used = put_stretch(reaches, ends, n_ends, gaps, i, nodes)
            n, count = lay_stretch(nodes, used, False, work, (rows, curves, n, count))
    for signs in range(4):
        first = outreach.TURNS * signs
        if n >= 0 and ((which & ~ended) >> signs) & 1 == 1 and reaches[first, outreach.REACH_ROOM] > 0.0:
            for k in range(outreach.TURNS + 1):
                outreach.copy_reach(reaches, first + k % outreach.TURNS, nodes, k)
            n, count = lay_stretch(nodes, outreach.TURNS + 1, True, work, (rows, curves, n, count))
    return n, count


@kernel
def is_curve(rows, first, last):
    """Tell the parameters of the samples of a closed curve, and turn it around if it is against its way.

    Returns whether each sample is next to the one before along the curve.
    """
    sense = 0.0
    rows[first, 0] = 0.0
    for i in range(first + 1, last):
        a, b = way_of_sample(rows[i - 1]), way_of_sample(rows[i])
        chord = difference(load_sample(rows[i - 1]), load_sample(rows[i]))
        length = math.sqrt(dot7(chord, chord))
        ahead, behind = dot7(chord, a), dot7(chord, b)
        sense = math.copysign(1.0, ahead) if i == first + 1 else sense
        if not (min(sense * ahead, sense * behind) > ALONG * length and dot7(a, b) > LEAST_TURNED):
            return False
        rows[i, 0] = rows[i - 1, 0] + length
    if sense < 0.0:
        reverse(rows, first, last)
    return True


@kernel
def lay_curves(P, by, which, reaches, rows, curves):
    """Lay out the curves of a pose whose elbow is almost straight; their number, -1 where they have to be followed.

    With all signs of shoulder and wrist that are named by bits, with which these are away from singular at all turns.
    `reaches` is what is known there (`put_reaches`).
    """
    ends, gaps = np.empty((outreach.MOST_ENDS, outreach.REACH)), np.empty(outreach.MOST_ENDS)
    n_ends = outreach.find_ends(P, by, which, reaches, ends, gaps)
    if n_ends < 0:
        return -1
    n, count = lay_predicted(which, reaches, ends, n_ends, gaps, (rows, curves))
    if n <= 0:
        return n
    for i in range(0, n, 8):
        eight = row(rows, i)
        which = (1 << min(n - i, 8)) - 1
        q, t, met = to_curves(P, by.target.R, by.target.p, take_ways(eight, 1, SAMPLE), which, (CORRECTIONS, HARDLY))
        if which & ~met != 0:
            return -1
        put_eight(row(eight, 1), SAMPLE, which, q)
        put_eight(row(eight, SAMPLE_WAY), SAMPLE, which, t)
    for k in range(count):
        first, last = int(curves[k, 0]), int(curves[k, 1])
        copy(row(rows, first), row(rows, last - 1), SAMPLE)
        if not is_curve(rows, first, last):
            return -1
    keep(ends)
    return count
