"""What a posture cannot be had without: the cost of its transcendental functions on this machine, as a yardstick.

A posture is seven angles: seven arctangents of what is found by products and roots. The arm angle is given as an angle,
and goes in by its sine and cosine. Whoever wants the error of the posture measured needs those of the seven joints too.
"""

from __future__ import annotations

import numpy as np

from srs_ik.bench.own import best_time
from srs_ik.kernels.entries.yardstick import transcendental

COUNT = 20_000


def floor_us() -> float:
    """Time of the transcendental functions of one posture with its measured error, on one thread, microseconds."""
    angles = np.random.default_rng(0).uniform(-np.pi, np.pi, (COUNT, 8))
    out = np.empty(COUNT)
    return best_time(transcendental, angles, out) / COUNT
