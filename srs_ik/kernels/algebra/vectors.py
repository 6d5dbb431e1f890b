"""Vectors as tuples of three floats, matrices as tuples of nine in row-major order."""

import math

from srs_ik.kernels.jit import kernel


@kernel
def load3(P, k):
    """Three consecutive figures of the packed limb."""
    return (P[k], P[k + 1], P[k + 2])


@kernel
def store3(P, k, v):
    """Write three consecutive figures of a limb that is being packed."""
    P[k] = v[0]
    P[k + 1] = v[1]
    P[k + 2] = v[2]


@kernel
def angle_between(a, b):
    """Angle between two vectors, rad, with all digits where it is small."""
    return math.atan2(norm(cross(a, b)), dot(a, b))


@kernel
def load9(P, k):
    """Nine consecutive figures of the packed limb, a matrix."""
    return (P[k], P[k + 1], P[k + 2], P[k + 3], P[k + 4], P[k + 5], P[k + 6], P[k + 7], P[k + 8])


@kernel
def add(a, b):
    """Sum."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@kernel
def sub(a, b):
    """Difference."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@kernel
def scale(s, a):
    """Multiple."""
    return (s * a[0], s * a[1], s * a[2])


@kernel
def along(a, s, b):
    """The point a + s b."""
    return (a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2])


@kernel
def dot(a, b):
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def cross(a, b):
    """Vector product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@kernel
def norm(a):
    """Length; it does not overflow."""
    square = a[0] * a[0] + a[1] * a[1] + a[2] * a[2]
    if square < 1e300:
        return math.sqrt(square)
    largest = max(abs(a[0]), abs(a[1]), abs(a[2]))
    return largest * math.sqrt((a[0] / largest) ** 2 + (a[1] / largest) ** 2 + (a[2] / largest) ** 2)


@kernel
def across(a, u):
    """The part of a perpendicular to the unit vector u."""
    return along(a, -dot(u, a), u)


@kernel
def rotate(axis, c, s, v):
    """The vector v turned about a unit axis by the angle with cosine c and sine s (Rodrigues)."""
    k = (1.0 - c) * dot(axis, v)
    x = cross(axis, v)
    return (c * v[0] + s * x[0] + k * axis[0], c * v[1] + s * x[1] + k * axis[1], c * v[2] + s * x[2] + k * axis[2])


@kernel
def rotation(axis, c, s):
    """The matrix of the turn about a unit axis by the angle with cosine c and sine s, for more vectors than one."""
    x, y, z = axis
    kx = (1.0 - c) * x
    ky = (1.0 - c) * y
    kz = (1.0 - c) * z
    xy = kx * y
    yz = ky * z
    zx = kz * x
    return (c + kx * x, xy - s * z, zx + s * y, xy + s * z, c + ky * y, yz - s * x, zx - s * y, yz + s * x, c + kz * z)


@kernel
def apply(M, v):
    """M v."""
    return (
        M[0] * v[0] + M[1] * v[1] + M[2] * v[2],
        M[3] * v[0] + M[4] * v[1] + M[5] * v[2],
        M[6] * v[0] + M[7] * v[1] + M[8] * v[2],
    )


@kernel
def apply_transposed(M, v):
    """M' v."""
    return (
        M[0] * v[0] + M[3] * v[1] + M[6] * v[2],
        M[1] * v[0] + M[4] * v[1] + M[7] * v[2],
        M[2] * v[0] + M[5] * v[1] + M[8] * v[2],
    )


@kernel
def times(A, B):
    """A B."""
    return (
        A[0] * B[0] + A[1] * B[3] + A[2] * B[6],
        A[0] * B[1] + A[1] * B[4] + A[2] * B[7],
        A[0] * B[2] + A[1] * B[5] + A[2] * B[8],
        A[3] * B[0] + A[4] * B[3] + A[5] * B[6],
        A[3] * B[1] + A[4] * B[4] + A[5] * B[7],
        A[3] * B[2] + A[4] * B[5] + A[5] * B[8],
        A[6] * B[0] + A[7] * B[3] + A[8] * B[6],
        A[6] * B[1] + A[7] * B[4] + A[8] * B[7],
        A[6] * B[2] + A[7] * B[5] + A[8] * B[8],
    )


@kernel
def swing(circle, cosine, sine):
    """The vector a + cosine b + sine c of a circle (a, b, c)."""
    a, b, c = circle
    return (a[0] + cosine * b[0] + sine * c[0], a[1] + cosine * b[1] + sine * c[1], a[2] + cosine * b[2] + sine * c[2])


@kernel
def times_transposed(A, B):
    """A B'."""
    return (
        A[0] * B[0] + A[1] * B[1] + A[2] * B[2],
        A[0] * B[3] + A[1] * B[4] + A[2] * B[5],
        A[0] * B[6] + A[1] * B[7] + A[2] * B[8],
        A[3] * B[0] + A[4] * B[1] + A[5] * B[2],
        A[3] * B[3] + A[4] * B[4] + A[5] * B[5],
        A[3] * B[6] + A[4] * B[7] + A[5] * B[8],
        A[6] * B[0] + A[7] * B[1] + A[8] * B[2],
        A[6] * B[3] + A[7] * B[4] + A[8] * B[5],
        A[6] * B[6] + A[7] * B[7] + A[8] * B[8],
    )


@kernel
def load_pose(S, k):
    """Rotation and position, or matrix and shift, from place k on."""
    return load9(S, k), load3(S, k + 9)


@kernel
def store_pose(S, k, R, p):
    """Write a rotation and a position, or a matrix and a shift, from place k on."""
    for i in range(9):
        S[k + i] = R[i]
    store3(S, k + 9, p)
