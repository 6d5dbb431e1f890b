"""What a posture cannot be had without: the cost of its transcendental functions on this machine, as a yardstick.

A posture is seven angles: seven arctangents of what is found by products and roots. The arm angle is given as an angle,
and goes in by its sine and cosine. Whoever wants the error of the posture measured needs those of the seven joints too.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from srs_ik.bench.own import best_time

COUNT = 20_000


@njit(error_model="numpy", nogil=True)
def _posture(angles: NDArray[np.float64], out: NDArray[np.float64]) -> None:
    """Eight sine and cosine pairs and seven arctangents for each row, with no work between them."""
    for i in range(len(out)):
        total = 0.0
        c, s = math.cos(angles[i, 7]), math.sin(angles[i, 7])
        for j in range(7):
            total += math.atan2(s + angles[i, j], c)
            total += math.cos(angles[i, j]) + math.sin(angles[i, j])
        out[i] = total


def floor_us() -> float:
    """Time of the transcendental functions of one posture with its measured error, on one thread, microseconds."""
    angles = np.random.default_rng(0).uniform(-np.pi, np.pi, (COUNT, 8))
    out = np.empty(COUNT)
    return best_time(_posture, angles, out) / COUNT
