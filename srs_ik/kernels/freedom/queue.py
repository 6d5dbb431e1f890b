"""Starts of searches, the least costly first; what lies next to one that was taken is left out.

The first rows of an array are a heap, whose least start comes first. One that is taken changes places with the last of
them, so that none is lost and another search can go through all of them again.
"""

from __future__ import annotations

from srs_ik.kernels.algebra.lanes import LANES, as_bits, gather, scatter
from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.freedom import MOST_STARTS, START, START_LATE
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
        while k < taken and not are_close(
            here, row(starts, MOST_STARTS - 1 - k), width * starts[MOST_STARTS - 1 - k, START_LATE]
        ):
            k += 1
        if k == taken:
            put(starts, MOST_STARTS - 1 - k, figures(starts, n))
            starts[MOST_STARTS - 1 - k, START_LATE] = 1.0
            return read7(here), here[cost], n
    return NO_SEED, NONE_LEFT, 0
