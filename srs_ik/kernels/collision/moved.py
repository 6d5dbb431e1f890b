"""How far bodies have moved against each other between three postures of a curve, and whether they stay apart there."""

import math

from srs_ik.kernels.algebra.vectors import add, apply, apply_transposed, norm, sub, times
from srs_ik.kernels.collision.forbidden import distance_of, fixed_clearance
from srs_ik.kernels.collision.motion import CLEAR, HALVE, HIT, carried
from srs_ik.kernels.collision.seen import frame_of, see_balls, see_group
from srs_ik.kernels.collision.shapes import between, centre_of, frame_of_joint, gap, put_frames
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.collision import MARGIN
from srs_ik.kernels.layout.shapes import BALL, FIRST_SOLID, JOINT, LAST_SOLID, ONE, OTHER

BEYOND = 1.25
"""How much farther than at the ends of a step bodies are taken to move within it."""

FARTHEST = 2.0
"""A rotation turns no two points of a ball farther than this many radii against each other."""


@kernel
def seen_from(world, a, b, frames):
    """Where the ball around a group is for one that carries group b, at a posture, and how it is turned."""
    still, turning = frames
    M_a, shift_a = frame_of(world, a, still, turning)
    M_b, shift_b = frame_of(world, b, still, turning)
    centre = (world.bodies[a, 0], world.bodies[a, 1], world.bodies[a, 2])
    back = (M_b[0], M_b[3], M_b[6], M_b[1], M_b[4], M_b[7], M_b[2], M_b[5], M_b[8])
    return apply_transposed(M_b, sub(add(apply(M_a, centre), shift_a), shift_b)), times(back, M_a)


@kernel
def turned(A, B):
    """How far a point of a ball of radius 1 moves from one rotation to another at most."""
    trace = 0.0
    for i in range(9):
        trace += A[i] * B[i]
    return math.sqrt(max(3.0 - trace, 0.0))


@kernel
def relative_motion(world, a, b, three):
    """How far points of one group move against another from the middle of a step on, at most, m."""
    before, middle, behind = three
    centre, turn = seen_from(world, a, b, middle)
    most = 0.0
    for end in (before, behind):
        there, other = seen_from(world, a, b, end)
        most = max(most, norm(sub(there, centre)) + world.bodies[a, 3] * min(turned(turn, other), FARTHEST))
    return BEYOND * most


@kernel
def solid_motion(along, i, a, b):
    """How far points of a solid of body a move against body b from the middle of a step on, at most, m."""
    shapes = along.shapes
    joint, other = shapes.of_body[a, JOINT], shapes.of_body[b, JOINT]
    M, shift = between(frame_of_joint(shapes.frames, joint), frame_of_joint(shapes.frames, other))
    ball = centre_of(shapes, i)
    centre = add(apply(M, ball), shift)
    most = 0.0
    for frames in (along.before, along.behind):
        N, end = between(frame_of_joint(frames, joint), frame_of_joint(frames, other))
        away = norm(sub(add(apply(N, ball), end), centre))
        most = max(most, away + shapes.solids[i, BALL] * min(turned(M, N), FARTHEST))
    return BEYOND * most


@kernel
def shapes_apart(along, k, margin):
    """How far the shapes of a pair are apart in the middle of a step, as far as it matters, and how far they move."""
    shapes = along.shapes
    of_body = shapes.of_body
    a, b = shapes.pairs[k, ONE], shapes.pairs[k, OTHER]
    frame = between(frame_of_joint(shapes.frames, of_body[a, JOINT]), frame_of_joint(shapes.frames, of_body[b, JOINT]))
    least, moved = math.inf, 0.0
    for i in range(of_body[a, FIRST_SOLID], of_body[a, LAST_SOLID]):
        moving = solid_motion(along, i, a, b)
        for j in range(of_body[b, FIRST_SOLID], of_body[b, LAST_SOLID]):
            value = gap(shapes, i, j, frame, i + j, margin + moving)[0]
            if value - moving < least - moved:
                least, moved = value, moving
    return least, moved


@kernel
def put_step(P, postures, along):
    """Write where the joints are at the three postures of a step."""
    put_frames(P, postures[0], along.before)
    put_frames(P, postures[1], along.shapes.frames)
    put_frames(P, postures[2], along.behind)


@kernel
def look_between(P, postures, world, slack, along):
    """Whether all pairs stay clear in a step, given by three postures.

    Where `along` tells the shapes of bodies, these are looked at where spheres are in the way.

    Returns:
        The verdict; the least clearance in the middle where it is not clear, m; and how far that pair moves, m.
    """
    before, _, _ = carried(P, postures[0])
    middle, _, _ = carried(P, postures[1])
    behind, _, _ = carried(P, postures[2])
    three = (before, middle, behind)
    still, turning = middle
    see_balls(world, 0, still, turning)
    pairs, margin = world.pairs, slack[MARGIN]
    verdict, least, moved = CLEAR, math.inf, 0.0
    placed = False
    for k in range(pairs.shape[0]):
        a, b = pairs[k, 0], pairs[k, 1]
        apart = distance_of(world.local, a, b)
        if apart >= least:
            continue
        moving = relative_motion(world, a, b, three)
        if apart > margin + moving:
            continue
        see_group(world, a, 0, still, turning)
        see_group(world, b, 0, still, turning)
        value = fixed_clearance(world, a, b, min(least, margin + moving + 1e-9))
        if value > margin + moving:
            continue
        if along is not None and along.couple_of[k] >= 0:
            if not placed:
                put_step(P, postures, along)
                placed = True
            value, moving = shapes_apart(along, along.couple_of[k], margin)
            if value > margin + moving:
                continue
        verdict = max(verdict, HIT if value < margin else HALVE)
        if value < least:
            least, moved = value, moving
    return verdict, least, moved
