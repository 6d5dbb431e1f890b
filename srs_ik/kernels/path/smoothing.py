"""A path made the best of its kind: all arm angles moved at once, by Newton's method.

Each posture moves with its own arm angle alone, so a step of Gauss and Newton is one tridiagonal system for the whole
path, with one more row and column where all steps share a bound. Arm angles on an end of their strip that want to go
beyond it stay there (projected as by Bertsekas 1982).
"""

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import along7, largest, store7
from srs_ik.kernels.algebra.lanes import ALL, LANES, as_bits, as_mask, gather, scatter, where
from srs_ik.kernels.algebra.pointers import keep, read7, row
from srs_ik.kernels.chain.eight import put_eight, put_some, take_eight
from srs_ik.kernels.chain.newton_eight import largest as largest_of
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import IS_NEAR, LIMITED
from srs_ik.kernels.layout.path import LARGEST, SLOWEST, SQUARES, Line, System
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.path.corridor import ON_LIMIT_OF_CURVE, SHORTENED, beside, moving_rates, posture_at, stop_of
from srs_ik.kernels.path.edges import (
    CROSS,
    GRADIENT,
    OUTSIDE,
    TERMS,
    WEIGHT,
    bound_of,
    value_of,
    write_steps,
    write_terms,
)
from srs_ik.kernels.path.followed import ON_LIMIT, eight_followed, eight_rates
from srs_ik.kernels.path.splits import along_split, split_of, split_room
from srs_ik.kernels.pose.moved import eight_poses, moved_eight, ways_of_eight, within

SWEEPS = 24
"""Most steps of a path."""

LONGEST_MOVE = 0.25
"""Longest move of a joint in one step, rad."""

ENOUGH_OF_WEIGHT = 0.02
"""With a barrier, a step that gains less of its weight for each step of the path is the last one."""

SLOWEST_GAINS = 0.98
"""Gains shrink to this part of the one before at most."""

FASTEST = 1e5
"""Joint rates above this, rad/rad, belong to a posture next to a singularity: its arm angle stays."""

ON_END = 1e-9

LEAST_PART = 0.1
"""Whoever can go less than this part of its way to the end of its strip is held ..."""

HOLDS = 3
"""... and the others asked again, so often at most."""

HALVINGS = 5
"""A step that does not gain is made shorter so often, before all is damped."""

MOST_DAMPING = 1e2


@kernel
def factor(diagonal, next_to, shares, n):
    """Factor a symmetric tridiagonal matrix: its diagonal in place, and by how much of each row the next one falls."""
    for i in range(1, n):
        shares[i] = next_to[i - 1] / diagonal[i - 1]
        diagonal[i] -= shares[i] * next_to[i - 1]


@kernel
def solve_factored(diagonal, next_to, shares, x, n):
    """Solve with such a factored matrix; x holds the right-hand side, then the solution."""
    for i in range(1, n):
        x[i] -= shares[i] * x[i - 1]
    x[n - 1] /= diagonal[n - 1]
    for i in range(n - 2, -1, -1):
        x[i] = (x[i] - next_to[i] * x[i + 1]) / diagonal[i]


@kernel
def assemble(chain, first, aim, steps, t, rate, system):
    """Write the system of a step for the arm angles of a path with rates (n, 7), steps counting from a first one.

    Returned is the corner below its border.
    """
    n = chain.shape[0]
    terms = system.terms
    for c in range(n):
        system.diagonal[c] = 1e-12
        system.next_to[c] = 0.0
        system.move[c] = 0.0
        system.border[c] = 0.0
    corner = 0.0
    # By barriers of the largest step, a first posture that its bound holds a little ends at better ones more often.
    for c in range(0 if aim.kind == LARGEST else first, n):
        bound = bound_of(aim, steps, c, c + 1) if aim.kind == SLOWEST else t
        by_bound = write_terms(aim, chain, steps, c, bound, terms)
        if aim.kind == LARGEST:
            corner += by_bound
        bend = -1.0 / by_bound if aim.kind == SLOWEST else 0.0
        aa, ab, bb, ua, ub, ga, gb = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for j in range(7):
            a = rate[chain[c - 1], j] if c > 0 else 0.0
            b = rate[chain[c], j]
            w = terms[WEIGHT, j]
            aa += w * a * a
            ab += w * a * b
            bb += w * b * b
            ua += terms[CROSS, j] * a
            ub += terms[CROSS, j] * b
            ga += terms[GRADIENT, j] * a
            gb += terms[GRADIENT, j] * b
        system.diagonal[c] += bb + bend * ub * ub
        system.move[c] -= gb
        system.border[c] += ub
        if c > 0:
            system.diagonal[c - 1] += aa + bend * ua * ua
            system.next_to[c - 1] -= ab + bend * ua * ub
            system.move[c - 1] += ga
            system.border[c - 1] -= ua
    return corner


