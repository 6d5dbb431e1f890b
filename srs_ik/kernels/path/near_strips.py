"""The strips of a near limb: its curves of postures, followed on the true chain, whatever their branches."""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import along7, dot7
from srs_ik.kernels.chain.newton import pose_step
from srs_ik.kernels.curves.follow import FIRST_GUESS, between, correct, load_sample, null_vector
from srs_ik.kernels.curves.runs import near_runs
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.search import MAX_RUNS, RUN
from srs_ik.kernels.limb.branches import branch_of
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.path.followed import away, turn_all, turned_away
from srs_ik.kernels.path.strips import put_node, widest_step

MOST_PARTS = 16
"""A step of a followed curve is cut into so many at most."""


@kernel
def direction(P, q, R, p, J, A):
    """Unit vector along the curve of postures at q, and whether there is one."""
    pose_step(P, q, R, p, J)
    v, sign = null_vector(J, FIRST_GUESS, A)
    return v, sign != 0.0


@kernel
def moved_along(P, q, v, x, R, p, J, A):
    """The posture that is met a way x from q along the direction v of its curve, and whether it is met."""
    start = along7(q, x, v)
    return correct(P, start, v, dot7(v, start), R, p, J, A)


@kernel
def put_near(P, q, near, radius, nodes, linked, n, follows):
    """Append a posture, linked to the one before if that is wanted; the next free row."""
    if n >= nodes.shape[0] or (radius > 0.0 and turned_away(q, near) > radius):
        return n
    if follows:
        linked[n - 1] = True
    put_node(nodes, n, q, 0.0, branch_of(P, q))
    linked[n] = False
    return n + 1


@kernel
def take_runs(P, place_, R, p, near, radius, nodes, linked, n, J, A):
    """Write the postures of all curves from row n on; the next free row."""
    runs = np.empty((MAX_RUNS, RUN))
    rows, _, count, _ = near_runs(P, place_, R, p, True, runs, J, A)
    for k in range(count):
        q = NO_SEED
        follows = False
        for i in range(int(runs[k, 3]), int(runs[k, 4])):
            begun = i > int(runs[k, 3])
            wanted = turn_all(P, load_sample(rows[i]), q, begun)
            if begun:
                apart = away(wanted, q)
                parts = min(math.ceil(apart / widest_step(q, wanted, near, radius)), MOST_PARTS)
                for part in range(1, parts):
                    inner, met = between(P, R, p, q, wanted, part / parts, J, A)
                    if met:
                        before = n
                        n = put_near(P, turn_all(P, inner, q, True), near, radius, nodes, linked, n, follows)
                        follows = n > before
            before = n
            n = put_near(P, wanted, near, radius, nodes, linked, n, follows)
            follows = n > before
            q = wanted
    return n
