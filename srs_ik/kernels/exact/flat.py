"""Elbows as good as flat: all the bends that a pose cannot tell from each other.

A bend x changes the length of the arm by x^2 / 8 of it, so rounding hides bends up to 1e-8 or so. But it turns the
upper arm by x / 2, and an outer joint next to its singularity turns far with that. So a feasible posture of a pose with
a flat elbow may be one at another bend.
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.exact.bends import bent_place
from srs_ik.kernels.exact.intervals import find_intervals, join_touching, write_interval
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import MAX_PIECES
from srs_ik.kernels.layout.limb import FREE, LIMITED, LOOSE

NEARLY_FLAT = 3e-6
"""Bends of the elbow below this, rad from straight or from folded, cannot be told apart within 1e-11 of reach."""

SMALLEST_BEND = 2.5e-10
"""The smallest bend that is tried, but for none."""

STAGES = 15
"""What is tried one after the other: a pose as it is, strictly (0) and loosely (1), a flat elbow (2), and bends, each
twice the one before, up to about `NEARLY_FLAT`."""


@kernel
def is_as_good_as_flat(place_):
    """Whether a pose leaves the bend of the elbow open."""
    return place_[3] < NEARLY_FLAT


@kernel
def level(place_):
    """A place with a flat elbow."""
    t, h0, c, _, hand, miss = place_
    return t, h0, math.copysign(1.0, c), 0.0, hand, miss


@kernel
def loosely(place_, stage):
    """The place of a stage from 1 on."""
    if stage == 1:
        return place_
    return level(place_) if stage == 2 else bent_place(place_, SMALLEST_BEND * 2.0**stage)


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
def intervals_of_bends(family, place_, respect, out, n):
    """Join to the first n intervals in rows of out those that a pose has at the other stages; their number."""
    found, both = np.empty((8 * MAX_PIECES, 3)), np.empty((16 * MAX_PIECES, 3))
    P = row(family, LOOSE + (LIMITED if respect else FREE))
    for stage in range(1, STAGES):
        m = find_intervals(P, loosely(place_, stage), -1, found)
        n = min(joined(out, n, found, m, both), out.shape[0])
        for i in range(n):
            for c in range(3):
                out[i, c] = both[i, c]
    return n
