"""The Fractal Impedance Controller: a spring while the error grows, and half a period of a harmonic while it shrinks.

Source: C. Tiseo et al., Bio-mimetic Adaptive Force/Position Control Using Fractal Impedance, arXiv 2003.01466 (law A);
law B is that of its authors' published program.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.vectors import dot
from srs_ik.kernels.control.profile import energy, force
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.control import (
    CONVERGING,
    DAMPING,
    ENERGY,
    ERROR,
    FORCE,
    LARGEST,
    LAST,
    LAW,
    LAW_A,
    LAW_B,
    MOVED,
    PEAK,
    PER_AXIS,
    POWER,
    SWITCH,
)

SMALLEST = 1e-150
"""A peak below this, m or rad, is none; its square would be no number."""


@kernel
def response(port, size, peak, converging):
    """Force towards the target at an error of a size, after a peak; negative where it brakes."""
    if not converging or peak < SMALLEST or port[LAW] > LAW_B:
        return force(port, size)
    if port[LAW] == LAW_A:
        return force(port, peak) * (2.0 * size / peak - 1.0)
    pull = 4.0 * energy(port, peak) / peak * (size / peak - 0.5)
    return max(-port[LARGEST], min(port[LARGEST], pull))


@kernel
def remember(port, state, axis, size, growth):
    """Note the size of an error, and whether it grows: a new peak. Returns whether the axis converges.

    `growth` is the rate of the size for a target at rest (m/s, rad/s). It tells at once what the size itself tells one
    period late; for a target that has moved it says nothing.
    """
    last = state[LAST + axis]
    converging = state[CONVERGING + axis] != 0.0
    if last < 0.0:
        converging = False
    elif port[SWITCH] >= 0.0 and state[MOVED] == 0.0:
        converging = growth < -port[SWITCH]
    elif size != last:
        converging = size < last
    if not converging or size > state[PEAK + axis]:
        state[PEAK + axis] = size
    state[LAST + axis] = size
    state[CONVERGING + axis] = 1.0 if converging else 0.0
    return converging


@kernel
def along_axis(port, state, axis, error, rate):
    """Force along one axis, for an error there and the speed of what is pulled."""
    size = abs(error)
    sign = math.copysign(1.0, error)
    converging = remember(port, state, axis, size, -sign * rate)
    return sign * response(port, size, state[PEAK + axis], converging)


@kernel
def pull(port, state, error, velocity):
    """Force or torque (three figures) for an error vector and the velocity of what is pulled; notes what it did."""
    size = math.hypot(math.hypot(error[0], error[1]), error[2])
    if port[PER_AXIS] == 1.0:
        h = (
            along_axis(port, state, 0, error[0], velocity[0]),
            along_axis(port, state, 1, error[1], velocity[1]),
            along_axis(port, state, 2, error[2], velocity[2]),
        )
        state[ENERGY] = energy(port, abs(error[0])) + energy(port, abs(error[1])) + energy(port, abs(error[2]))
    else:
        inverse = 1.0 / size if size > SMALLEST else 0.0
        n = (inverse * error[0], inverse * error[1], inverse * error[2])
        converging = remember(port, state, 0, size, -dot(n, velocity))
        f = response(port, size, state[PEAK], converging)
        h = (f * n[0], f * n[1], f * n[2])
        state[ENERGY] = energy(port, size)
    damping = port[DAMPING]
    total = (h[0] - damping * velocity[0], h[1] - damping * velocity[1], h[2] - damping * velocity[2])
    state[MOVED] = 0.0
    for i in range(3):
        state[ERROR + i] = error[i]
        state[FORCE + i] = h[i]
    state[POWER] = dot(total, velocity)
    return total
