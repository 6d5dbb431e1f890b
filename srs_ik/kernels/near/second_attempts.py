"""Second attempts on a near limb, where Newton's method from the closed form did not close or broke the limits."""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.pointers import copy, keep, read7, row
from srs_ik.kernels.algebra.vectors import norm
from srs_ik.kernels.chain import newton
from srs_ik.kernels.chain.descent import THOROUGH, descend
from srs_ik.kernels.chain.kinematics import pose_error
from srs_ik.kernels.curves.follow import correct
from srs_ik.kernels.curves.lowest import cost_of_turn
from srs_ik.kernels.curves.outreach import is_almost_straight
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import limb
from srs_ik.kernels.layout.asked import Best, Goal, Setting
from srs_ik.kernels.limb.branches import NO_BRANCH, best_branch, branch_of, draw_to_branch, is_on_border
from srs_ik.kernels.limb.goal import OUTSIDE
from srs_ik.kernels.limb.in_line import ROUNDED
from srs_ik.kernels.limb.limits import turn_to_middle, violation
from srs_ik.kernels.limb.surface import EVERY_SPLIT, level_place, put_starts
from srs_ik.kernels.limb.triangle import elbow_side
from srs_ik.kernels.near.band import is_oblique, is_well_bent
from srs_ik.kernels.near.branch_search import close_starts, put_start
from srs_ik.kernels.near.many_singular import nearest_among_splits

MORE_STEPS = 80
"""Steps of Newton's method, which halves the error at best next to a singularity."""

ATTEMPTS = 9
"""Arm angles from which a given one is tried."""

ALMOST = 0.1
JITTERS = 100
"""A near limb that comes this close to a pose (m, rad) is tried from so many more postures around."""

STRETCHED = 1e-4
"""Sine of the bend of the elbow under which it may be on the line S-W."""

LINE_LOOKS = 25
LINE_STARTS = 320
"""Arm angles at which a posture with its elbow on the line S-W is looked for, and room for postures that are singular
elsewhere too, where many splits are looked at."""

ELBOW_ALONE = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)

FLAT = 4.0 * newton.ON_LINE
"""With the elbow bent by less than this, rad, it is on the line S-W, if it is not folded."""

ON_LIMIT = 1e-6
"""An elbow so close to a limit, rad, is on it where it is on the line S-W."""

NEAR_SINGULAR = 0.05
"""Sine of a middle angle under which a spherical joint or the elbow is close to singular, for a second attempt."""


@kernel
def bent(q, phase, side):
    """A middle angle, moved away from its phase (or the opposite of it) to its side if it is close."""
    if abs(math.sin(q - phase)) > NEAR_SINGULAR:
        return q
    inwards = 2.0 * NEAR_SINGULAR if math.cos(q - phase) > 0.0 else -2.0 * NEAR_SINGULAR
    return q + inwards if side == 0 else q - inwards


@kernel
def bend(P, q, branch):
    """A posture with elbow, shoulder and wrist moved away from their singularities, to the sides of a branch."""
    return (
        q[0],
        bent(q[1], P[limb.SHOULDER + limb.PHASE], (branch >> 1) & 1),
        q[2],
        bent(q[3], P[limb.STRAIGHT], branch >> 2),
        q[4],
        bent(q[5], P[limb.WRIST + limb.PHASE], branch & 1),
        q[6],
    )


