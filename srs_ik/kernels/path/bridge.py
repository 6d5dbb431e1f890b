"""Postures of a pose that its strips miss: from those of the pose before, by Newton's method inside the limits.

Where joints lie on several limits at once, or an elbow is straight, a pose may have a single posture, or an interval
that rounding takes away. Whoever comes from a posture next to it finds it.
"""

from __future__ import annotations

from srs_ik.kernels.chain.newton import CLOSED, STEPS, close_free
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.limb.poses import read7

PATIENCE = 6
"""Times the usual number of steps: to single postures, steps get slow."""


@kernel
def bridge_to(P, R, p, q, J, A):
    """Write the posture inside the limits that is found from q in place of it; whether it meets the pose."""
    found, error = close_free(P, read7(q), R, p, True, PATIENCE * STEPS, J, A)
    for j in range(7):
        q[j] = found[j]
    return error < CLOSED
