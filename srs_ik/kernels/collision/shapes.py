"""Real shapes where the arm angle takes them: about the line shoulder-wrist, or along the chain of a branch."""

from __future__ import annotations

import math
from typing import NamedTuple

from srs_ik.kernels.algebra.lane_trig import seven_turns
from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.algebra.vectors import (
    add,
    along,
    apply,
    apply_transposed,
    dot,
    load3,
    load_pose,
    norm,
    scale,
    store_pose,
    sub,
    times,
)
from srs_ik.kernels.chain.kinematics import first_line, joint_line
from srs_ik.kernels.collision.convex import apart, farthest_point, roundness
from srs_ik.kernels.collision.seen import frame_at
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import shapes as at

NORMALS = 16
"""Room for the planes between two bodies that were found last, by their solids."""

UNKNOWN = -1.0
"""A distance from the line S-W that has not been looked at."""


class Shapes(NamedTuple):
    """The tables of `layout.shapes`, and work space."""

    solids: object  # (S, SOLID)
    of_solid: object  # (S, OF_SOLID) integers
    points: object  # (N, 3)
    bodies: object  # (B, SHAPED)
    of_body: object  # (B, OF_BODY) integers
    pairs: object  # (K, PAIR) integers
    outer: object  # (2, OUTER)
    from_line: object  # (S,) work space: largest distance of a solid from the line S-W, where it turns about it
    frames: object  # (8, 12) work space: where the joints take what they carry, matrix and shift
    normals: object  # (NORMALS, 3) work space: planes that were between two bodies


class Along(NamedTuple):
    """What is looked at along a curve: the shapes, and where joints are at both ends of a step."""

    shapes: object
    couple_of: object  # (n,) integers: which row of the shapes' pairs belongs to each pair that spheres watch, or -1
    before: object  # (8, 12) work space, like `Shapes.frames`, which is for the middle
    behind: object  # (8, 12) work space


@kernel
def centre_of(shapes, i):
    """Centre of the ball around a solid."""
    return load3(row(shapes.solids, i), at.CENTRE)


@kernel
def between(one, other):
    """Where what the first frame moves is for what the second one moves: matrix and shift."""
    M, b = one
    N, c = other
    back = (N[0], N[3], N[6], N[1], N[4], N[7], N[2], N[5], N[8])
    return times(back, M), apply_transposed(N, sub(b, c))


@kernel
def turned_about_line(frame, turn):
    """A frame seen from the line S-W, turned about it by an angle given by cosine and sine."""
    M, b = frame
    c, s = turn
    N = (
        M[0],
        M[1],
        M[2],
        c * M[3] - s * M[6],
        c * M[4] - s * M[7],
        c * M[5] - s * M[8],
        s * M[3] + c * M[6],
        s * M[4] + c * M[7],
        s * M[5] + c * M[8],
    )
    return N, (b[0], c * b[1] - s * b[2], s * b[1] + c * b[2])


@kernel
def off_line(frame, x):
    """Distance of a point from the line S-W, from which the frame sees it."""
    _, v, w = apply(frame[0], x)
    return math.hypot(v + frame[1][1], w + frame[1][2])


@kernel
def reach_from_line(shapes, i, frame):
    """Largest distance of a point of a solid from the line S-W, or a little more."""
    known = shapes.from_line[i]
    if known != UNKNOWN:
        return known
    solids = shapes.solids
    largest = 0.0
    if shapes.of_solid[i, at.KIND] == at.CYLINDER:
        for sign in (-1.0, 1.0):
            end = along(centre_of(shapes, i), sign * solids[i, at.HALF], load3(row(solids, i), at.AXIS))
            largest = max(largest, off_line(frame, end))
    else:
        for k in range(shapes.of_solid[i, at.FIRST], shapes.of_solid[i, at.LAST]):
            largest = max(largest, off_line(frame, load3(row(shapes.points, k), 0)))
    largest += solids[i, at.RADIUS]
    shapes.from_line[i] = largest
    return largest


@kernel
def body_from_line(shapes, body, frames):
    """The same of a body that turns, where the arm angle is zero."""
    largest = 0.0
    frame = frame_at(shapes.of_body[body, at.PLACE], frames[0], frames[1])
    for i in range(shapes.of_body[body, at.FIRST_SOLID], shapes.of_body[body, at.LAST_SOLID]):
        largest = max(largest, reach_from_line(shapes, i, frame))
    return largest