@kernel
def put_turned(P, q, b, i, A, k):
    """Write the i-th start next to a posture that is bent to the sides of branch b into row k of A; how many there are.

    Near a singular shoulder or wrist the closed form fixes two joint angles of which the true chain knows little more
    than their sum. So the starts turn one against the other, and bend what is straight.
    """
    s = bend(P, q, b)
    turns_s = 6 if s[1] != q[1] else 1
    turns_w = 6 if s[5] != q[5] else 1
    against_s = -1.0 if math.cos(s[1] - P[limb.SHOULDER + limb.PHASE]) > 0.0 else 1.0
    against_w = -1.0 if math.cos(s[5] - P[limb.WRIST + limb.PHASE]) > 0.0 else 1.0
    ds = (i % turns_s) * math.pi / 3.0
    dw = (i // turns_s) * math.pi / 3.0
    put_start(A, k, (s[0] + ds, s[1], s[2] + against_s * ds), s[3], (s[4] + dw, s[5], s[6] + against_w * dw))
    return turns_s * turns_w


@kernel
def evaluate_again(P, target, psi, branch, goal, attempts, A):
    """Second attempt at an arm angle on a near limb, where Newton's method did not close: from many postures."""
    q, _, _ = best_branch(P, target.place, psi, branch, goal.seeded, goal.seed, goal.respect)
    best = Best(q, 2.0 * NO_BRANCH)
    for attempt in range(attempts):
        # At the arm angle itself, then from either side of it, farther and farther.
        from_psi = psi + (0.0 if attempt == 0 else (0.25 if attempt % 2 == 0 else -0.25) * ((attempt + 1) // 2))
        n = 0
        for b in range(8):
            q0, _, _ = best_branch(P, target.place, from_psi, b, False, goal.seed, False)
            i, starts = 0, 1
            while i < starts:
                starts = put_turned(P, q0, b, i, A, n % 8)
                i, n = i + 1, n + 1
                if n % 8 == 0 or (b == 7 and i == starts):
                    best = close_starts(P, target, psi, branch, goal, best, MORE_STEPS, A)
        if best.cost < OUTSIDE:
            break
    return best


@kernel
def random(state):
    """The next number in [-1, 1] of a linear congruential generator, and its state: the same ones in every run."""
    state = (state * 1103515245 + 12345) % 2147483648
    return state / 1073741824.0 - 1.0, state


@kernel
def jitter(q, state, turn, bend_by):
    """A posture with joints 1, 3, 5 and 7 moved by up to `turn` and those between them by up to `bend_by`, rad."""
    a, state = random(state)
    b, state = random(state)
    c, state = random(state)
    d, state = random(state)
    e, state = random(state)
    f, state = random(state)
    g, state = random(state)
    return (
        q[0] + turn * a,
        q[1] + bend_by * b,
        q[2] + turn * c,
        q[3] + bend_by * d,
        q[4] + turn * e,
        q[5] + bend_by * f,
        q[6] + turn * g,
    ), state


@kernel
def free_start(P, target, q, wanted, goal, J, A):
    """Free steps from a posture: q and its cost, more than any posture's if pose or wanted branch are not reached."""
    if goal.respect:
        q = newton.clipped(P, q)
    q, error = newton.close_free(P, q, target.R, target.p, goal.respect, MORE_STEPS, J, A)
    q, value = cost_of_turn(P, q, goal)
    if error > 10.0 * newton.CLOSED:
        return q, OUTSIDE * (2.0 + error)
    if wanted >= 0 and branch_of(P, q) != wanted:
        return q, OUTSIDE * 10.0
    return q, value


@kernel
def found_again(P, target, branch, goal, J, A):
    """A posture that curves from the closed form have passed by, by free steps from others around: q, branch, cost.

    None is looked for where the closed form tells every branch. Close to the edge of reach, the nearest exact limb may
    not reach a pose that the true one does.
    """
    best_q = goal.seed
    best = 0
    lowest = 2.0 * NO_BRANCH
    if is_well_bent(P, target.place) and not is_oblique(P):
        return best_q, best, lowest
    first = 0 if branch < 0 else branch
    last = 7 if branch < 0 else branch
    for attempt in range(2):
        for i in range(12):
            for b in range(first, last + 1):
                # Also from the closest posture of a branch that the nearest exact limb does not have here.
                q, _, _ = best_branch(P, target.place, i * math.pi / 6.0, b, goal.seeded, goal.seed, goal.respect)
                if attempt == 1:
                    q = bend(P, q, b)
                q, value = free_start(P, target, q, branch, goal, J, A)
                if value < lowest:
                    best_q, best, lowest = q, branch_of(P, q), value
        if lowest < OUTSIDE:
            return best_q, best, lowest
    if lowest < OUTSIDE * (2.0 + ALMOST):
        state = 1
        around = best_q
        for i in range(JITTERS):
            # A stretched arm may have to turn far about itself for a bend of a micrometre in another direction.
            turn = 0.02 if i % 3 == 0 else (0.3 if i % 3 == 1 else 2.0)
            q, state = jitter(around, state, turn, min(turn, 0.3))
            q, value = free_start(P, target, q, branch, goal, J, A)
            if value < lowest:
                best_q, best, lowest = q, branch_of(P, q), value
                if lowest < OUTSIDE:
                    break
    return best_q, best, lowest


@kernel
def is_on_line(P, q, place_):
    """Whether the elbow of a posture is on the line S-W of its pose, and so at every arm angle at once."""
    return norm(newton.elbow_across(P, q, place_[0])) < newton.ON_LINE * P[limb.FAR]


@kernel
def may_be_on_line(P, place_):
    """Whether the elbow of an almost exact limb may lie on the line S-W, where its curves turn too sharply."""
    return P[limb.IS_NEAR] != 0.0 and P[limb.MISS] < ROUNDED * P[limb.FAR] and is_almost_straight(P, place_)


@kernel
def hold_elbow(P, place_, respect, box):
    """Copy a limb to `box`, its elbow held straight or folded, and without other limits if they do not count."""
    copy(P, box, limb.SIZE)
    for j in range(7 if not respect else 0):
        box[limb.LOWER + j], box[limb.UPPER + j] = -math.inf, math.inf
    flat = turn_to_middle(P, 3, P[limb.STRAIGHT] + (0.0 if place_[2] > 0.0 else math.pi))
    if respect and violation(P, 3, flat) < ON_LIMIT:
        flat = min(max(flat, P[limb.LOWER + 3]), P[limb.UPPER + 3])
    box[limb.LOWER + 3], box[limb.UPPER + 3] = flat, flat
    return flat


@kernel
def on_line_from(limbs, by, q, goal):
    """The posture with the elbow on the line S-W next to one, and its cost; in the second limb the elbow is held."""
    P, box = limbs
    R, p, place_ = by.target
    closed, _ = correct(P, by, q, ELBOW_ALONE, q[3])
    closed, value = cost_of_turn(P, closed, goal)
    position, orientation = pose_error(P, closed, R, p)
    error = max(position, orientation)
    if error > newton.LEFT or value >= OUTSIDE:
        closed, error = newton.close_gently(box, newton.clipped(box, q), R, p, True, by.J, by.A)
        closed, value = cost_of_turn(P, closed, goal)
    return closed, (value if error < newton.LEFT and is_on_line(P, closed, place_) else 2.0 * NO_BRANCH)


@kernel
def stretched(P, target, psi, branch, goal, J, A):
    """A posture whose elbow is on the line S-W, and so at every arm angle at once, if there is any: q, branch, cost.

    Those are looked for first that the nearest exact limb has at an arm angle. With a seed, the nearest of them.
    """
    boxes = np.empty((1, limb.SIZE))
    box = row(boxes, 0)
    flat = hold_elbow(P, target.place, goal.respect, box)
    place_ = level_place(target.place)
    by = Setting(target, elbow_side(P, place_, 0), goal.respect, J, A)
    starts = np.empty((LINE_LOOKS + LINE_STARTS, 7))
    n = put_starts(P, place_, EVERY_SPLIT, starts, LINE_LOOKS)
    best, own, lowest = goal.seed, max(branch, 0), 2.0 * NO_BRANCH
    for i in range(n):
        if (lowest < OUTSIDE and not goal.seeded) or (goal.respect and violation(P, 3, flat) > 0.0):
            break
        q = read7(row(starts, i))
        if i < LINE_LOOKS:
            # What is found at one arm angle is found at all.
            at = psi if i == 0 else 2.0 * math.pi * i / (LINE_LOOKS - 1)
            q, _, _ = best_branch(P, place_, at, branch, goal.seeded, goal.seed, goal.respect)
        q, about = cost_of_turn(P, q, goal)
        if goal.seeded and about > lowest:
            continue
        q, value = on_line_from((P, box), by, (q[0], q[1], q[2], flat, q[4], q[5], q[6]), goal)
        if value < lowest and (branch < 0 or is_on_border(P, q, branch)):
            best, own, lowest = q, (branch if branch >= 0 else branch_of(P, q)), value
    keep(boxes)
    keep(starts)
    return best, own, lowest


@kernel
def nearest_on_line(P, target, psi, branch, goal, J, A):
    """The posture nearest to a seed whose elbow is on the line S-W: q, branch, cost."""
    boxes = np.empty((2, limb.SIZE))
    box, drawn = row(boxes, 0), row(boxes, 1)
    best = stretched(P, target, psi, branch, goal, J, A)
    flat = hold_elbow(P, target.place, goal.respect, box)
    # Curves of the true chain pass next to where the elbow is flat.
    lower, upper = flat - FLAT, flat + FLAT
    box[limb.LOWER + 3] = max(lower, min(P[limb.LOWER + 3], flat)) if goal.respect else lower
    box[limb.UPPER + 3] = min(upper, max(P[limb.UPPER + 3], flat)) if goal.respect else upper
    if best[2] < OUTSIDE and branch >= 0 and draw_to_branch(box, branch, best[0], drawn):
        copy(drawn, box, limb.SIZE)
    if best[2] < OUTSIDE:
        within = Goal(True, goal.seed, True)
        q, _, _ = nearest_among_splits(box, target, within, best)
        q, value = descend(box, q, target, within, THOROUGH, (J, A))
        if value < best[2] and is_on_line(P, q, target.place) and (branch < 0 or is_on_border(P, q, branch)):
            best = q, (branch if branch >= 0 else branch_of(P, q)), value
    keep(boxes)
    return best
