"""One period of a tracker.

Two followers, one behind the other. The goal is a posture on the target's pose, or as close to it as it comes: it keeps
the joint limits, moves at most `FASTER` times as fast as the joints may, and knows no inertia. The joints follow the
goal within all their limits, and brake so that they stop at it. Once they have met it, they take the step to the next
pose themselves, with the elbow where their limits leave room for it.
"""

import math

from srs_ik.kernels.algebra.joint_vectors import along7, apart, between, dot7, store7
from srs_ik.kernels.algebra.pointers import read7, row, scratch
from srs_ik.kernels.algebra.vectors import load_pose
from srs_ik.kernels.chain.newton import clipped
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import track as at
from srs_ik.kernels.layout.limb import FAR, LOWER, UPPER
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.track.catch_up import CLOSE_BY, LEVER, STAYS, catch_up, way_left
from srs_ik.kernels.track.closest import DAMPING, approach, dot6, error_at, minus
from srs_ik.kernels.track.elsewhere import end_search, keep_detour, look_elsewhere, look_nearer
from srs_ik.kernels.track.foresight import busyness, foresee, planned_step
from srs_ik.kernels.track.freedom import error_left, out_of_reach, wanted
from srs_ik.kernels.track.limits import bounds, toward
from srs_ik.kernels.track.smoothing import lose_target, take_target
from srs_ik.kernels.track.target import JUMP, keep_pace
from srs_ik.kernels.track.verdict import CLOSE, on_the_way, verdict

FASTER = 3.0
"""The goal may move so many times as fast as the joints."""

MET = 1e-9
"""A pose is met if it is closer than this, m, and, by the reach, rad."""

TOGETHER = 1e-12
"""Joints this close to the goal, rad, have met it."""

COAST_FOR = 250
AT_REST = 0.02
"""A tip close to its target that comes no closer in so many updates does not on the straight way: then other ways are
looked for. Behind a target that moves on, updates count in which no joint uses this share of its velocity."""

RESTING = 0.1
"""A target less busy than this rests."""

PLAN_EVERY = 0.008
"""Seconds from one plan to the next."""

CLOSER = 0.99
"""A goal, or a tip, whose miss shrinks to this share in an update is on its way."""

STUCK_FOR = 10
AGAIN = 25
AT_ONCE = 2
"""Other postures are looked for when the goal has been off the target for so many updates, and after so many more;
within a search, there is a look every so many."""

WORTH = 1e-4
"""A step of a goal that is stuck is worth it if a radian brings it closer by this, m and, by the reach, rad: about a
straight elbow, joints may turn and turn for next to nothing."""

WARIER, BOLDER, WARIEST = 4.0, 0.7, 1e7
"""After a step that is not worth it the next is damped by so much more, up to so much in all, and less again after one
that is: where the way is curved, as along the edge of a cone, steps that are too long go past it for ever."""

SETTLING = 0.01
"""Seconds over which the velocity of the goal is averaged."""

COMING = 0.01
"""Seconds in which the goal comes to the joints as far as the pose leaves the choice, while they are behind."""


@kernel
def scaled(s, a):
    """A multiple of seven figures."""
    return along7(NO_SEED, s, a)


@kernel
def reach_of_goal(P, C, goal, joint, side):
    """How far a joint of the goal may go in a period, up (1.0) or down (-1.0), rad."""
    most = FASTER * C[at.PERIOD] * C[at.SPEED + joint]
    if side > 0.0:
        return min(most, P[UPPER + joint] - goal[joint])
    return max(-most, P[LOWER + joint] - goal[joint])


@kernel
def reaches_of_goal(P, C, g, side):
    """`reach_of_goal` of all joints."""
    found = row(scratch(1, 7), 0)
    for joint in range(7):
        found[joint] = reach_of_goal(P, C, g, joint, side)
    return read7(found)


@kernel
def if_worth_it(P, S, C, pose, goal, d, J):
    """The step of a goal that is stuck, or none where it is not worth it, and how far it is from the pose then."""
    before, stays = error_at(P, C, goal, pose, P[FAR], J)
    after, moves = error_at(P, C, along7(goal, 1.0, d), pose, P[FAR], J)
    if math.sqrt(dot6(before, before)) - math.sqrt(dot6(after, after)) < WORTH * math.sqrt(dot7(d, d)):
        S[at.WARY] = min(WARIER * S[at.WARY], WARIEST)
        return NO_SEED, stays
    S[at.WARY] = max(BOLDER * S[at.WARY], 1.0)
    return d, moves


