"""What bodies leave of the intervals of a pose."""

import math

import numpy as np

from srs_ik.kernels.collision.arcs import add_all, add_arc, cut
from srs_ik.kernels.collision.drift import drifted
from srs_ik.kernels.collision.forbidden import forbid
from srs_ik.kernels.collision.seen import frames_of_elbow, still_frames
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.collision import MARGIN, MOST_ARCS


@kernel
def widened(arcs, n, by, free):
    """Widen every piece of a set by an angle at both ends; return how many pieces there are."""
    if by == 0.0 or n == 0:
        return n
    if by >= math.pi:
        return add_all(arcs)
    for i in range(n):
        free[i, 0], free[i, 1] = arcs[i, 0], arcs[i, 1]
    count = n
    n = 0
    for i in range(count):
        n = add_arc(arcs, n, 0.5 * (free[i, 0] + free[i, 1]), 0.5 * (free[i, 1] - free[i, 0]) + by)
    return n


@kernel
def forbidden_arcs(P, target, world, slack, arcs, counts, free):
    """Write the forbidden arm angles of both elbows into arcs (2, MOST_ARCS, 2), and how many pieces they are."""
    still = still_frames(P, target)
    off, wide = drifted(P, target, slack)
    for elbow in range(2):
        frames = frames_of_elbow(P, target, world, still, elbow)
        n = forbid(world, elbow, frames, slack[MARGIN] + off, arcs[elbow], free)
        counts[elbow] = widened(arcs[elbow], n, wide, free)


@kernel
def left_of(P, target, found, world, slack, out):
    """Write what bodies leave of intervals (n, 3) of a pose into rows of out; return how many there are then."""
    arcs, counts = np.empty((2, MOST_ARCS, 2)), np.zeros(2, np.int64)
    forbidden_arcs(P, target, world, slack, arcs, counts, np.empty((MOST_ARCS, 2)))
    return cut(found, found.shape[0], arcs, counts, out)
