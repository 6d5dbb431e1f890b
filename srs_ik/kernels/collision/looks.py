"""How far around an arm angle two bodies are certainly apart, or in each other, by their real shapes.

A body that turns about the line S-W moves no point farther than its distance from the line times the angle, and across
the line: a plane that lies along the line part of the way is neared by that part of it. Bodies that spin besides move
by the rates of the joints that turn them. Where bodies are some depth in each other, no motion shorter than that takes
them apart.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from srs_ik.kernels.algebra.vectors import add, along, apply, apply_transposed, dot, norm, scale
from srs_ik.kernels.collision.convex import farthest_point, roundness
from srs_ik.kernels.collision.march import ANYWHERE, posture_on
from srs_ik.kernels.collision.seen import frame_at
from srs_ik.kernels.collision.shapes import (
    between,
    body_from_line,
    frame_of_joint,
    gap,
    put_frames,
    reach_from_line,
    turned_about_line,
)
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.collision import UPPER
from srs_ik.kernels.layout.shapes import (
    AROUND,
    BEFORE,
    BEHIND,
    COSINE,
    FIRST_SOLID,
    FIXED,
    JOINT,
    LAST_SOLID,
    PLACE,
    SINE,
    SPIN,
    TO_FIRST,
    TO_LAST,
)

NARROW = 1e-6
"""Rates are bounded within no less than this, rad."""

SOLIDS_APART = 4
"""Slots of `normals` for each solid of the first body."""


class Question(NamedTuple):
    """Two bodies of a pose, and what is to be left between them."""

    P: object
    spot: object
    shapes: object
    frames: tuple
    """How rows are seen from the line S-W."""
    space: object
    pair: tuple
    """Numbers of the two bodies."""
    branch: int
    """Whose postures count; where the arm angle is enough, -1 for the first elbow and -2 for the second."""
    margin: float


@kernel
def look(question, psi, half):
    """How far around an arm angle the bodies are apart, no farther than half; minus how far they meet; 0: unknown."""
    if question.branch < 0:
        return look_about_line(question, psi, half)
    return look_along_chain(question, psi, half)


@kernel
def look_about_line(question, psi, half):
    """The same of bodies that turn as one or stand still: the first of the pair turns if one of them does."""
    shapes, margin = question.shapes, question.margin
    of_body = shapes.of_body
    a, b = question.pair
    still, turning = question.frames
    place, other = of_body[a, PLACE], of_body[b, PLACE]
    moves = place >= UPPER and other < UPPER
    resting = frame_at(place, still, turning)
    there = frame_at(other, still, turning)
    one = turned_about_line(resting, (math.cos(psi), math.sin(psi))) if moves else resting
    frame = between(one, there)
    best = half if moves else math.inf
    for i in range(of_body[a, FIRST_SOLID], of_body[a, LAST_SOLID]):
        rate = reach_from_line(shapes, i, resting) if moves else 0.0
        for j in range(of_body[b, FIRST_SOLID], of_body[b, LAST_SOLID]):
            slot = SOLIDS_APART * (i - of_body[a, FIRST_SOLID]) + j - of_body[b, FIRST_SOLID]
            needed = margin + (best * rate if moves else 0.0)
            value, normal = gap(shapes, i, j, frame, slot, needed)
            room = value - margin
            if room <= 0.0:
                return max(room / rate, -half) if rate > 0.0 else -math.inf
            if moves and room < best * rate:
                best = min(best, keeps_off(shapes, (i, j), (one, there), normal, (margin, rate), best))
    return best


@kernel
def least_along(shapes, i, frame, d):
    """The least that a solid reaches along a direction, both seen from the line."""
    M, b = frame
    point = farthest_point(shapes, i, apply_transposed(M, scale(-1.0, d)))
    return dot(d, add(apply(M, point), b)) - roundness(shapes, i) * norm(d)


@kernel
def keeps_off(shapes, pair, frames, normal, bounds, half):
    """How far a solid may turn about the line, no farther than half, and stay on its side of a plane between the two.

    What a point reaches along the normal is a sinusoid of the angle. To first order that is linear in the point, and
    the least over the solid is concave in the angle: no less than its chord. What is left is half the square of the
    angle times the sinusoid's amplitude, at most.

    Args:
        shapes: the solids.
        pair: the one that turns, and the one that stands still.
        frames: how these are seen from the line.
        normal: of the plane, for the second one.
        bounds: what is to be left, m, and a distance from the line that no point of the first one exceeds.
        half: rad.
    """
    one, there = frames
    margin, rate = bounds
    n = apply(there[0], normal)
    across = rate * math.hypot(n[1], n[2])
    if across <= 0.0:
        return half
    far = -least_along(shapes, pair[1], there, scale(-1.0, n))
    room = least_along(shapes, pair[0], one, n) - far - margin
    reach = room / across
    turned = (0.0, n[2], -n[1])
    side = min(
        least_along(shapes, pair[0], one, along(n, half, turned)),
        least_along(shapes, pair[0], one, along(n, -half, turned)),
    )
    slope = (side - far - margin - room) / half
    # room + slope x - across x^2 / 2 is positive up to there.
    return min(max(reach, (slope + math.sqrt(slope * slope + 2.0 * across * max(room, 0.0))) / across), half)


@kernel
def angle_between(outer, k, q):
    """The angle between the outer axes of shoulder (0) or wrist (1) at an angle of the joint between them."""
    cosine = outer[k, FIXED] + outer[k, COSINE] * math.cos(q) + outer[k, SINE] * math.sin(q)
    return math.acos(min(max(cosine, -1.0), 1.0))


@kernel
def fastest(outer, k, q, half):
    """Largest rate of joints 1 and 3 of a spherical joint within half an arm angle, rad/rad; inf for no bound.

    The rates have the triple product of the three axes below them. Its square is a concave function of the cosine of
    the angle between the outer axes, so the smaller of both ends bounds it; and that angle changes no faster than the
    arm turns.
    """
    angle = angle_between(outer, k, q)
    if angle - half <= 0.0 or angle + half >= math.pi:
        return math.inf
    first, last = outer[k, TO_FIRST], outer[k, TO_LAST]
    least = math.inf
    for end in (angle - half, angle + half):
        c = math.cos(end)
        least = min(least, 1.0 - first * first - last * last - c * c + 2.0 * first * last * c)
    return 1.0 / math.sqrt(least) if least > 0.0 else math.inf


@kernel
def middle_rate(outer, k, rate):
    """The same of the joint between them: 1 where it is square to both."""
    return 1.0 if outer[k, TO_FIRST] == 0.0 and outer[k, TO_LAST] == 0.0 else rate


@kernel
def rate_of(outer, shoulder, wrist, joint):
    """Largest rate of a joint, 1 to 7, from those of the outer ones; the elbow stands still."""
    if joint <= 3:
        return middle_rate(outer, 0, shoulder) if joint == 2 else shoulder
    if joint == 4:
        return 0.0
    return middle_rate(outer, 1, wrist) if joint == 6 else wrist


@kernel
def spin_of(question, body, shoulder, wrist):
    """How fast a body spins against what moves it at most, m/rad."""
    shapes = question.shapes
    joint = shapes.of_body[body, JOINT]
    if joint == 1 or joint == 2:
        return shapes.bodies[body, SPIN] * shoulder if shapes.bodies[body, SPIN] > 0.0 else 0.0
    if joint == 5 or joint == 6:
        return shapes.bodies[body, SPIN] * wrist if shapes.bodies[body, SPIN] > 0.0 else 0.0
    return 0.0


@kernel
def turn_of(question, body):
    """Largest distance of a point of a body from the line S-W, m; 0 for one that does not turn."""
    shapes = question.shapes
    joint = shapes.of_body[body, JOINT]
    if joint == 2 or joint == 5:
        return shapes.bodies[body, AROUND]
    return body_from_line(shapes, body, question.frames) if joint == 3 or joint == 4 else 0.0


@kernel
def turns(joint):
    """Whether the body of a joint turns with the arm angle."""
    return 2 <= joint <= 5


@kernel
def times_rate(length, rate):
    """A length times a rate that may be infinite."""
    return length * rate if length > 0.0 else 0.0


@kernel
def rate_between(question, q, half):
    """How fast two bodies move against each other at most, m/rad: about the line, or by the joints between."""
    shapes = question.shapes
    outer, bodies = shapes.outer, shapes.bodies
    a, b = question.pair
    shoulder, wrist = fastest(outer, 0, q[1], half), fastest(outer, 1, q[5], half)
    total = spin_of(question, a, shoulder, wrist) + spin_of(question, b, shoulder, wrist)
    first, last = shapes.of_body[a, JOINT], shapes.of_body[b, JOINT]
    if not (turns(first) and turns(last)):
        total += turn_of(question, a) + turn_of(question, b)
    if last == first + 2:
        # The first of the two joints may as well turn the other body; all their axes pass one centre.
        centred = first == 0 or first == 1 or first == 4 or first == 5
        reach = min(bodies[a, BEHIND], bodies[b, AROUND]) if centred else bodies[a, BEHIND]
        own = times_rate(reach, rate_of(outer, shoulder, wrist, first + 1))
        own += times_rate(bodies[b, BEFORE], rate_of(outer, shoulder, wrist, last))
        total = min(total, own)
    return total


@kernel
def look_along_chain(question, psi, half):
    """The same of bodies of a branch as they spin."""
    shapes, margin = question.shapes, question.margin
    of_body = shapes.of_body
    q, met = posture_on(question.P, question.spot, psi, question.branch, ANYWHERE, question.space)
    if not met:
        return 0.0
    half = max(half, NARROW)
    rate = rate_between(question, q, half)
    while not rate < math.inf and half > NARROW:
        half *= 0.5
        rate = rate_between(question, q, half)
    if not rate < math.inf:
        return 0.0
    put_frames(question.P, q, shapes.frames)
    a, b = question.pair
    frame = between(frame_of_joint(shapes.frames, of_body[a, JOINT]), frame_of_joint(shapes.frames, of_body[b, JOINT]))
    best = half
    for i in range(of_body[a, FIRST_SOLID], of_body[a, LAST_SOLID]):
        for j in range(of_body[b, FIRST_SOLID], of_body[b, LAST_SOLID]):
            slot = SOLIDS_APART * (i - of_body[a, FIRST_SOLID]) + j - of_body[b, FIRST_SOLID]
            room = gap(shapes, i, j, frame, slot, margin + best * rate)[0] - margin
            if room <= 0.0:
                return max(room / rate, -half) if rate > 0.0 else -half
            if rate > 0.0:
                best = min(best, room / rate)
    return best