@kernel
def room_of(P, course, line, i):
    """How far the posture of a pose may move: back (negative or zero) and forth, to the ends of its strip or split."""
    split, is_singular = split_of(P, row(line.q, i))
    if is_singular:
        return split_room(P, row(line.q, i), split)
    return course.bounds[i, 0] - line.psi[i], course.bounds[i, 1] - line.psi[i]


@kernel
def hold(P, course, line, move, rate):
    """Take the rates of postures that want to pass the ends of their strips; whether there are any."""
    some = False
    for c in range(course.chain.shape[0]):
        i = course.chain[c]
        back, forth = room_of(P, course, line, i)
        if (back >= -ON_END and move[c] < 0.0) or (forth <= ON_END and move[c] > 0.0):
            some = True
            store7(row(rate, i), 0, NO_SEED)
    return some


@kernel
def solve_system(system, corner, damping, n):
    """How far all arm angles move, into `system.move`; the matrix and its border are used up."""
    for c in range(n):
        system.diagonal[c] *= 1.0 + damping
    shares = system.shares
    factor(system.diagonal, system.next_to, shares, n)
    solve_factored(system.diagonal, system.next_to, shares, system.move, n)
    if corner > 0.0:
        above, below = 0.0, corner
        border = system.spare
        border[:] = system.border
        solve_factored(system.diagonal, system.next_to, shares, system.border, n)
        for c in range(n):
            above -= border[c] * system.move[c]
            below -= border[c] * system.border[c]
        if below > 0.0:
            for c in range(n):
                system.move[c] -= system.border[c] * above / below


@kernel
def write_rate(P, course, line, rate, i, space):
    """Joint rates of a posture with its arm angle, or along its split, zero where they cannot be used."""
    store7(row(rate, i), 0, NO_SEED)
    if not course.fixed[i]:
        here = posture_at(line, i)
        v, usable = split_of(P, here.q)
        if not usable:
            v, usable = moving_rates(P, stop_of(course, i), here, space.J, space.A)
        if usable and largest(v) < FASTEST:
            store7(row(rate, i), 0, v)


@kernel
def rates_of_eight(P, sides, q):
    """Joint rates of eight poses with their arm angles, or along their curves, and as bits, which are clear cut."""
    if P[IS_NEAR] != 0.0:
        return ways_of_eight(P, sides, q)
    return eight_rates(P, sides, q)


@kernel
def write_rates(P, course, line, rate, space):
    """`write_rate` for all postures of a path, those of eight poses in a row in step."""
    n = line.psi.shape[0]
    if n < LANES:
        for c in range(course.chain.shape[0]):
            write_rate(P, course, line, rate, course.chain[c], space)
        return
    for begin in range(0, n, LANES):
        first = min(begin, n - LANES)
        t, there = rates_of_eight(P, row(course.sides, first), take_eight(row(line.q, first), 7))
        put_eight(row(rate, first), 7, ALL, t)
        for k in range(LANES):
            if course.fixed[first + k] or not there >> k & 1:
                write_rate(P, course, line, rate, first + k, space)


@kernel
def move_one(P, course, line, rate, far, moved, i, space):
    """Write a posture with its arm angle moved on, as far as limits let it."""
    here = posture_at(line, i)
    q, there = here.q, here.psi
    if far != 0.0:
        v = read7(row(rate, i))
        _, is_singular = split_of(P, here.q)
        if is_singular:
            back, forth = split_room(P, here.q, v)
            q, _ = along_split(P, here.q, v, min(max(far, back), forth))
        else:
            q, there, _ = beside(P, stop_of(course, i), here, (v, far, 4.0 * LONGEST_MOVE), space.J, space.A)
    moved.psi[i] = there
    store7(row(moved.q, i), 0, q)


@kernel
def eight_beside(P, course, first, q, moves, psi):
    """The postures of eight poses moved on: these, arm angles, and as bits, which are clear cut and inside limits."""
    if P[IS_NEAR] != 0.0:
        there, met = moved_eight(P, eight_poses(row(course.sides, first)), q, moves)
        inside, kept = within(P, there, ON_LIMIT_OF_CURVE)
        return inside, psi + moves[1], met, kept
    low, high = gather(row(course.bounds, first), 0, 2), gather(row(course.bounds, first), 1, 2)
    angle = psi + moves[1]
    angle = where(angle < low, low, where(angle > high, high, angle))
    there, met = eight_followed(P, row(course.sides, first), angle, q)
    inside, kept = within(P, there, ON_LIMIT)
    return inside, angle, met, kept


@kernel
def move_eight(P, course, line, rate, far, moved, first, space):
    """`move_one` for eight poses in step; those next to singular postures go by themselves."""
    q, psi = take_eight(row(line.q, first), 7), gather(row(line.psi, first), 0, 1)
    v, size = take_eight(row(rate, first), 7), gather(row(far, first), 0, 1)
    put_eight(row(moved.q, first), 7, ALL, q)
    scatter(row(moved.psi, first), 0, 1, psi)
    left, failed = as_bits(abs(size) > 0.0), 0
    for _ in range(SHORTENED):
        there, angle, met, inside = eight_beside(P, course, first, q, (v, size), psi)
        good = inside & as_bits(largest_of(along7(there, -1.0, q)) < 4.0 * LONGEST_MOVE)
        put_eight(row(moved.q, first), 7, left & met & good, there)
        put_some(row(moved.psi, first), 0, 1, as_mask(left & met & good), angle)
        failed |= left & ~met
        left &= met & ~good
        if left == 0:
            break
        size = 0.5 * size
    for k in range(LANES):
        if failed >> k & 1:
            move_one(P, course, line, rate, far[first + k], moved, first + k, space)


