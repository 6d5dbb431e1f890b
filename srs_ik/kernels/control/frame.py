"""The axes of the radial form: along the error at its last peak, along the velocity there, and across both.

On the way out the first axis follows the error, so that the port is a spring towards the target. Where the distance
turns from growing to shrinking, the velocity is across the error: in axes laid along both, the motion on each is one
that the law brings to rest. Forces towards the target alone would keep the angular momentum about it, and the motion on
an ellipse. New axes never add energy: where F(x)/x does not grow, U is a concave function of the square of the
distance, so that U(|e|), all of it along the first axis, is at most the sum of U over any three axes.
"""

import math

from srs_ik.kernels.algebra.vectors import along, cross, dot, scale
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.control import (
    AGAIN,
    BACK,
    CONVERGING,
    FRAME,
    LAST,
    LEAVING,
    MOVED,
    PEAK,
    PHASE,
    SIZE,
    SWITCH,
)

NO_DIRECTION = 1e-12
"""An error (m, rad) or a velocity (m/s, rad/s) that is smaller has no direction that counts."""


@kernel
def grows(port, state, last, size, growth, was_growing):
    """Whether an error of this size grows, whose size was `last` a tick ago (negative: there was none).

    `growth` is the rate of the size for a target at rest (m/s, rad/s). It tells at once what the size itself tells one
    period late; for a target that has moved it says nothing.
    """
    if last < 0.0:
        return True
    if port[SWITCH] >= 0.0 and state[MOVED] == 0.0:
        return growth >= -port[SWITCH]
    if size != last:
        return size > last
    return was_growing


@kernel
def lay_axes(port, state, error, velocity):
    """Lay the axes of a port for an error and the velocity of what is pulled; notes the distance and its phase."""
    size = math.hypot(math.hypot(error[0], error[1]), error[2])
    n = scale(1.0 / size, error) if size > NO_DIRECTION else (1.0, 0.0, 0.0)
    last = state[SIZE]
    growth = -dot(n, velocity) if size > NO_DIRECTION else 0.0
    growing = grows(port, state, last, size, growth, state[PHASE] != BACK)
    if last < 0.0:
        state[PHASE] = LEAVING
    if growing and state[PHASE] == BACK:
        state[PHASE] = AGAIN
    if not growing and state[PHASE] != BACK:
        state[PHASE] = BACK
        write_axes(state, n, velocity)
        begin_return(state, size if state[MOVED] == 1.0 else max(size, last))
    elif state[PHASE] == LEAVING:
        write_axes(state, n, velocity)
    state[SIZE] = size


@kernel
def begin_return(state, peak):
    """Forget the peaks but for that of the first axis."""
    for axis in range(3):
        state[LAST + axis] = -1.0
        state[PEAK + axis] = 0.0
        state[CONVERGING + axis] = 0.0
    state[LAST] = peak
    state[PEAK] = peak
    state[CONVERGING] = 1.0


@kernel
def write_axes(state, n, velocity):
    """Write the axes: n, the part of the velocity across it, and across both."""
    sideways = along(velocity, -dot(n, velocity), n)
    length = math.sqrt(dot(sideways, sideways))
    if length < NO_DIRECTION:
        # Any direction across n; the longest of three is well defined.
        x = cross(n, (1.0, 0.0, 0.0))
        y = cross(n, (0.0, 1.0, 0.0))
        sideways = x if dot(x, x) > dot(y, y) else y
        length = math.sqrt(dot(sideways, sideways))
    sideways = scale(1.0 / length, sideways)
    third = cross(n, sideways)
    for i in range(3):
        state[FRAME + i] = n[i]
        state[FRAME + 3 + i] = sideways[i]
        state[FRAME + 6 + i] = third[i]
