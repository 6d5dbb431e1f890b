"""The torques that hold the weight of an arm, joint by joint."""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.vectors import add, along, cross, dot, load3, rotate
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.control import TURNED, WEIGHT
from srs_ik.kernels.layout.limb import AXES, POINTS
from srs_ik.kernels.layout.weights import GRAVITY, MASSES, MOMENTS


@kernel
def hold(P, W, q, work):
    """Write the torques that hold the arm's weight into the row WEIGHT of the work of a tick.

    On the way out gravity is turned into the frame in front of each joint, on the way back the masses that a joint
    carries are moved as one (see `optimum.gravity`).
    """
    g = load3(W, GRAVITY)
    for joint in range(7):
        c = math.cos(q[joint])
        s = math.sin(q[joint])
        for i in range(3):
            work[TURNED + i, joint] = g[i]
        work[TURNED + 3, joint] = c
        work[TURNED + 4, joint] = s
        g = rotate(load3(P, AXES + 3 * joint), c, -s, g)
    mass = 0.0
    moment = (0.0, 0.0, 0.0)
    for k in range(7):
        joint = 6 - k
        axis = load3(P, AXES + 3 * joint)
        point = load3(P, POINTS + 3 * joint)
        mass += W[MASSES + joint]
        moment = add(moment, load3(W, MOMENTS + 3 * joint))
        lever = rotate(axis, work[TURNED + 3, joint], work[TURNED + 4, joint], along(moment, -mass, point))
        g = (work[TURNED, joint], work[TURNED + 1, joint], work[TURNED + 2, joint])
        work[WEIGHT, joint] = -dot(axis, cross(lever, g))
        moment = along(lever, mass, point)
