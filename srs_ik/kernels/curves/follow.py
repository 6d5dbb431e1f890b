"""The self-motion of a near limb, followed on its true chain.

All postures that reach a pose form closed curves in the space of joint angles. Those of an exact limb are known in
closed form (`intervals`); those of a near limb lie beside them but for the neighbourhood of singularities, where they
connect otherwise and the arm angle may run back and forth. So they are followed step by step, along the null vector
of the Jacobian.

The null vector t is oriented so that the determinant of J with t as a last row is positive. Where two curves come
close, a step from one to the other would keep the direction and turn this orientation around: that is how it is
noticed.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.joint_vectors import along7, difference, dot7, only, short_way
from srs_ik.kernels.algebra.linear import solve_linear
from srs_ik.kernels.algebra.vectors import norm
from srs_ik.kernels.chain.kinematics import pose_error
from srs_ik.kernels.chain.newton import CLOSED, LAST_STEP, LEFT, ROUNDING, load_system, longest, moved, pose_step
from srs_ik.kernels.curves import in_step
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.limb.branches import sine_of
from srs_ik.kernels.limb.goal import NO_SEED

MOST_STEPS = 600

CORRECTIONS = 12
"""Newton's steps back to the curve, at most."""

LONGEST_CORRECTION = 1.0
"""A longer step, rad, leads to no curve nearby."""

SHRUNK_AT_LAST = 64.0
"""Where joints are singular at once, steps to a curve halve: the last is shorter by this than one was, or no longer
than rounding makes it; if there is no curve ahead, it is not."""

BLURRED = 1e-2
"""By more than this, rad, no posture may be off by rounding."""

SHRUNK = 0.5
"""Steps back to the curve that shrink by less, where the pose is met, are rounding."""

SAME_CURVE = 4e-6
"""A posture this close to a curve, rad squared, lies on it."""

CURVE = 3
"""A curve: first row, the row behind the last, and whether it is closed (its last row then repeats the first)."""

CORNER = 1e-5
"""Where curves almost cross, one turns from one to the other in a corner too sharp for steps: it goes on so far behind
it, rad."""

SHARP = 1e-5
"""A corner's side is known where the curve has turned by more than this on the last step, rad."""

MOST_OBLIQUE = 4.0
"""It is no farther away there than so many times this distance across."""

ALMOST_CROSSED = 1e-4
"""There the Jacobian's smallest singular value is below this."""

FIRST_GUESS = (0.35, -0.25, 0.45, 0.15, 0.5, -0.4, 0.3)
"""Any direction: the null vector at a start is oriented afterwards."""


STRAIGHT_ON = 0.5
"""Squared cosine between a curve and the chord of a step: less, and the chord is taken."""


@kernel
def put(rows, n, x, q):
    """Append a sample whose way is not known; return the number of rows, which stays where there is no room."""
    return put_with(rows, n, x, q, NO_SEED)


@kernel
def put_with(rows, n, x, q, t):
    """Append a sample with its way, as `put`."""
    if n >= rows.shape[0]:
        return n
    in_step.put_on_way(rows, n, x, q, t)
    return n + 1


@kernel
def null_vector(J, near, A):
    """Unit null vector of J on the side of a direction, and the sign of its orientation (0 where J has lost rank)."""
    load_system(J, near, A)
    A[6, 7] = 1.0
    sign = solve_linear(A, 7)
    t = moved(NO_SEED, A, 1.0)
    size = math.sqrt(dot7(t, t))
    if sign == 0.0 or size == 0.0:
        return near, 0.0
    return along7(NO_SEED, 1.0 / size, t), sign


@kernel
def tangent_at(P, by, q):
    """The oriented null vector at a posture, and its sign (0 where the Jacobian has lost rank)."""
    pose_step(P, q, by.target.R, by.target.p, by.J)
    t, sign = null_vector(by.J, FIRST_GUESS, by.A)
    return along7(NO_SEED, sign, t), sign


@kernel
def way_at(P, by, q, way):
    """The way of a curve at a posture, and whether it has one; that which is known of it is given."""
    if dot7(way, way) > 0.5 and abs(sine_of(P, q, 2)) > in_step.TURNING_WRIST:
        return way, True
    t, sign = tangent_at(P, by, q)
    return t, sign != 0.0


@kernel
def vagueness(J, t, A):
    """How far aside of a curve, rad, a posture may be that meets its pose as well as floats tell."""
    load_system(J, t, A)
    for i in range(6):
        A[i, 7] = ROUNDING if i % 2 == 0 else -ROUNDING
    if solve_linear(A, 7) == 0.0:
        return math.inf
    d = moved(NO_SEED, A, 1.0)
    return math.sqrt(dot7(d, d))