@kernel
def move_all(P, course, line, rate, move, moved, space):
    """`move_one` for all postures of a path, those of eight poses in a row in step."""
    n = line.psi.shape[0]
    far = np.zeros(n)
    for c in range(course.chain.shape[0]):
        i = course.chain[c]
        fastest = largest(row(rate, i))
        if fastest > 0.0 and move[c] != 0.0:
            far[i] = math.copysign(min(abs(move[c]), LONGEST_MOVE / fastest), move[c])
    if n < LANES:
        for c in range(course.chain.shape[0]):
            move_one(P, course, line, rate, far[course.chain[c]], moved, course.chain[c], space)
        return
    for first in range(0, n, LANES):
        move_eight(P, course, line, rate, far, moved, min(first, n - LANES), space)
    keep(far)


@kernel
def hold_beyond(P, course, line, move, rate):
    """Take the rates of postures that can go less than a part of their way to the end of their strip; are there any?"""
    some = False
    for c in range(course.chain.shape[0]):
        i = course.chain[c]
        back, forth = room_of(P, course, line, i)
        room = forth if move[c] > 0.0 else -back
        if abs(move[c]) > ON_END and room < LEAST_PART * abs(move[c]) and largest(row(rate, i)) > 0.0:
            some = True
            store7(row(rate, i), 0, NO_SEED)
    return some


@kernel
def direct(P, course, line, aim, problem, damping):
    """Write how far all arm angles move in a step into `system.spare`.

    `problem` are the steps, the first of them that counts, the bound, rates and system.
    """
    steps, first, t, rate, system = problem
    chain = course.chain
    n = chain.shape[0]
    for _ in range(HOLDS):
        corner = assemble(chain, first, aim, steps, t, rate, system)
        solve_system(system, corner, damping, n)
        if not hold_beyond(P, course, line, system.move, rate):
            break
    # Together they go as far as the fastest one may: each by itself, they would part.
    part = 1.0
    if aim.kind != SQUARES:
        for c in range(n):
            part = min(part, LONGEST_MOVE / max(abs(system.move[c]) * largest(row(rate, chain[c])), LONGEST_MOVE))
    for c in range(n):
        system.spare[c] = part * system.move[c]


@kernel
def smooth(family, course, line, start, aim, settings, space):
    """Move the postures of a path, in place, so that what is aimed at becomes least; see `corridor`. Returns it."""
    P = row(family, LIMITED)
    chain = course.chain
    n = chain.shape[0]
    first = 0 if start.shape[0] > 0 else 1
    rate = np.zeros(line.q.shape)
    moved = Line(line.q.copy(), line.psi.copy(), line.branch)
    steps = np.empty((n, 7))
    system = System(np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty((TERMS, 7)))
    write_steps(chain, start, settings, line.q, steps)
    lowest, t = value_of(aim, chain, steps, first)
    damping, gain_before, ratio_before = 0.0, 0.0, SLOWEST_GAINS
    for _ in range(SWEEPS):
        if lowest == OUTSIDE or damping > MOST_DAMPING:
            break
        write_steps(chain, start, settings, line.q, steps)
        write_rates(P, course, line, rate, space)
        assemble(chain, first, aim, steps, t, rate, system)
        hold(P, course, line, system.move, rate)
        direct(P, course, line, aim, (steps, first, t, rate, system), damping)
        gain = 0.0
        for _ in range(HALVINGS):
            move_all(P, course, line, rate, system.spare, moved, space)
            write_steps(chain, start, settings, moved.q, steps)
            total, t_moved = value_of(aim, chain, steps, first)
            if total < lowest:
                gain = lowest - total
                lowest, t = total, t_moved
                line.q[:] = moved.q
                line.psi[:] = moved.psi
                break
            for c in range(n):
                system.spare[c] *= 0.5 if aim.kind == SQUARES else 0.3
        if gain == 0.0:
            damping = max(10.0 * damping, 0.1)
            continue
        damping *= 0.1
        # One small gain may stand before many as small.
        ratio = min(gain / gain_before, SLOWEST_GAINS) if gain_before > 0.0 else SLOWEST_GAINS
        shrunk = max(ratio, ratio_before)
        gain_before, ratio_before = gain, ratio
        left, enough = gain * shrunk / (1.0 - shrunk), aim.weight * lowest
        if aim.kind != SQUARES:
            left, enough = gain, ENOUGH_OF_WEIGHT * n * aim.weight
        if left < enough:
            break
    return lowest
