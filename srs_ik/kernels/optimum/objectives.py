"""What a posture is judged by: figures of its Jacobian and of its joint angles, all to be minimised.

Jp are the linear rows of the Jacobian J of the tip point in base axes. The vectors of a task lie in `params`: the
unit force direction in places 0 to 2 and the unit velocity direction in 3 to 5, or a unit twist or wrench in 0 to 5,
or a posture in 0 to 6; behind them lie the weights of the arm.
"""

import math

from srs_ik.kernels.algebra.pointers import read7
from srs_ik.kernels.chain.gravity import hold
from srs_ik.kernels.chain.kinematics import tip_lines
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import objectives as at
from srs_ik.kernels.layout.weights import SCALES
from srs_ik.kernels.limb.goal import NO_SEED, cost, turned

TORQUE = 5
"""Row of the work space that takes the torques, behind those of `hold`."""


@kernel
def squared_torque(P, W, q, work):
    """Sum of squared scaled gravity torques; work (6, 7) is work space."""
    hold(P, W, q, work, 0, TORQUE)
    total = 0.0
    for joint in range(7):
        torque = W[SCALES + joint] * work[TORQUE, joint]
        total += torque * torque
    return total


@kernel
def along_direction(J, params, first, rows):
    """The form d'JJ'd for the direction d that starts at place `first` of params, with an entry for each row."""
    total = 0.0
    for joint in range(7):
        rate = 0.0
        for i in range(rows):
            rate += J[i, joint] * params[first + i]
        total += rate * rate
    return total


@kernel
def volume(J):
    """The root sqrt(det JJ') of J (6, 7), which is overwritten.

    It is the product of the rows' lengths, each row made orthogonal to those before. The determinant itself would lose
    half of the digits near a singular posture.
    """
    product = 1.0
    for i in range(6):
        length2 = 0.0
        for j in range(7):
            length2 += J[i, j] * J[i, j]
        product *= math.sqrt(length2)
        if length2 == 0.0:
            return 0.0
        for k in range(i + 1, 6):
            share = 0.0
            for j in range(7):
                share += J[i, j] * J[k, j]
            share /= length2
            for j in range(7):
                J[k, j] -= share * J[i, j]
    return product


@kernel
def toward_reference(P, params, q):
    """The posture with every joint in the turn nearest to the reference, inside its limits where they are respected."""
    return turned(P, q, True, read7(params), params[at.RESPECT] == 1.0)


@kernel
def figure(kind, params, J):
    """Value of an objective for a Jacobian, which may be overwritten."""
    if kind == at.RATIO:
        return along_direction(J, params, 0, 3) / max(along_direction(J, params, 3, 3), at.SMALLEST)
    if kind == at.FORCE:
        return along_direction(J, params, 0, 3)
    if kind == at.VELOCITY:
        return -along_direction(J, params, 3, 3)
    if kind == at.TWIST:
        return -along_direction(J, params, 0, 6)
    if kind == at.WRENCH:
        return along_direction(J, params, 0, 6)
    return -volume(J)


@kernel
def objective(P, kind, params, q, J):
    """Value of an objective at a posture; J is work space."""
    if kind == at.LIMIT_MARGIN:
        return cost(P, q, False, NO_SEED, False)
    if kind == at.REFERENCE:
        return cost(P, toward_reference(P, params, q), True, read7(params), False)
    if kind == at.GRAVITY:
        return squared_torque(P, params[at.WEIGHT :], q, J)
    tip_lines(P, q, J)
    return figure(kind, params, J)