@kernel
def correct(P, by, q, d, place):
    """Newton's method to the posture for the pose with d'q = place: q, whether it is met; J is left for it."""
    R, p, _ = by.target
    J, A = by.J, by.A
    error = 1.0
    last, longest_yet = math.inf, 0.0
    before = q
    for _ in range(CORRECTIONS):
        linear, angular = pose_step(P, q, R, p, J)
        off = place - dot7(d, q)
        error = max(norm(linear), norm(angular))
        load_system(J, d, A)
        for i in range(3):
            A[i, 7] = linear[i]
            A[i + 3, 7] = angular[i]
        A[6, 7] = off
        if solve_linear(A, 7) == 0.0:
            return q, error < 0.1 * CLOSED and abs(off) < CLOSED
        size = longest(A)
        if error < 0.1 * CLOSED and abs(off) < CLOSED and size > SHRUNK * last:
            return q, True
        longest_yet = max(longest_yet, size)
        if not size < LONGEST_CORRECTION:
            return q, False
        before = q
        q = moved(q, A, 1.0)
        last = size
        if size < LAST_STEP and error < LEFT:
            return q, True
    if error < LEFT and (last * SHRUNK_AT_LAST < longest_yet or last < min(BLURRED, vagueness(J, d, A))):
        # Its last step may have led away.
        position, orientation = pose_error(P, q, R, p)
        return (q, True) if max(position, orientation) < LEFT else (before, True)
    return q, False


@kernel
def end_at(P, by, q):
    """A posture with the way of its curve."""
    t, _ = tangent_at(P, by, q)
    return q, t


@kernel
def aside_of(P, by, end, chord):
    """How far aside of a chord the tangent at an end of it has led at its length; the end is a posture and its way.

    Nothing where the curve goes elsewhere. The way is found where it is not known.
    """
    t, _ = way_at(P, by, end[0], end[1])
    ahead, length2 = dot7(t, chord), dot7(chord, chord)
    if not ahead * ahead > STRAIGHT_ON * length2:
        return NO_SEED
    return along7(along7(NO_SEED, length2 / ahead, t), -1.0, chord)


@kernel
def arc_between(P, by, a, b, share):
    """The point at a share of the way between two postures on the cubic that has the ways of their curve at both.

    A chord is as far off as another curve may be that passes by.
    """
    chord = difference(a[0], b[0])
    left = 1.0 - share
    arc = along7(along7(a[0], share, chord), share * left * left, aside_of(P, by, a, chord))
    return along7(arc, -share * share * left, aside_of(P, by, b, chord))


@kernel
def between(P, by, a, b, share):
    """The posture of a curve between two, at a share of the way along their chord: q, whether it is met.

    Each of the two is given with the way of the curve, nothing if that is not known.
    """
    chord = difference(a[0], b[0])
    length = math.sqrt(dot7(chord, chord))
    if length == 0.0:
        return a[0], True
    d = along7(NO_SEED, 1.0 / length, chord)
    return correct(P, by, arc_between(P, by, a, b, share), d, dot7(d, a[0]) + share * length)


@kernel
def meet(P, by, chord, q, joint, angle):
    """The posture of a curve with a joint at an angle, by Newton from q: it, its share of a chord, whether met.

    The chord is given as its ends.
    """
    q, met = correct(P, by, q, only(joint, 1.0), angle)
    share, beside = in_step.share_beside(chord[0], chord[1], q)
    return q, share, met and beside


@kernel
def is_passed(P, by, a, b, share, q):
    """Whether a posture beside the way between two (`between`) is on their curve itself, not on another next to it."""
    there, met = between(P, by, a, b, share)
    off = difference(there, q)
    return met and dot7(off, off) < SAME_CURVE


@kernel
def is_known(P, by, q, t, rows, curves, count):
    """Whether a posture with the oriented null vector t lies on one of the curves."""
    for k in range(count):
        for i in range(int(curves[k, 0]), int(curves[k, 1]) - 1):
            if abs(short_way(q[0] - rows[i, 1])) > in_step.BEYOND or abs(short_way(q[4] - rows[i, 5])) > in_step.BEYOND:
                continue
            a, b = in_step.load_end(rows[i]), in_step.load_end(rows[i + 1])
            share = in_step.share_of_chord(a[0], b[0], q)
            if share < 2.0 and dot7(t, difference(a[0], b[0])) > 0.0 and is_passed(P, by, a, b, share, q):
                return True
    return False


@kernel
def strays(by, q, next_q, t, step, cosine):
    """Whether a step along a curve has led so far aside, more than is vague, that it is to another one."""
    made = difference(q, next_q)
    if in_step.is_along(made, step, t, cosine, in_step.SETTLED):
        return False
    vague = vagueness(by.J, t, by.A)
    return not in_step.is_along(made, step, t, cosine, vague * vague)


@kernel
def way_across(P, by, q, t):
    """The way across a null vector that floats tell worst, and by how much it is told worse than others; 0: none."""
    pose_step(P, q, by.target.R, by.target.p, by.J)
    load_system(by.J, t, by.A)
    for i in range(6):
        by.A[i, 7] = 1.0 if i % 2 == 0 else -1.0
    if solve_linear(by.A, 7) == 0.0:
        return t, 0.0
    s = moved(NO_SEED, by.A, 1.0)
    size = math.sqrt(dot7(s, s))
    return along7(NO_SEED, 1.0 / size, s), size


