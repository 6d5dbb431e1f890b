"""Entry points for real shapes: free arm angles of one pose, of an exact limb or along the curves of a near one.

The tables of spheres are those of `entries.collision`, those of shapes are of `layout.shapes`: `solids` (S, SOLID) and
`of_solid` (S, OF_SOLID), `points` (N, 3), `shaped` (B, SHAPED) and `of_body` (B, OF_BODY), `couples` (K, PAIR) and
`outer` (2, OUTER).
"""

from __future__ import annotations

import numpy as np

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.collision.march import march_all
from srs_ik.kernels.collision.seen import World
from srs_ik.kernels.collision.shaped import Room, free_by_shapes
from srs_ik.kernels.collision.shapes import NORMALS, Along, Shapes
from srs_ik.kernels.jit import entry
from srs_ik.kernels.layout.collision import MARGIN, MOST_ARCS
from srs_ik.kernels.layout.limb import LIMITED
from srs_ik.kernels.layout.path import Space, Spot
from srs_ik.kernels.layout.shapes import MOST_SPINS, MOST_WAITING, RANGED, WATCHED
from srs_ik.kernels.limb.poses import read_pose
from srs_ik.kernels.limb.triangle import place

NO_COUPLE = -1
"""No shapes belong to a pair: it is one with a cloud or a half-space."""


@entry
def free_intervals(
    family,
    T,
    found,
    ranges,
    margin,
    bodies,
    groups,
    pairs,
    slack,
    local,
    ready,
    solids,
    of_solid,
    points,
    shaped,
    of_body,
    couples,
    outer,
    J,
    A,
    out,
    rest,
):
    """What the solids of all couples leave of the intervals of one pose in found (n, 3), of an exact limb.

    `ranges` (m, 3) are those in which ranges of joints keep bodies apart; `margin` is what is left between solids, m,
    and `slack` tells what spheres count. Rows are written to out (o, 3), and to rest (R, REST) what is left of couples
    that are more than their solids.

    Returns:
        How many rows of out are written, the width left undecided, rad, and how many rows of rest there are.
    """
    P = row(family, LIMITED)
    R, p, _ = read_pose(row(T, 0))
    frames, normals = np.empty((8, 12)), np.empty((NORMALS, 3))
    shapes = Shapes(
        solids, of_solid, points, shaped, of_body, couples, outer, np.empty(solids.shape[0]), frames, normals
    )
    count = couples.shape[0]
    spins, spin_counts = np.empty((count, MOST_SPINS, 2)), np.empty(count, np.int64)
    room = Room(np.empty((8, MOST_ARCS, 2)), np.empty((MOST_WAITING, 4)), spins, spin_counts, rest)
    world = World(bodies, groups, pairs, local, ready)
    spot = Spot(R, p, place(P, R, p))
    return free_by_shapes(P, spot, world, shapes, found, ranges, (margin, slack[MARGIN]), Space(J, A), room, out)


@entry
def march(
    family,
    T,
    found,
    bodies,
    groups,
    pairs,
    slack,
    local,
    ready,
    solids,
    of_solid,
    points,
    shaped,
    of_body,
    couples,
    outer,
    J,
    A,
    out,
):
    """The same on the true chain of a near limb, along its curves: found (n, 3) is sorted by branch; rows of out."""
    P = row(family, LIMITED)
    R, p, _ = read_pose(row(T, 0))
    frames, normals = np.empty((8, 12)), np.zeros((NORMALS, 3))
    shapes = Shapes(
        solids, of_solid, points, shaped, of_body, couples, outer, np.empty(solids.shape[0]), frames, normals
    )
    couple_of = np.full(pairs.shape[0], NO_COUPLE)
    for k in range(couples.shape[0]):
        if couples[k, WATCHED] != RANGED:
            couple_of[couples[k, WATCHED]] = k
    along = Along(shapes, couple_of, np.empty((8, 12)), np.empty((8, 12)))
    around = (World(bodies, groups, pairs, local, ready), slack, along)
    return march_all(P, Spot(R, p, place(P, R, p)), around, found, Space(J, A), out)
