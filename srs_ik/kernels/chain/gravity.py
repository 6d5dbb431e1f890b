"""The torques that hold an arm against its weight, from the masses of its links at the zero configuration.

The figures of an arm, W: 7 masses (kg), 7 first moments mass x centre (kg m) with the arm at zero, in the base frame,
gravity there (m/s^2), and 7 factors that bring the torques of the joints to one scale.
"""

import math

from srs_ik.kernels.algebra.vectors import add, along, cross, dot, load3, rotate
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import AXES, POINTS
from srs_ik.kernels.layout.weights import GRAVITY, MASSES, MOMENTS


@kernel
def hold(P, W, q, work, turned, weight):
    """Write the torques that hold the arm's weight into a row of work, which has 7 columns.

    On the way out gravity is turned into the frame in front of each joint: five rows of work, from `turned` on, take
    it, and cosine and sine of the joint. On the way back the masses that a joint carries are moved as one: at each
    joint, weight and lever meet.
    """
    g = load3(W, GRAVITY)
    for joint in range(7):
        c = math.cos(q[joint])
        s = math.sin(q[joint])
        for i in range(3):
            work[turned + i, joint] = g[i]
        work[turned + 3, joint] = c
        work[turned + 4, joint] = s
        g = rotate(load3(P, AXES + 3 * joint), c, -s, g)
    mass = 0.0
    moment = (0.0, 0.0, 0.0)
    for k in range(7):
        joint = 6 - k
        axis = load3(P, AXES + 3 * joint)
        point = load3(P, POINTS + 3 * joint)
        mass += W[MASSES + joint]
        moment = add(moment, load3(W, MOMENTS + 3 * joint))
        lever = rotate(axis, work[turned + 3, joint], work[turned + 4, joint], along(moment, -mass, point))
        g = (work[turned, joint], work[turned + 1, joint], work[turned + 2, joint])
        work[weight, joint] = -dot(axis, cross(lever, g))
        moment = along(lever, mass, point)
