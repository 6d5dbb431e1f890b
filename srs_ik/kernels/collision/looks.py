"""How far around an arm angle two bodies are certainly apart, or in each other, by their real shapes.

A body that turns about the line S-W moves no point farther than its distance from the line times the angle, and across
the line: a plane that lies along the line part of the way is neared by that part of it. Bodies that spin besides move
by the rates of the joints that turn them, which are bounded first. Where bodies are some depth in each other, no motion
shorter than that takes them apart.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from srs_ik.kernels.algebra.vectors import add, along, apply, cross, dot, load3, norm, scale, sub, times
from srs_ik.kernels.collision.march import ANYWHERE, posture_on
from srs_ik.kernels.collision.seen import frame_at
from srs_ik.kernels.collision.shapes import (
    between,
    body_from_line,
    frame_of_joint,
    gap,
    least_along,
    put_frames,
    reach_from_line,
    turned_about_line,
)
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.collision import UPPER
from srs_ik.kernels.layout.limb import AXES, POINTS
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
    SPINS,
    TO_FIRST,
    TO_LAST,
)
from srs_ik.kernels.limb.limits import TURN


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
def turns(joint):
    """Whether the body of a joint turns with the arm angle."""
    return 2 <= joint <= 5


@kernel
def times_rate(length, rate):
    """A length times a rate that may be infinite."""
    return length * rate if length > 0.0 else 0.0


NARROW = 1e-6
"""Rates are bounded within no less than this, rad."""

SOLIDS_APART = 4
"""Slots of `normals` for each solid of the first body."""

ABOUT_LINE = 0
ALONG_CHAIN = 1
AT_SPIN = 2


class Question(NamedTuple):
    """Two bodies of a pose, and what is to be left between them."""

    P: object
    target: object
    shapes: object
    frames: tuple  # how rows are seen from the line S-W
    space: object
    pair: tuple  # numbers of the two bodies
    branch: int  # whose postures count; where the arm angle is enough, -1 for the first elbow and -2 for the second
    margin: float
    mode: int  # how they are looked at
    way: tuple  # how the first one turns about a line, if it does
    spins: tuple  # spins of it that hit, if nothing else moves it


class Way(NamedTuple):
    """How a body turns about a line against another one."""

    rest: tuple  # how it is seen from the line at angle zero: the first coordinate is along it
    there: tuple  # how the other one is seen
    rate: float
    """Largest distance of its points from the line, m; 0 where it does not turn; negative where solids tell it."""


class Spins(NamedTuple):
    """Spins of a body that hit."""

    arcs: object  # (m, 2) a set of angles
    many: int
    sign: float  # the spin is this times the joint's angle
    joint: int  # from 0


@kernel
def way_about_line(shapes, pair, frames):
    """The way of two bodies of which one turns about the line S-W as one, the first, or none."""
    place, other = shapes.of_body[pair[0], PLACE], shapes.of_body[pair[1], PLACE]
    moves = place >= UPPER and other < UPPER
    still, turning = frames
    return Way(frame_at(place, still, turning), frame_at(other, still, turning), -1.0 if moves else 0.0)


@kernel
def spin_axis(joint):
    """The joint, from 0, about whose axis a body spins against what moves it, and the sign of the spin."""
    if joint == 1:
        return 0, 1.0
    if joint == 2:
        return 2, -1.0
    return (4, 1.0) if joint == 5 else (6, -1.0)


@kernel
def only_spins(shapes, a, b):
    """Whether nothing but the spin of the first body moves two bodies against each other."""
    of_body = shapes.of_body
    if of_body[a, SPINS] == 0 or of_body[b, SPINS] != 0:
        return False
    return (of_body[a, PLACE] >= UPPER) == (of_body[b, PLACE] >= UPPER)


@kernel
def way_of_spin(P, shapes, pair, frames):
    """The way of the first of two bodies that nothing but its spin moves against each other."""
    still, turning = frames
    M, b = frame_at(shapes.of_body[pair[0], PLACE], still, turning)
    N, c = frame_at(shapes.of_body[pair[1], PLACE], still, turning)
    joint, _ = spin_axis(shapes.of_body[pair[0], JOINT])
    u = apply(M, load3(P, AXES + 3 * joint))
    origin = add(apply(M, load3(P, POINTS + 3 * joint)), b)
    # Any direction across the axis will do.
    x = (1.0, 0.0, 0.0) if abs(u[0]) < 0.7 else (0.0, 1.0, 0.0)
    x = along(x, -dot(u, x), u)
    x = scale(1.0 / norm(x), x)
    y = cross(u, x)
    A = (u[0], u[1], u[2], x[0], x[1], x[2], y[0], y[1], y[2])
    rate = shapes.bodies[pair[0], SPIN]
    return Way((times(A, M), apply(A, sub(b, origin))), (times(A, N), apply(A, sub(c, origin))), rate)


@kernel
def look(question, psi, half):
    """How far around an angle the bodies are apart, no farther than half; minus how far they meet; 0: unknown."""
    if question.mode == ABOUT_LINE:
        return look_about_line(question, psi, half)
    if question.mode == AT_SPIN:
        return look_at_spin(question, psi, half)
    return look_along_chain(question, psi, half)


@kernel
def look_about_line(question, psi, half):
    """The same of bodies of which none but the first one turns, about a line."""
    shapes, margin = question.shapes, question.margin
    of_body = shapes.of_body
    a, b = question.pair
    way = question.way
    rest, there = way.rest, way.there
    moves = way.rate != 0.0
    one = turned_about_line(rest, (math.cos(psi), math.sin(psi))) if moves else rest
    frame = between(one, there)
    best = half if moves else math.inf
    for i in range(of_body[a, FIRST_SOLID], of_body[a, LAST_SOLID]):
        rate = reach_from_line(shapes, i, rest) if way.rate < 0.0 else way.rate
        for j in range(of_body[b, FIRST_SOLID], of_body[b, LAST_SOLID]):
            slot = SOLIDS_APART * (i - of_body[a, FIRST_SOLID]) + j - of_body[b, FIRST_SOLID]
            needed = margin + (best * rate if moves else 0.0)
            value, normal = gap(shapes, i, j, frame, slot, needed)
            room = value - margin
            if room <= 0.0:
                return max(room / rate, -half) if moves else -math.inf
            if moves and room < best * rate:
                best = min(best, keeps_off(shapes, (i, j), (one, there), normal, (margin, rate), best))
    return best


@kernel
def look_at_spin(question, psi, half):
    """The same of two bodies of a branch of which it is known at which spins of the first one they meet."""
    spins = question.spins
    if spins.many == 0:
        return half
    q, met = posture_on(question.P, question.target, psi, question.branch, ANYWHERE, question.space)
    if not met:
        return 0.0
    half = max(half, NARROW)
    k, middle = (0, 1) if spins.joint < 4 else (1, 5)
    rate = fastest(question.shapes.outer, k, q[middle], half)
    while not rate < math.inf and half > NARROW:
        half *= 0.5
        rate = fastest(question.shapes.outer, k, q[middle], half)
    if not rate < math.inf:
        return 0.0
    return max(min(room_beside(spins, spins.sign * q[spins.joint]) / rate, half), -half)


@kernel
def room_beside(spins, angle):
    """How far an angle is from a set of them; minus how far it is inside."""
    angle -= TURN * math.floor((angle + math.pi) / TURN)
    room = math.inf
    for i in range(spins.many):
        lower, upper = spins.arcs[i, 0], spins.arcs[i, 1]
        if lower <= angle <= upper:
            return max(lower - angle, angle - upper)
        room = min(room, around(lower - angle), around(angle - upper))
    return room


@kernel
def around(angle):
    """An angle in the turn from zero on."""
    return angle - TURN * math.floor(angle / TURN)


@kernel
def keeps_off(shapes, pair, frames, normal, bounds, half):
    """How far a solid may turn about the line, no farther than half, and stay on its side of a plane between the two.

    What a point reaches along the normal is a sinusoid of the angle. To first order that is linear in the point, and
    the least over the solid is concave in the angle: no less than its chord. What is left is half the square of the
    angle times the sinusoid's amplitude, at most.

    The first of the pair turns, the normal is told for the second one; `bounds` are what is to be left, m, and a
    distance from the line that no point of the first one exceeds.
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
    q, met = posture_on(question.P, question.target, psi, question.branch, ANYWHERE, question.space)
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