@kernel
def go_along(P, by, q, s, way):
    """The posture so far along a unit way from one, rad, and whether it is met."""
    return correct(P, by, along7(q, way, s), s, dot7(s, q) + way)


@kernel
def around_corner(P, by, q, t, way, turned_by):
    """Go on behind the corner of a curve that almost crosses another one: posture, null vector, whether it is there.

    At the corner the pose is kept to first order by the way t so far and by one across it, s: along s the curve goes on
    to the side to which it has turned on the last step, by `turned_by`.
    """
    s, size = way_across(P, by, q, t)
    side = dot7(turned_by, s)
    if size * ALMOST_CROSSED < 1.0 or abs(side) < SHARP:
        return q, t, False
    there, met = go_along(P, by, q, s, math.copysign(CORNER, way * side))
    made = difference(q, there)
    next_t, sign = null_vector(by.J, along7(NO_SEED, way, made), by.A)
    return there, next_t, met and sign > 0.0 and dot7(made, made) < (MOST_OBLIQUE * CORNER) ** 2


@kernel
def follow(P, by, q, t, way, rows, n):
    """Follow the curve through q along its oriented null vector t (way = 1.0), or against it (-1.0).

    Returns the rows in use, whether the curve has closed, and the last posture with its null vector.
    """
    first = q
    first_t = t
    n0 = n
    length = 0.0
    step = in_step.LONGEST_STEP
    turned_by = NO_SEED
    n = put_with(rows, n, length, q, t)
    for _ in range(MOST_STEPS):
        if n >= rows.shape[0]:
            break
        if step < in_step.SHORTEST_STEP:
            next_q, next_t, there = around_corner(P, by, q, t, way, turned_by)
            if not there:
                break
            made = difference(q, next_q)
            length += math.sqrt(dot7(made, made))
            q, t, step, turned_by = next_q, next_t, CORNER, NO_SEED
            n = put_with(rows, n, length, q, t)
            continue
        next_q, met = correct(P, by, along7(q, way * step, t), t, dot7(t, q) + way * step)
        if not met:
            step *= in_step.SHRINKAGE
            continue
        next_t, sign = null_vector(by.J, t, by.A)
        cosine = dot7(t, next_t)
        jumps = step > in_step.longest_across(P) and in_step.passes_two(P, q, next_q)
        turns = sign <= 0.0 or cosine < in_step.SMALLEST_COSINE
        if turns or jumps or strays(by, q, next_q, next_t, way * step, cosine):
            step *= in_step.SHRINKAGE
            continue
        if n - n0 > 2 and dot7(first_t, t) > in_step.SMALLEST_COSINE:
            share = in_step.share_of_chord(q, next_q, first)
            if share <= 1.0 and is_passed(P, by, (q, t), (next_q, next_t), share, first):
                return put_with(rows, n, length + share * step, first, first_t), True, q, t
        turned_by = difference(t, next_t)
        q = next_q
        t = next_t
        length += step
        n = put_with(rows, n, length, q, t)
        step = in_step.step_after(step, cosine, in_step.LONGEST_STEP)
    return n, False, q, t


@kernel
def reverse(rows, first, n):
    """Turn the samples of a curve around, in the rows first to n - 1."""
    length = rows[n - 1, 0]
    for i in range(first, n):
        rows[i, 0] = length - rows[i, 0]
    i = first
    j = n - 1
    while i < j:
        for c in range(in_step.SAMPLE):
            rows[i, c], rows[j, c] = rows[j, c], rows[i, c]
        i += 1
        j -= 1


@kernel
def extend_back(P, by, rows, curves, k, n):
    """Follow an open curve against its way from where it begins, and put that before it; rows in use.

    Around a corner it may come back to where it began: then that is all of it.
    """
    first, last = int(curves[k, 0]), int(curves[k, 1])
    q = in_step.load_sample(rows[first])
    t, sign = tangent_at(P, by, q)
    end, closed, _, _ = follow(P, by, q, t, -1.0, rows, n)
    if sign == 0.0 or end - n < 2:
        return n
    reverse(rows, n, end)
    curves[k, 0] = n
    if closed:
        curves[k, 2] = 1.0
    else:
        length = rows[end - 1, 0]
        for i in range(first + 1, last):
            q, t = in_step.load_sample(rows[i]), in_step.way_of_sample(rows[i])
            end = put_with(rows, end, length + rows[i, 0], q, t)
    curves[k, 1] = end
    return end


@kernel
def follow_through(P, by, q, t, rows, first):
    """Follow the whole curve through a posture, along its oriented null vector: rows in use, whether it is closed."""
    n, closed, end, t = follow(P, by, q, t, 1.0, rows, first)
    if not closed:
        # It ends where curves cross: all of it lies behind that end.
        n, closed, _, _ = follow(P, by, end, t, -1.0, rows, first)
        reverse(rows, first, n)
    return n, closed