@kernel
def move_goal(P, S, C, pose, work):
    """Take the goal a period on towards the target, by the detour if it is on one: how far it is from it then."""
    q, goal = read7(row(S, at.Q)), read7(row(S, at.GOAL))
    low, high = reaches_of_goal(P, C, goal, -1.0), reaches_of_goal(P, C, goal, 1.0)
    if S[at.DETOUR] == 1.0:
        left = minus(read7(row(S, at.DETOUR_END)), goal)
        d = between(left, low, high)
        goal = along7(goal, 1.0, d)
        if apart(left, d) < TOGETHER:
            S[at.DETOUR] = 0.0
        _, size = error_at(P, C, goal, pose, P[FAR], work[0])
    else:
        stuck = S[at.WARY] > 0.0 and S[at.STUCK] >= STUCK_FOR and busyness(P, S) < RESTING
        rule = P[FAR], 0.5 * P[FAR] * S[at.MISS] * (S[at.WARY] if stuck else 1.0), DAMPING
        liked = between(scaled(min(C[at.PERIOD] / COMING, 1.0), minus(q, goal)), low, high)
        d, size = approach(P, C, pose, goal, (NO_SEED, liked, rule, low, high), 2, work)
        if S[at.MISS] < CLOSE < size:
            # Nearer to the joints, the pose may not be met.
            d, size = approach(P, C, pose, goal, (NO_SEED, NO_SEED, rule, low, high), 2, work)
        if stuck:
            d, size = if_worth_it(P, S, C, pose, goal, d, work[0])
        goal = clipped(P, along7(goal, 1.0, d))
    share = C[at.PERIOD] / (C[at.PERIOD] + SETTLING)
    for j in range(7):
        rate = S[at.GOAL_RATE + j] + share * (d[j] / C[at.PERIOD] - S[at.GOAL_RATE + j])
        S[at.GOAL_RATE + j] = min(max(rate, -C[at.SPEED + j]), C[at.SPEED + j])
    store7(S, at.GOAL, goal)
    return size


@kernel
def follow_goal(S, C, low, high):
    """Velocities with which the joints come to the goal and stop there, as far as their limits allow."""
    q, goal, rate = read7(row(S, at.Q)), read7(row(S, at.GOAL)), read7(row(S, at.GOAL_RATE))
    v = row(scratch(1, 7), 0)
    for joint in range(7):
        v[joint] = toward(C, joint, q[joint], goal[joint], rate[joint])
    return between(v, low, high)


@kernel
def stay_on(P, S, C, pose, own, box, work):
    """The step that keeps the tip on the target, and whether there is one within all limits."""
    period = C[at.PERIOD]
    q, v = read7(row(S, at.Q)), read7(row(S, at.V))
    low, high = scaled(period, box[0]), scaled(period, box[1])
    choice = (between(scaled(period, v), low, high), own, (LEVER, 0.0, DAMPING), low, high)
    d, size = approach(P, C, pose, q, choice, 4, work)
    return d, size < MET


@kernel
def own_motion(P, S, C, work):
    """The step of the joints by their plan, rad."""
    if S[at.PLANNED] == 0.0 or S[at.TICK] % max(math.floor(PLAN_EVERY / C[at.PERIOD] + 0.5), 1.0) == 0.0:
        foresee(P, S, C, work[3], (work[0], work[1], work[2]))
    return planned_step(S, C)


@kernel
def arriving(P, S):
    """Whether the joints are on their way to a posture on a target that rests: they brake in time by themselves."""
    known = S[at.MISS] < CLOSE or S[at.DETOUR] == 1.0
    return S[at.ON] == 0.0 and S[at.PLANNED] == 0.0 and known and busyness(P, S) < RESTING


@kernel
def most_used(C, v):
    """The largest share of a joint's velocity that is used."""
    most = 0.0
    for j in range(7):
        most = max(most, abs(v[j]) / C[at.SPEED + j])
    return most


@kernel
def comes_closer(P, S, C, v, size, pose):
    """Whether a tip close to its target comes closer, or may: while a joint moves, unless the target rests in reach."""
    if busyness(P, S) >= RESTING or out_of_reach(P, C, pose):
        S[at.CLOSEST] = math.inf
        return most_used(C, v) > AT_REST
    closer = size < CLOSER * S[at.CLOSEST]
    if closer:
        S[at.CLOSEST] = size
    return closer


@kernel
def watch(P, S, C, q, size, pose, work):
    """Keep account of how long the goal has been off the target, or gone from the joints, and look elsewhere then."""
    closer, jumped = size < CLOSER * S[at.MISS], size > S[at.MISS] + JUMP
    S[at.MISS] = size
    S[at.WARY] = 0.0 if closer or jumped or size < CLOSE else max(S[at.WARY], 1.0)
    if size < CLOSE:
        S[at.STUCK] = 0.0
        end_search(S, at.UNKNOWN)
        if S[at.TICK] % AGAIN == 0.0:
            if S[at.DETOUR] == 1.0:
                keep_detour(P, S, C, pose, work)
            look_nearer(P, S, C, q, pose, work)
        return
    if jumped:
        end_search(S, at.UNKNOWN)
    elif closer:
        S[at.ELSEWHERE] = at.UNKNOWN
        return
    S[at.STUCK] += 1.0
    if S[at.STUCK] < STUCK_FOR or out_of_reach(P, C, pose):
        return
    if (S[at.STUCK] - STUCK_FOR) % (AGAIN if S[at.LOOKS] == 0.0 else AT_ONCE) != 0.0:
        return
    if S[at.DETOUR] == 1.0:
        keep_detour(P, S, C, pose, work)
    else:
        look_elsewhere(P, S, C, pose, size, work)


