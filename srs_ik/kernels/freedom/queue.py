"""Starts of searches, the least costly first; what lies next to one that was taken is left out.

The first rows of an array are a heap, whose least start comes first. One that is taken changes places with the last of
them, so that none is lost and another search can go through all of them again.
"""

from __future__ import annotations

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.freedom import MOST_STARTS, START
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.limb.poses import read7

APART = 0.4
"""Starts this close to each other, rad in every joint, lead to the same posture."""

MOST_ATTEMPTS = 60
"""Searches at most, where none has found a posture yet."""

NONE_LEFT = 1e300
"""Cost where no start is left."""


@kernel
def are_close(a, b, width):
    """Whether two starts are this close to each other in every joint, rad."""
    j = 0
    while j < 7 and abs(a[j] - b[j]) < width:
        j += 1
    return j == 7


@kernel
def change_places(starts, i, k):
    """Let two starts change places."""
    for j in range(START):
        starts[i, j], starts[k, j] = starts[k, j], starts[i, j]


@kernel
def sink(starts, i, n, cost):
    """Move a start of n down, until none below it costs less, by that column."""
    while 2 * i + 1 < n:
        k = 2 * i + 1
        if k + 1 < n and starts[k + 1, cost] < starts[k, cost]:
            k += 1
        if starts[i, cost] <= starts[k, cost]:
            break
        change_places(starts, i, k)
        i = k


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
            for j in range(START):
                starts[MOST_STARTS - 1 - k, j] = here[j]
            return read7(here), here[cost], n
    return NO_SEED, NONE_LEFT, 0
