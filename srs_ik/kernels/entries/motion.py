"""Entry points for joint paths among bodies: whether the straight lines between their postures keep clear."""

from __future__ import annotations

from srs_ik.kernels.algebra.joint_vectors import along7
from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.collision.motion import CLEAR, look_along
from srs_ik.kernels.collision.seen import World
from srs_ik.kernels.jit import entry
from srs_ik.kernels.layout.collision import EDGE_AT, EDGE_CLEARANCE, EDGE_PAIR
from srs_ik.kernels.layout.limb import LIMITED
from srs_ik.kernels.limb.poses import read7


@entry
def edges(family, starts, ends, bodies, groups, pairs, slack, local, ready, out):
    """Look along the straight line from each posture to its end: how many do not keep clear.

    Args:
        family: packed limbs.
        starts: (n, 7) joint angles.
        ends: (n, 7).
        bodies: (rows, BODY_ROW).
        groups: (G, GROUP) integers.
        pairs: (p, 2) integers.
        slack: (n, SLACK) what is to be left on each line, and drift.
        local: (rows, LOCAL_ROW) work space.
        ready: (G,) integers, work space.
        out: (n, EDGE) output: where on the line, 0 to 1, which pair is too close there, and its clearance, m; pair -1
            where the line is certainly clear.
    """
    world = World(bodies, groups, pairs, local, ready)
    P = row(family, LIMITED)
    hits = 0
    for i in range(starts.shape[0]):
        start = read7(row(starts, i))
        step = along7(read7(row(ends, i)), -1.0, start)
        verdict, out[i, EDGE_AT], pair, out[i, EDGE_CLEARANCE] = look_along(P, start, step, world, row(slack, i))
        out[i, EDGE_PAIR] = pair
        hits += verdict != CLEAR
    return hits