@kernel
def write_step(S, C, q, v, said, out):
    """Write an update's answer, and the state of the joints."""
    for j in range(7):
        out[at.STEP_Q + j] = q[j]
        out[at.STEP_V + j] = v[j]
        out[at.STEP_A + j] = (v[j] - S[at.V + j]) / C[at.PERIOD]
        S[at.Q + j] = q[j]
        S[at.V + j] = v[j]
    out[at.STEP_STATUS] = said[0]
    out[at.STEP_REASON] = said[1]
    out[at.STEP_JOINT] = said[2]
    out[at.STEP_LOST] = S[at.LOST]


@kernel
def step_to(P, S, C, v):
    """Where the joints are after a period, inside their limits, and the velocities that lead there."""
    q = read7(row(S, at.Q))
    after = clipped(P, along7(q, C[at.PERIOD], v))
    return after, scaled(1.0 / C[at.PERIOD], minus(after, q))


@kernel
def advance(P, S, C, given, work, out):
    """A tracker's next period, into out (STEP,).

    `given` is 1 with a target, 0 without, -1 with one that is no pose; and its rotation and position. `work` holds J,
    A, B (7 KNOTS, BAND + 2), and the parameters of the elbow's objective.
    """
    has, R, p = given
    J, A, _, _ = work
    q, v = read7(row(S, at.Q)), read7(row(S, at.V))
    box = bounds(P, C, q, v, -1.0), bounds(P, C, q, v, 1.0)
    S[at.TICK] += 1.0
    known = S[at.STARTED] == 1.0
    shown = load_pose(S, at.ROTATION)
    if has == 1:
        take_target(P, S, C, (wanted(P, S, C, R), p))
    elif known:
        lose_target(S, C)
    else:
        after, v = step_to(P, S, C, between(NO_SEED, box[0], box[1]))
        store7(S, at.GOAL, after)
        out[at.STEP_POSITION_ERROR] = out[at.STEP_ORIENTATION_ERROR] = math.inf
        write_step(S, C, after, v, (at.HELD, at.NO_TARGET_YET if has == 0 else at.BAD_TARGET, 0), out)
        return
    if known:
        keep_pace(S, C, shown)
        if busyness(P, S) >= RESTING:
            S[at.ASKED] = at.MOVES
        elif S[at.TICK] >= S[at.ASK_FROM]:
            S[at.ASKED] = at.UNKNOWN
    R_target, p_target = load_pose(S, at.ROTATION)
    pose = R_target, p_target
    size, on, near = 0.0, False, False
    left = way_left(P, S, C)
    close_by = left[3] < (STAYS if S[at.PLANNED] == 1.0 else CLOSE_BY)
    if S[at.CLOSEST] < math.inf and busyness(P, S) >= RESTING:
        # The target rested and moves on: the straight way may be one again.
        S[at.CLOSEST], S[at.COAST] = math.inf, 0.0
    if S[at.COAST] < COAST_FOR and (S[at.ON] == 1.0 or (close_by and not arriving(P, S))):
        if S[at.PLANNED] == 0.0:
            S[at.CLOSEST] = math.inf
        own = own_motion(P, S, C, work)
        if S[at.ON] == 1.0:
            d, on = stay_on(P, S, C, pose, own, box, (J, A))
        near = not on and close_by
        if near:
            d = catch_up(P, S, C, left, own, box, (J, A))
        v = scaled(1.0 / C[at.PERIOD], d)
    if not (on or near):
        S[at.PLANNED] = 0.0
    if on or near:
        after, v = step_to(P, S, C, v)
        store7(S, at.GOAL, after)
        store7(S, at.GOAL_RATE, v)
        S[at.GAP] = math.inf
        if near:
            _, size = error_at(P, C, after, pose, P[FAR], J)
            on = size < MET
        S[at.COAST] = 0.0 if on or comes_closer(P, S, C, v, size, pose) else S[at.COAST] + 1.0
    else:
        size = move_goal(P, S, C, pose, (J, A))
        after, v = step_to(P, S, C, follow_goal(S, C, box[0], box[1]))
        on = size < MET and apart(after, read7(row(S, at.GOAL))) < TOGETHER
        if size < CLOSE:
            S[at.COAST] = 0.0
    S[at.ON] = 1.0 if on else 0.0
    if near and size >= CLOSE:
        said = on_the_way(P, S, C, v, pose)
    else:
        watch(P, S, C, after, size, pose, (J, A))
        said = verdict(P, S, C, after, size, pose)
    if has != 1:
        said = at.HELD, at.LOST_TARGET if has == 0 else at.BAD_TARGET, said[2]
        R, p = R_target, p_target
    out[at.STEP_POSITION_ERROR], out[at.STEP_ORIENTATION_ERROR] = error_left(P, C, after, R, p)
    write_step(S, C, after, v, said, out)
