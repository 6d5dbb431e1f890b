"""Seven joint angles as a vector: products, sums, and differences the short way round."""

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
def store7(S, k, a):
    """Write seven figures."""
    for j in range(7):
        S[k + j] = a[j]


@kernel
def largest(d):
    """Largest magnitude."""
    return max(max(max(abs(d[0]), abs(d[1])), max(abs(d[2]), abs(d[3]))), max(max(abs(d[4]), abs(d[5])), abs(d[6])))


@kernel
def apart(a, b):
    """Largest difference of two postures, joint by joint."""
    most = 0.0
    for j in range(7):
        most = max(most, abs(a[j] - b[j]))
    return most


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


@kernel
def between(d, low, high):
    """Every figure brought between its bounds."""
    return (
        min(max(d[0], low[0]), high[0]),
        min(max(d[1], low[1]), high[1]),
        min(max(d[2], low[2]), high[2]),
        min(max(d[3], low[3]), high[3]),
        min(max(d[4], low[4]), high[4]),
        min(max(d[5], low[5]), high[5]),
        min(max(d[6], low[6]), high[6]),
    )


@kernel
def with_joint(q, j, angle):
    """Seven figures with one replaced."""
    return (
        angle if j == 0 else q[0],
        angle if j == 1 else q[1],
        angle if j == 2 else q[2],
        angle if j == 3 else q[3],
        angle if j == 4 else q[4],
        angle if j == 5 else q[5],
        angle if j == 6 else q[6],
    )


@kernel
def only(joint, x):
    """A vector whose one figure is x."""
    return (
        x if joint == 0 else 0.0,
        x if joint == 1 else 0.0,
        x if joint == 2 else 0.0,
        x if joint == 3 else 0.0,
        x if joint == 4 else 0.0,
        x if joint == 5 else 0.0,
        x if joint == 6 else 0.0,
    )
