"""What a posture cannot be had without: its transcendental functions, with no work between them."""

import math

from srs_ik.kernels.jit import entry


@entry
def transcendental(angles, out):
    """Eight sine and cosine pairs and seven arctangents for each row of angles (n, 8); their sums go to out (n,)."""
    for i in range(len(out)):
        total = 0.0
        c, s = math.cos(angles[i, 7]), math.sin(angles[i, 7])
        for j in range(7):
            total += math.atan2(s + angles[i, j], c)
            total += math.cos(angles[i, j]) + math.sin(angles[i, j])
        out[i] = total
