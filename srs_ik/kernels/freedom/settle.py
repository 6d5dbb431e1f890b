"""From a posture to the nearest one around it that meets a pose up to what that leaves free, inside the limits.

Sequential quadratic programming on the true chain: each step meets the pose to first order, holds joints on the limits
that they would pass and lets go of those that want to leave, and takes the bend of the constraints into account by
their second derivatives. So it converges quadratically, however far the seed is.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.joint_vectors import along7, apart, between, with_joint
from srs_ik.kernels.freedom.constraints import bends, equations, fill, leaves_cone, on_edge, price
from srs_ik.kernels.freedom.elimination import CONTRADICTION, GIVES, RHS, ROOM_ROW, SOFT
from srs_ik.kernels.freedom.system import solve_held
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.freedom import Liking
from srs_ik.kernels.limb.goal import NO_SEED

STEPS = 30
MAX_STEP = 0.5
"""Longest change of a joint in one step, rad."""

SETTLED = 1e-9
"""A step this short, rad, is the last one."""

MET = 1e-11
"""Errors of the pose, m and rad, that need no step."""

ALMOST = 0.1
"""Where the pose is missed by more, m and rad, a step goes the shortest way to it: a far seed would pull away from it.
Bends count only nearer: multipliers of a first guess say nothing."""

FAR, SLOWLY, PATIENCE = 0.03, 0.7, 9
"""A search whose pose is missed by more, m and rad, and after more steps than so many by more than that part of what it
was before, meets none."""

BLOCKED = 0.5
"""A step that leaves more than so much of what a pose is missed by, to first order, is kept from it by limits. A search
with two of them meets none."""

STIFFER = 4.0
STIFFEST = 256.0
"""Where a step is none to a minimum, the bend of the distance counts so many times more, and at most so many times."""

HELD_BACK, BENT = 1e-10, 3.0
"""With joints on limits, an equation that depends on others is left out where these leave no more than so much of it, m
and rad, or what the bends of the last step may leave: so many times its square."""

BARELY, STRICT, CALM = 1e-6, 1e-24, 1e-7
"""Where a roll is missed by less, m and rad, but by more than bends leave, equations that almost depend on others are
taken at their word from then on: where figures are rounded, a joint has to go far for the last of it. They give way by
the square of what is missed, and by the second weight at least. Joints stay on their limits, and a step shorter than
the third, rad, is the last one: rounding leaves no more."""

ON_LIMIT = 1e-12
"""A joint this close to a limit, rad, is on it."""

SHORTER = 0.3
CLOSE_BY = 0.1
"""Steps longer than this, rad, have to be worth it, and are cut by that factor where not."""

STUCK = 0.05
"""A step shorter than so much of what a pose is missed by, rad by m or rad, meets none: limits stand in the way."""

LEFT = 1.2
"""Where the pose is almost met, a search comes nearer to the seed by at most so many times its step, uncut."""

SAME = 0.1
"""A step that leads so close to a posture that is known, rad, and is longer than that, leads there."""

NO_RIVAL = 1e300
NO_POSTURE = (math.inf, math.inf, math.inf, math.inf, math.inf, math.inf, math.inf)
"""Cost of a rival, and its posture, where there is none."""

ROUNDS = 12
"""Most changes of the set of joints that are held, in a step."""

EVEN = (1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0)
"""Weights by which all joints count the same."""

ALL = 0b1111111
"""All joints, as a bit set."""

NO_FORCE = (0.0, 0.0, 0.0, 0.0, 0.0)


@kernel
def pull(K, m, d, forces, j):
    """Slope of the Lagrangian by a joint, after a step."""
    s = -K[j, RHS]
    for i in range(7):
        s += K[j, i] * d[i]
    for r in range(m):
        s += K[7 + r, j] * forces[r]
    return s


@kernel
def left_by(K, m, d):
    """How far a step misses the equations, to first order."""
    most = 0.0
    for r in range(m):
        left = -K[7 + r, RHS]
        for j in range(7):
            left += K[7 + r, j] * d[j]
        most = max(most, abs(left))
    return most


@kernel
def moves(d):
    """Whether a step is not the last one."""
    return max(max(abs(d[0]), abs(d[1]), abs(d[2])), max(abs(d[3]), abs(d[4]), abs(d[5]), abs(d[6]))) >= SETTLED


@kernel
def freed(K, m, q, d, forces, held, liking):
    """The joint of those that want most to leave its limit, or -1."""
    best, most = -1, 1e-12
    for j in range(7):
        if (held >> j) & 1 == 1 and liking.upper[j] > liking.lower[j]:
            slope = pull(K, m, d, forces, j)
            at_lower = q[j] + d[j] < 0.5 * (liking.lower[j] + liking.upper[j])
            if liking.lower[j] == -math.inf:
                at_lower = False
            elif liking.upper[j] == math.inf:
                at_lower = True
            want = -slope if at_lower else slope
            if want > most:
                best, most = j, want
    return best


@kernel
def bounded_step(K, M, m, q, joints, liking):
    """The step that keeps the limits: it, multipliers, joints on a limit, and whether it may lead to a minimum.

    Joints are those on a limit to begin with, and those that are not let go of, as bit sets.
    """
    d = NO_SEED
    forces = NO_FORCE
    low, high = along7(liking.lower, -1.0, q), along7(liking.upper, -1.0, q)
    bound = between(NO_SEED, low, high)
    (held, let_go), down = joints, True
    for _ in range(ROUNDS):
        d, forces, to_minimum = solve_held(K, M, m, held, bound)
        # What a step to a saddle passes says nothing of the joints to be held; of a roll, it is turned down.
        down = to_minimum and (down or m == 5)
        worst, most = -1, 1e-14
        for j in range(7):
            passed = max(low[j] - d[j], d[j] - high[j])
            if (held >> j) & 1 == 0 and passed > most:
                worst, most = j, passed
        if worst >= 0:
            bound = with_joint(bound, worst, low[worst] if d[worst] < low[worst] else high[worst])
            held |= 1 << worst
            continue
        if let_go and moves(d):
            break
        # One joint that may leave its limit may not move all the same, where equations depend on each other.
        j = freed(K, m, q, d, forces, held & ~let_go, liking)
        if j < 0:
            break
        held &= ~(1 << j)
        let_go |= 1 << j
    return between(d, low, high), forces, held, down


@kernel
def led_to(liking, q):
    """The same liking, where searches have come to rest at a posture, or at none yet: the seed itself."""
    return Liking(liking.posture, liking.weights, liking.lower, liking.upper, liking.rival, q)


@kernel
def distance(q, liking):
    """Weighted sum of squared differences."""
    total = 0.0
    for j in range(7):
        total += liking.weights[j] * (q[j] - liking.posture[j]) ** 2
    return total


@kernel
def part_way(a, share, b):
    """Multipliers after a share of a step."""
    return (
        a[0] + share * (b[0] - a[0]),
        a[1] + share * (b[1] - a[1]),
        a[2] + share * (b[2] - a[2]),
        a[3] + share * (b[3] - a[3]),
        a[4] + share * (b[4] - a[4]),
    )


@kernel
def beaten(q, way, liking):
    """Whether a posture is no rival any more: even so much nearer, rad."""
    return math.sqrt(distance(q, liking)) > math.sqrt(liking.rival) + way


@kernel
def comes_to_rival(q, size, liking):
    """Whether a search whose last step was so short comes to the posture that is known."""
    off = apart(q, liking.rival_posture)
    return liking.rival < NO_RIVAL and size > off and off < SAME


@kernel
def settle(P, q, pose, freedom, liking, desk):
    """The nearest posture around one: q, distance, error of the pose (m, rad), and whether it came to rest.

    Args:
        P: packed limb.
        q: posture to start from.
        pose: rotation and position.
        freedom: what the pose leaves free.
        liking: what is nearest, and the limits.
        desk: work space.
    """
    K, M, J = desk.system, desk.copy, desk.J
    q = between(q, liking.lower, liking.upper)
    forces, held = NO_FORCE, 0
    error, size, at_rest, leads, strict = math.inf, math.inf, False, False, False
    known, slow, blocked, missed = 0, 0, 0, math.inf
    before, step, worth = q, NO_SEED, math.inf
    last, asked, share, radius, restoring = NO_FORCE, NO_FORCE, 1.0, MAX_STEP, False
    for k in range(STEPS):
        m, error, turns = equations(P, q, pose, freedom, forces, desk)
        m = on_edge(m, known, forces)
        leads = (k == 0 and error < MET and distance(q, liking) < liking.rival) or (k > 0 and leads)
        if error < MET and size < (CALM if strict else SETTLED):
            at_rest = True
            break
        slow += 1 if error > max(FAR, SLOWLY * missed) else 0
        missed = error
        if slow > PATIENCE or (restoring and error > worth and size <= CLOSE_BY):
            break
        value = error if restoring else distance(q, liking) + price(forces) * error
        if value > worth and size > CLOSE_BY:
            # Too far for what is known of the bends.
            step = along7(NO_SEED, SHORTER, step)
            size *= SHORTER
            share *= SHORTER
            radius = size
            forces = part_way(last, share, asked)
            q = along7(before, 1.0, step)
            continue
        radius = min(2.0 * radius, MAX_STEP)
        left = max(HELD_BACK, BENT * size * size)
        strict = strict or (freedom.cone == 0.0 and left < error < BARELY)
        K[ROOM_ROW, RHS] = 0.0 if strict else min(left, CONTRADICTION)
        K[ROOM_ROW, GIVES] = max(error * error, STRICT) if strict else SOFT
        curve = bends(m, forces, turns, freedom.cone)
        near = error < ALMOST
        curved = near and known == m
        pull, plain = 1.0 if near else 0.0, 1.0
        fill(J, K, q, liking, curve, (1.0 if curved else 0.0, plain, pull))
        joints = held, ALL if strict else 0
        step, asked, on, down = bounded_step(K, M, m, q, joints, liking)
        while curved and plain < STIFFEST and not down:
            # Not towards a minimum: stiffer, it is downhill along the equations, and no farther than they bend.
            plain = STIFFER * plain
            fill(J, K, q, liking, curve, (1.0, plain, pull))
            step, asked, on, down = bounded_step(K, M, m, q, joints, liking)
        if m == 3 and leaves_cone(K, freedom, step):
            m = 4
            step, asked, on, down = bounded_step(K, M, m, q, joints, liking)
        blocked += 1 if error > FAR and left_by(K, m, step) > BLOCKED * error else 0
        if blocked > 1:
            break
        last = forces if known == m else asked
        known = m if near else 0
        restoring = not near
        worth = distance(q, liking) + price(asked) * error if near else error
        size, share = 0.0, 1.0
        for j in range(7):
            size = max(size, abs(step[j]))
        if error > MET and size < STUCK * error:
            break
        way = LEFT * size
        if size > radius:
            share = radius / size
            step = along7(NO_SEED, share, step)
            size = radius
        forces = part_way(last, share, asked)
        before = q
        q = between(along7(q, 1.0, step), liking.lower, liking.upper)
        held = on & at_limits(q, liking)
        if near and (beaten(q, way, liking) or (not leads and comes_to_rival(q, size, liking))):
            return q, math.inf, math.inf, False
    if not at_rest:
        _, error, _ = equations(P, q, pose, freedom, forces, desk)
    return q, distance(q, liking), error, at_rest


@kernel
def onto_pose(P, q, pose, freedom, liking, desk):
    """The posture on a pose that is nearest to one almost on it, inside the limits: it, and what it misses."""
    here = Liking(q, EVEN, liking.lower, liking.upper, NO_RIVAL, q)
    q, _, error, _ = settle(P, q, pose, freedom, here, desk)
    return q, error


@kernel
def at_limits(q, liking):
    """The joints on a limit, as a bit set."""
    bits = 0
    for j in range(7):
        if q[j] <= liking.lower[j] + ON_LIMIT or q[j] >= liking.upper[j] - ON_LIMIT:
            bits |= 1 << j
    return bits
