"""Torques that hold the arm against its weight, from the masses of its links at the zero configuration.

The figures of an arm, W: 7 masses (kg), 7 first moments mass x centre (kg m) with the arm at zero, in the base frame,
gravity there (m/s^2), and 7 factors that bring the torques of the joints to one scale.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.vectors import add, along, cross, dot, load3, rotate
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import AXES, POINTS
from srs_ik.kernels.layout.weights import GRAVITY, MASSES, MOMENTS, SCALES


@kernel
def squared_torque(P, W, q, work):
    """Sum of squared scaled gravity torques; work (6, 7) is work space.

    On the way out gravity is turned into the frame in front of each joint, on the way back the masses that a joint
    carries are moved as one: at each joint, weight and lever meet.
    """
    g = load3(W, GRAVITY)
    for joint in range(7):
        c = math.cos(q[joint])
        s = math.sin(q[joint])
        for i in range(3):
            work[i, joint] = g[i]
        work[3, joint] = c
        work[4, joint] = s
        g = rotate(load3(P, AXES + 3 * joint), c, -s, g)
    total = 0.0
    mass = 0.0
    moment = (0.0, 0.0, 0.0)
    for k in range(7):
        joint = 6 - k
        axis = load3(P, AXES + 3 * joint)
        point = load3(P, POINTS + 3 * joint)
        mass += W[MASSES + joint]
        moment = add(moment, load3(W, MOMENTS + 3 * joint))
        lever = rotate(axis, work[3, joint], work[4, joint], along(moment, -mass, point))
        g = (work[0, joint], work[1, joint], work[2, joint])
        torque = W[SCALES + joint] * dot(axis, cross(lever, g))
        total += torque * torque
        moment = along(lever, mass, point)
    return total
