"""Entry point for the free arm angles of near limbs: along their curves, on the true chain."""

from __future__ import annotations

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.collision.march import march_all
from srs_ik.kernels.collision.seen import World
from srs_ik.kernels.jit import entry
from srs_ik.kernels.layout.limb import LIMITED
from srs_ik.kernels.layout.path import Space, Spot
from srs_ik.kernels.limb.poses import read_pose
from srs_ik.kernels.limb.triangle import place


@entry
def march(family, T, found, n, bodies, groups, pairs, slack, local, ready, J, A, out):
    """What bodies leave of the first n intervals of one pose in found (m, 3): number of rows written to out.

    Args:
        family: packed limbs.
        T: (4, 4) pose, a good one.
        found: (m, 3) branch, lower and upper end of each interval, sorted by branch.
        n: how many.
        bodies: (rows, BODY_ROW).
        groups: (G, GROUP) integers.
        pairs: (p, 2) integers.
        slack: (SLACK,) margin and drift.
        local: (rows, LOCAL_ROW) work space.
        ready: (G,) integers, work space.
        J: (6, 7) work space.
        A: (16, 9) work space.
        out: (o, 3) output.
    """
    P = row(family, LIMITED)
    R, p, _ = read_pose(row(T, 0))
    world = World(bodies, groups, pairs, local, ready)
    return march_all(P, Spot(R, p, place(P, R, p)), world, slack, found[:n], Space(J, A), out)
