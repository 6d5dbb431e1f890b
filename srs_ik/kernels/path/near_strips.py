"""The strips of a near limb: its curves of postures, followed on the true chain, whatever their branches.

Coarse strips are all curves of a pose; fine ones are the piece of one curve about a posture.
"""

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import along7, apart, dot7
from srs_ik.kernels.chain.newton import CLOSED, STEPS, close_free
from srs_ik.kernels.curves.follow import between, correct, tangent_at
from srs_ik.kernels.curves.in_step import load_sample, way_of_sample
from srs_ik.kernels.curves.runs import near_runs
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.asked import Setting
from srs_ik.kernels.layout.path import NODE
from srs_ik.kernels.layout.search import MAX_RUNS, RUN
from srs_ik.kernels.limb.branches import branch_of
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.limb.triangle import elbow_side
from srs_ik.kernels.path.followed import turn_all
from srs_ik.kernels.path.strips import SPACING, put_node

MOST_PARTS = 16
"""A step of a followed curve is cut into so many at most."""


@kernel
def setting_of(P, target, J, A):
    """The setting in which the curves of a pose are followed, within the limits."""
    return Setting(target, elbow_side(P, target.place, 0), True, J, A)


@kernel
def direction(P, by, q):
    """Unit vector along the curve of postures at q, and whether there is one."""
    v, sign = tangent_at(P, by, q)
    return v, sign != 0.0


@kernel
def moved_along(P, by, q, v, x):
    """The posture that is met a way x from q along the direction v of its curve, and whether it is met."""
    start = along7(q, x, v)
    return correct(P, by, start, v, dot7(v, start))


@kernel
def put_next(P, q, sheet, n, follows):
    """Append a posture, linked to the one before if that is wanted; the next free row."""
    if n >= sheet.nodes.shape[0]:
        return n
    if follows:
        sheet.linked[n - 1] = True
    put_node(sheet.nodes, n, q, 0.0, branch_of(P, q))
    sheet.linked[n] = False
    return n + 1


@kernel
def take_runs(P, target, sheet, n, J, A):
    """Write the postures of all curves from row n on; the next free row."""
    runs = np.empty((MAX_RUNS, RUN))
    by = setting_of(P, target, J, A)
    rows, _, count, _ = near_runs(P, by, runs)
    for k in range(count):
        q = NO_SEED
        for i in range(int(runs[k, 3]), int(runs[k, 4])):
            begun = i > int(runs[k, 3])
            wanted = turn_all(P, load_sample(rows[i]), q, begun)
            if begun:
                start, end = (q, way_of_sample(rows[i - 1])), (wanted, way_of_sample(rows[i]))
                parts = min(math.ceil(apart(wanted, q) / SPACING), MOST_PARTS)
                for part in range(1, parts):
                    inner, met = between(P, by, start, end, part / parts)
                    if met:
                        n = put_next(P, turn_all(P, inner, q, True), sheet, n, True)
            n = put_next(P, wanted, sheet, n, begun)
            q = wanted
    return n


@kernel
def take_line(P, target, around, sheet, n, J, A):
    """Write the postures of the curve through the one that is nearest to `around`, about it; the next free row."""
    middle, error = close_free(P, around.q, target.R, target.p, True, 2 * STEPS, J, A)
    if not error < CLOSED:
        return n
    first = n
    count = math.ceil(around.radius / around.spacing)
    by = setting_of(P, target, J, A)
    n = walk(P, by, (middle, -around.spacing, count), sheet, n)
    for i in range((n - first) // 2):
        for j in range(NODE):
            here, there = sheet.nodes[first + i, j], sheet.nodes[n - 1 - i, j]
            sheet.nodes[first + i, j] = there
            sheet.nodes[n - 1 - i, j] = here
    put_node(sheet.nodes, n, middle, 0.0, branch_of(P, middle))
    n = walk(P, by, (middle, around.spacing, count), sheet, n + 1)
    for i in range(first, n):
        sheet.linked[i] = i + 1 < n
    return n


@kernel
def walk(P, by, begin, sheet, n):
    """Follow a curve from a posture on, so far a step, so many steps, and write what is met; the next free row."""
    q, step, count = begin
    v, good = direction(P, by, q)
    for _ in range(count):
        if not good:
            break
        q, good = moved_along(P, by, q, v, step)
        if not good:
            break
        put_node(sheet.nodes, n, q, 0.0, branch_of(P, q))
        n += 1
        v_next, good = direction(P, by, q)
        v = along7(NO_SEED, math.copysign(1.0, dot7(v, v_next)), v_next)
    return n
