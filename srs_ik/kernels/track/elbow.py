"""Where the elbow goes while the tip follows its target: a plan for the pose a while ahead.

Of the postures that reach that pose inside the limits, the plan is the one that is best by the way to it, the room that
is left to the limits, and what the user asks of the elbow. The joints go straight towards it as far as the target
leaves them the choice, so that the elbow moves before a limit or a singular posture comes. On a near limb the plan is
that of its nearest exact limb: it says where to go, and every step is taken on the true chain.
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import along7, short_way
from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.chain.newton import arm_angle
from srs_ik.kernels.exact.farthest import branch_at
from srs_ik.kernels.exact.intervals import find_intervals
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import MAX_PIECES
from srs_ik.kernels.layout.limb import LOWER, PHASE, SHOULDER, STRAIGHT, UPPER, WRIST
from srs_ik.kernels.layout.track import (
    AHEAD,
    ANGLE,
    ANGLE_WANTED,
    ELBOW,
    GOAL,
    GOAL_RATE,
    HAS_FREE,
    KEEP,
    PERIOD,
    PLAN,
    PLAN_LEFT,
    ROTATION,
    SPEED,
    TICK,
)
from srs_ik.kernels.limb.branches import branch_of
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE
from srs_ik.kernels.limb.poses import read7
from srs_ik.kernels.limb.triangle import elbow_side, place
from srs_ik.kernels.optimum.objectives import objective
from srs_ik.kernels.track.closest import minus
from srs_ik.kernels.track.elsewhere import nearest_in, way_between
from srs_ik.kernels.track.freedom import shown_at, turned_about
from srs_ik.kernels.track.target import load_pace, load_pose, moved_on

EVERY = 4
"""Updates from one plan to the next."""

STEP = 0.12
STEPS = 3
"""Arm angles are compared this far apart, rad, and so many on either side of the present one."""

NEXT = 0.3
"""Another branch is looked at, too, where the sine of the joint that it mirrors is below this."""

ROOM = 0.3
"""A joint closer to its limit than this, rad, has the plan cost more."""

PRICE = 0.2
"""What a joint on its limit costs; a joint that has to move at its largest velocity costs 1."""

PULL = 30.0
"""What a radian away from the arm angle that is asked for costs, squared."""

BUSY = 0.1
"""The room to the limits counts fully where a joint moves with this share of its largest velocity: an arm rests."""

TOO_FAR = 0.1
"""A pose this far out of reach, metres, is no plan."""

SHARE = 0.4
"""Share of the largest velocities that the elbow may take for itself."""

OFF = 0.1
"""A near limb is off its nearest exact one by less than this, rad, where the plan is of use."""

ROLL = 0.12
"""Turns that the target leaves free are looked at this far on either side of the present one, rad."""

NO_PLAN = 1e300


@kernel
def busyness(S, C):
    """0 where the goal is at rest, 1 where a joint of it moves at a good pace."""
    most = 0.0
    for j in range(7):
        most = max(most, abs(S[GOAL_RATE + j]) / C[SPEED + j])
    return min(most / BUSY, 1.0)


@kernel
def price(P, C, q, from_q, price_of_room):
    """What a posture costs: squared velocities on the way to it, by the largest ones, and joints close to a limit."""
    total = 0.0
    for j in range(7):
        total += ((q[j] - from_q[j]) / (C[SPEED + j] * C[AHEAD])) ** 2
        room = min(q[j] - P[LOWER + j], P[UPPER + j] - q[j])
        if room < ROOM:
            total += price_of_room * (1.0 - room / ROOM) ** 2
    return total


@kernel
def vertex(below, middle, above):
    """Where a parabola through three values a step apart is least, in steps from the middle one; at most one."""
    bend = above - 2.0 * middle + below
    slope = 0.5 * (above - below)
    if bend > abs(slope):
        return -slope / bend
    return -1.0 if slope > 0.0 else (1.0 if slope < 0.0 else 0.0)


@kernel
def downhill(P, C, task, q, place_, psi, J):
    """How far an objective falls with the arm angle, rad: to the end of a parabola, or a step."""
    kind, branch = int(C[ELBOW]), branch_of(P, q)
    side = elbow_side(P, place_, branch >> 2)
    below, one = branch_at(P, side, psi - STEP, branch, True, q, True)
    middle, two = branch_at(P, side, psi, branch, True, q, True)
    above, three = branch_at(P, side, psi + STEP, branch, True, q, True)
    if max(one, two, three) >= OUTSIDE:
        return 0.0
    return STEP * vertex(
        objective(P, kind, task, below, J), objective(P, kind, task, middle, J), objective(P, kind, task, above, J)
    )


@kernel
def wish(P, C, task, q, place_, J):
    """The arm angle of a posture, how far the elbow should go by what is asked of it, rad, and how much that counts."""
    psi = arm_angle(P, q, place_[0], place_[1])
    if C[ELBOW] == KEEP:
        return psi, 0.0, 0.0
    way = short_way(C[ANGLE_WANTED] - psi) if C[ELBOW] == ANGLE else downhill(P, C, task, q, place_, psi, J)
    return psi, min(max(way, -STEPS * STEP), STEPS * STEP), PULL


@kernel
def may_mirror(P, branch, mirrored, q):
    """Whether another branch is close by: each joint that it mirrors is almost singular, and the elbow is the same."""
    change = branch ^ mirrored
    if change & 4 and abs(math.sin(q[3] - P[STRAIGHT])) > NEXT:
        return False
    if change & 2 and abs(math.sin(q[1] - P[SHOULDER + PHASE])) > NEXT:
        return False
    return not (change & 1 and abs(math.sin(q[5] - P[WRIST + PHASE])) > NEXT)


@kernel
def offer(P, C, side, branch, ahead, given):
    """A posture of a branch at an arm angle, and its price; `ahead` is the way there from the present one, rad."""
    q, psi, (way, pull, room) = given
    there, value = branch_at(P, side, psi + ahead, branch, True, q, True)
    if value >= OUTSIDE:
        return there, NO_PLAN
    return there, price(P, C, there, q, room) + pull * (ahead - way) ** 2


@kernel
def best_in(P, C, side, branch, given):
    """The best posture of a branch at arm angles around the present one, and its price."""
    best, least, at = given[0], NO_PLAN, 0
    last = below = above = NO_PLAN
    for k in range(-STEPS, STEPS + 1):
        there, total = offer(P, C, side, branch, STEP * k, given)
        if at == k - 1 and least < NO_PLAN:
            above = total
        if total < least:
            best, least, at = there, total, k
            below, above = last, NO_PLAN
        last = total
    if max(below, above) < NO_PLAN:
        there, total = offer(P, C, side, branch, STEP * (at + vertex(below, least, above)), given)
        if total < least:
            best, least = there, total
    return best, least


@kernel
def best_near(P, C, place_, given):
    """The best posture of a pose at arm angles around the present one, in the branches close by: it, and its price."""
    q = given[0]
    branch = branch_of(P, q)
    best, least = q, NO_PLAN
    for elbow in range(2):
        if elbow != branch >> 2 and not may_mirror(P, branch, branch ^ 4, q):
            continue
        side = elbow_side(P, place_, elbow)
        for other in range(4 * elbow, 4 * elbow + 4):
            if other == branch or may_mirror(P, branch, other, q):
                there, total = best_in(P, C, side, other, given)
                if total < least:
                    best, least = there, total
    return best, least


@kernel
def plan(P, S, C, task, J):
    """Plan for the pose a while ahead, with the arm stretched where that is just out of reach."""
    S[PLAN_LEFT] = 0.0
    q = read7(row(S, GOAL))
    R, p = load_pose(S, ROTATION)
    R = shown_at(P, C, q, R)
    v, w = load_pace(S)
    here = place(P, R, p)
    R, p = moved_on(R, p, v, w, C[AHEAD])
    place_ = place(P, R, p)
    if abs(place_[5]) > TOO_FAR:
        return
    branch = branch_of(P, q)
    psi, way, pull = wish(P, C, task, q, here, J)
    base, _ = branch_at(P, elbow_side(P, here, branch >> 2), psi, branch, True, q, True)
    off = minus(q, base)
    if way_between(q, base) > OFF:
        base, off = q, NO_SEED
    room = PRICE * busyness(S, C)
    best, least = best_near(P, C, place_, (base, psi, (way, pull, room)))
    if C[HAS_FREE] == 1.0:
        for side in range(2):
            turned = turned_about(C, R, ROLL if side == 0 else -ROLL)
            there, total = best_near(P, C, place(P, turned, p), (base, psi, (way, pull, room)))
            if total < least:
                best, least = there, total
    if least == NO_PLAN:
        # No posture close by keeps the limits: the elbow has to slide into the nearest interval.
        found = np.empty((MAX_PIECES, 3))
        side = elbow_side(P, place_, branch >> 2)
        least = math.inf
        for i in range(find_intervals(P, place_, branch, found)):
            best, least = nearest_in(P, side, row(found, i), q, best, least)
        if least == math.inf:
            return
    for j in range(7):
        S[PLAN + j] = best[j] + off[j]
    S[PLAN_LEFT] = C[AHEAD]


@kernel
def own_motion(P, S, C, task, J):
    """The step that the joints would take towards the plan, if the target left them the choice, rad."""
    if int(S[TICK]) % EVERY == 1:
        plan(P, S, C, task, J)
    left = S[PLAN_LEFT]
    if left <= 0.0:
        return NO_SEED
    S[PLAN_LEFT] = left - C[PERIOD]
    way = minus(read7(row(S, PLAN)), read7(row(S, GOAL)))
    speed = 1.0 / max(left, C[PERIOD])
    for j in range(7):
        speed = min(speed, SHARE * C[SPEED + j] / max(abs(way[j]), 1e-12))
    return along7(NO_SEED, speed * C[PERIOD], way)
