"""The parts of cells that a path can reach whose joint steps all stay below a limit.

From a part s0 to s1 of one cell, the places s and t between which no joint steps farther are a convex polygon: seven
strips cut out of a rectangle. Its extent in t is what can be reached of the other cell.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.path import CELL_OFF
from srs_ik.kernels.path.cells import cell_chord
from srs_ik.kernels.path.steps import steps_between

MOST_CORNERS = 40


@kernel
def cut_polygon(corners, n, a, b, most, spare):
    """Cut off what lies beyond a s + b t = most from a convex polygon of n corners (s, t); how many are left."""
    m = 0
    for i in range(n):
        k = i + 1 if i + 1 < n else 0
        here = most - (a * corners[i, 0] + b * corners[i, 1])
        there = most - (a * corners[k, 0] + b * corners[k, 1])
        if here >= 0.0:
            spare[m, 0], spare[m, 1] = corners[i, 0], corners[i, 1]
            m += 1
        if (here > 0.0 and there < 0.0) or (here < 0.0 and there > 0.0):
            x = here / (here - there)
            spare[m, 0] = corners[i, 0] + x * (corners[k, 0] - corners[i, 0])
            spare[m, 1] = corners[i, 1] + x * (corners[k, 1] - corners[i, 1])
            m += 1
    for i in range(m):
        corners[i, 0], corners[i, 1] = spare[i, 0], spare[i, 1]
    return m


@kernel
def reach_cell(cells, i, part, j, limit, settings, work):
    """What is reached of cell j from the part (s0, s1) of cell i: begin and end, the end below the begin if nothing is.

    `work` (2, MOST_CORNERS, 2) is work space.
    """
    e = steps_between(settings, row(cells, i), row(cells, j))
    d, chord = cell_chord(cells, i), cell_chord(cells, j)
    most = limit + cells[i, CELL_OFF] + cells[j, CELL_OFF]
    for k in range(7):
        if abs(e[k]) > most + abs(d[k]) + abs(chord[k]):
            return 1.0, 0.0
    corners, spare = work[0], work[1]
    for k in range(4):
        corners[k, 0] = part[0] if k in (0, 3) else part[1]
        corners[k, 1] = 0.0 if k < 2 else 1.0
    n = 4
    for k in range(7):
        if abs(e[k]) + abs(d[k]) + abs(chord[k]) <= most:
            continue
        n = cut_polygon(corners, n, -d[k], chord[k], most - e[k], spare)
        n = cut_polygon(corners, n, d[k], -chord[k], most + e[k], spare)
        if n == 0:
            return 1.0, 0.0
    first, last = math.inf, -math.inf
    for k in range(n):
        first, last = min(first, corners[k, 1]), max(last, corners[k, 1])
    return first, last
