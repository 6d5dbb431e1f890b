"""The Fractal Impedance Controller: a spring while the error grows, and half a period of a harmonic while it shrinks.

Source: C. Tiseo et al., Bio-mimetic Adaptive Force/Position Control Using Fractal Impedance, arXiv 2003.01466 (law A);
law B is that of its authors' published program.
"""

import math

from srs_ik.kernels.algebra.vectors import along, dot, load3
from srs_ik.kernels.control.frame import grows, lay_axes
from srs_ik.kernels.control.profile import energy, force
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import control as at

SMALLEST = 1e-150
"""A peak below this, m or rad, is none; its square would be no number."""


@kernel
def response(port, size, peak, converging):
    """Force towards the target at an error of a size, after a peak; negative where it brakes."""
    if not converging or peak < SMALLEST or port[at.LAW] > at.LAW_B:
        return force(port, size)
    if port[at.LAW] == at.LAW_A:
        return force(port, peak) * (2.0 * size / peak - 1.0)
    pull = 4.0 * energy(port, peak) / peak * (size / peak - 0.5)
    return max(-port[at.LARGEST], min(port[at.LARGEST], pull))


@kernel
def remember(port, state, axis, size, growth):
    """Note the size of an error, and whether it grows: a new peak. Returns whether the axis converges.

    `growth` is the rate of the size for a target at rest, m/s or rad/s.
    """
    was_growing = state[at.CONVERGING + axis] == 0.0
    growing = grows(port, state, state[at.LAST + axis], size, growth, was_growing)
    if growing or size > state[at.PEAK + axis]:
        state[at.PEAK + axis] = size
    state[at.LAST + axis] = size
    state[at.CONVERGING + axis] = 0.0 if growing else 1.0
    return not growing


@kernel
def along_axis(port, state, axis, error, rate):
    """Force along one axis, for an error there and the speed of what is pulled."""
    size = abs(error)
    sign = math.copysign(1.0, error)
    converging = remember(port, state, axis, size, -sign * rate)
    return sign * response(port, size, state[at.PEAK + axis], converging)


@kernel
def along_axes(port, state, error, velocity):
    """Force along each of three axes, for an error and a velocity in them; notes the energy of all."""
    h = (
        along_axis(port, state, 0, error[0], velocity[0]),
        along_axis(port, state, 1, error[1], velocity[1]),
        along_axis(port, state, 2, error[2], velocity[2]),
    )
    state[at.ENERGY] = energy(port, abs(error[0])) + energy(port, abs(error[1])) + energy(port, abs(error[2]))
    return h


@kernel
def pull(port, state, error, velocity):
    """Force or torque (three figures) for an error vector and the velocity of what is pulled; notes what it did."""
    if port[at.PER_AXIS] == 1.0:
        h = along_axes(port, state, error, velocity)
    else:
        lay_axes(port, state, error, velocity)
        x = load3(state, at.FRAME)
        y = load3(state, at.FRAME + 3)
        z = load3(state, at.FRAME + 6)
        e = (dot(x, error), dot(y, error), dot(z, error))
        v = (dot(x, velocity), dot(y, velocity), dot(z, velocity))
        f = along_axes(port, state, e, v)
        h = along(along(along((0.0, 0.0, 0.0), f[0], x), f[1], y), f[2], z)
    return damped(port, state, error, velocity, h)


@kernel
def pull_angle(port, state, error, rate, share):
    """Torque for the error of one angle, and the rate at which it does work; notes what it did.

    `share` is that rate over the one of the angle itself. Where it is below one, the arm gives less than the profile
    takes, and gets as much less back.
    """
    last, size = state[at.LAST], abs(error)
    h = along_axis(port, state, 0, error, rate)
    stored = energy(port, size)
    if size > last >= 0.0 and stored > 0.0 and (share < 1.0 or state[at.LOST] > 0.0):
        before = energy(port, last)
        state[at.LOST] = (state[at.LOST] * before + (1.0 - share) * (stored - before)) / stored
    given = 1.0 - state[at.LOST]
    if state[at.CONVERGING] == 1.0:
        h *= given
    state[at.ENERGY] = given * stored
    return damped(port, state, (error, 0.0, 0.0), (rate, 0.0, 0.0), (h, 0.0, 0.0))[0]


@kernel
def damped(port, state, error, velocity, h):
    """A force with the damping of its port; notes the error, the force and the power of both."""
    total = along(h, -port[at.DAMPING], velocity)
    state[at.MOVED] = 0.0
    for i in range(3):
        state[at.ERROR + i] = error[i]
        state[at.FORCE + i] = h[i]
    state[at.POWER] = dot(total, velocity)
    return total
