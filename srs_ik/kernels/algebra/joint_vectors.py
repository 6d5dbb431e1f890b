"""Seven joint angles as a vector: products, sums, and differences the short way round."""

from __future__ import annotations

import math

from srs_ik.kernels.jit import kernel


@kernel
def dot7(a, b):
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5] + a[6] * b[6]


@kernel
def along7(a, s, b):
    """The point a + s b."""
    return (
        a[0] + s * b[0],
        a[1] + s * b[1],
        a[2] + s * b[2],
        a[3] + s * b[3],
        a[4] + s * b[4],
        a[5] + s * b[5],
        a[6] + s * b[6],
    )


@kernel
def short_way(angle):
    """The angle, whole turns apart, in [-pi, pi]."""
    return angle - 2.0 * math.pi * math.floor(angle / (2.0 * math.pi) + 0.5)


@kernel
def difference(a, b):
    """The difference b - a, each joint the short way round."""
    return (
        short_way(b[0] - a[0]),
        short_way(b[1] - a[1]),
        short_way(b[2] - a[2]),
        short_way(b[3] - a[3]),
        short_way(b[4] - a[4]),
        short_way(b[5] - a[5]),
        short_way(b[6] - a[6]),
    )
