"""Force profiles: how hard a port pulls at a distance, and the energy that this takes."""

import math

from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.control import KNEE, LARGEST, PROFILE, SATURATED, STIFFNESS, TANH, WIDTH

LOG_2 = math.log(2.0)


@kernel
def force(port, x):
    """Force (N, N m) at a distance x >= 0 (m, rad)."""
    stiffness = port[STIFFNESS]
    largest = port[LARGEST]
    if port[PROFILE] == TANH:
        return largest * math.tanh(stiffness * x / largest)
    if port[PROFILE] == SATURATED or x <= port[KNEE]:
        return min(stiffness * x, largest)
    spring = stiffness * port[KNEE]
    return largest - (largest - spring) * math.exp((port[KNEE] - x) / port[WIDTH])


@kernel
def energy(port, x):
    """Integral of the force from 0 to x (J)."""
    stiffness = port[STIFFNESS]
    largest = port[LARGEST]
    if port[PROFILE] == TANH:
        y = stiffness * x / largest
        # ln cosh y; its square form where the difference of the other one would be rounding.
        log = 0.5 * y * y * (1.0 - y * y / 6.0) if y < 1e-3 else y - LOG_2 + math.log1p(math.exp(-2.0 * y))
        return largest * largest / stiffness * log
    knee = largest / stiffness if port[PROFILE] == SATURATED else port[KNEE]
    if x <= knee:
        return 0.5 * stiffness * x * x
    beyond = x - knee
    if port[PROFILE] == SATURATED:
        return 0.5 * stiffness * knee * knee + largest * beyond
    width = port[WIDTH]
    rise = (largest - stiffness * knee) * width * -math.expm1(-beyond / width)
    return 0.5 * stiffness * knee * knee + largest * beyond - rise