@kernel
def forget(shapes):
    """Forget the planes between the bodies of another pair."""
    for k in range(NORMALS):
        shapes.normals[k, 0], shapes.normals[k, 1], shapes.normals[k, 2] = 0.0, 0.0, 0.0


@kernel
def limited(x):
    """The nearest figure between -1 and 1."""
    return min(max(x, -1.0), 1.0)


@kernel
def depth_within(shapes, i, j, M, centre):
    """How deep the capsules within two solids are in each other, m; `centre` is where that of i is for that of j."""
    inner, other = shapes.solids[i, at.INNER], shapes.solids[j, at.INNER]
    if inner < 0.0 or other < 0.0:
        return -1.0
    # From the centre of each to one end of the segment within it.
    a, b = apply(M, load3(row(shapes.solids, i), at.SEGMENT)), load3(row(shapes.solids, j), at.SEGMENT)
    aa, ab, bb = dot(a, a), dot(a, b), dot(b, b)
    ca, cb = dot(centre, a), dot(centre, b)
    # The nearest points are centre + s a and t b.
    across = aa * bb - ab * ab
    s = limited((ab * cb - bb * ca) / across) if across > 1e-12 * aa * bb else 0.0
    t = limited((cb + s * ab) / bb) if bb > 0.0 else 0.0
    s = limited((t * ab - ca) / aa) if aa > 0.0 else 0.0
    t = limited((cb + s * ab) / bb) if bb > 0.0 else 0.0
    x = centre[0] + s * a[0] - t * b[0]
    y = centre[1] + s * a[1] - t * b[1]
    z = centre[2] + s * a[2] - t * b[2]
    return inner + other - math.sqrt(x * x + y * y + z * z)


@kernel
def least_along(shapes, i, frame, d):
    """The least that a solid reaches along a direction, where the frame takes it."""
    M, b = frame
    point = farthest_point(shapes, i, apply_transposed(M, scale(-1.0, d)))
    return dot(d, add(apply(M, point), b)) - roundness(shapes, i) * norm(d)


START = (1.0, 0.0, 0.0)
"""A direction to begin with where none is nearer at hand."""


@kernel
def gap(shapes, i, j, frame, slot, needed):
    """Distance of two solids as far as it matters, see `convex.apart`, beginning where the last search ended."""
    M, b = frame
    if shapes.of_solid[j, at.KIND] == at.HALF_SPACE:
        out = load3(row(shapes.solids, j), at.AXIS)
        return least_along(shapes, i, frame, out) - dot(out, centre_of(shapes, j)), out
    centre = sub(add(apply(M, centre_of(shapes, i)), b), centre_of(shapes, j))
    length = norm(centre)
    balls = shapes.solids[i, at.BALL] + shapes.solids[j, at.BALL]
    if length - balls >= needed:
        return length - balls, (centre[0] / length, centre[1] / length, centre[2] / length)
    within = depth_within(shapes, i, j, M, centre)
    if within > 0.0:
        return -within, (centre[0] / length, centre[1] / length, centre[2] / length) if length > 0.0 else START
    k = slot % NORMALS
    normals = shapes.normals
    start = (normals[k, 0], normals[k, 1], normals[k, 2])
    if start[0] == 0.0 and start[1] == 0.0 and start[2] == 0.0:
        start = centre if length > 1e-9 else START
    value, normal = apart(shapes, i, j, frame, start, needed)
    normals[k, 0], normals[k, 1], normals[k, 2] = normal
    return value, normal


@kernel
def is_whole(shapes, a, b):
    """Whether two bodies are nothing but their solids; to a half-space, a shape is as near as its hull."""
    if shapes.of_solid[shapes.of_body[b, at.FIRST_SOLID], at.KIND] == at.HALF_SPACE:
        return True
    for body in (a, b):
        for i in range(shapes.of_body[body, at.FIRST_SOLID], shapes.of_body[body, at.LAST_SOLID]):
            if shapes.of_solid[i, at.IS_WHOLE] == 0:
                return False
    return True


@kernel
def put_frames(P, q, frames):
    """Write where all joints take what they carry at a posture, in the base frame, into frames (8, 12)."""
    turns = seven_turns(q)
    store_pose(row(frames, 0), 0, (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0))
    _, _, M, b = first_line(P, turns[0])
    store_pose(row(frames, 1), 0, M, b)
    for joint in range(1, 7):
        _, _, M, b = joint_line(P, joint, turns[joint], M, b)
        store_pose(row(frames, joint + 1), 0, M, b)


@kernel
def frame_of_joint(frames, joint):
    """What has been written for a joint."""
    return load_pose(row(frames, joint), 0)
