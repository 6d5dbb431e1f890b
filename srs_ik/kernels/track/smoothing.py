"""What is followed of a target: all of it, or what a filter leaves of its jitter.

The filter has two stages. An estimate goes on with the velocity of the trend and takes a share of what it misses of
each target; what is followed comes after the estimate by its accelerations alone, critically damped. Both know the
velocity and acceleration of the trend, so at constant acceleration neither lags.
"""

import math

from srs_ik.kernels.algebra.vectors import add, along, load3, load_pose, scale, store_pose, sub
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import track as at
from srs_ik.kernels.track.noise import asked_for, measure, skip
from srs_ik.kernels.track.target import moved_on, part_of_way, way_to
from srs_ik.kernels.track.trend import coast, forget, last_pace, learn, memory_of, next_pace

ESTIMATED = 3.0
FOLLOWED = 0.5
"""By the time constant of the smoothing: the memory of the estimate, and the time constant of what follows it. Chosen
together with `TRENDED`, by time on target and accelerations with jitter."""


@kernel
def kept_for(period, seconds):
    """The share that is kept over a period."""
    return math.exp(-period / seconds) if seconds > 0.0 else 0.0


@kernel
def store_twist(S, v, w):
    """Keep how fast what is followed moved in the last period."""
    for i in range(3):
        S[at.TWIST + i] = v[i]
        S[at.TWIST + 3 + i] = w[i]


@kernel
def show(S, pose, v, w):
    """Follow a pose as it is, at a velocity."""
    store_pose(S, at.ESTIMATE, pose[0], pose[1])
    store_pose(S, at.ROTATION, pose[0], pose[1])
    store_twist(S, v, w)


@kernel
def go_after(S, t, kept):
    """Bring what is followed closer to the estimate: by changes of its velocity, with two equal roots."""
    was_v, was_w = load3(S, at.TWIST), load3(S, at.TWIST + 3)
    v, w = along(was_v, t, load3(S, at.TREND_PUSH)), along(was_w, t, load3(S, at.TREND_PUSH + 3))
    R, p = load_pose(S, at.ROTATION)
    linear, angular = way_to(moved_on(R, p, v, w, t), load_pose(S, at.ESTIMATE))
    goal_v, goal_w = last_pace(S, t)
    of_way, of_pace = (1.0 - kept) ** 2 / t, 2.0 * kept * (1.0 - kept)
    v = add(v, add(scale(of_way, linear), scale(of_pace, sub(goal_v, v))))
    w = add(w, add(scale(of_way, angular), scale(of_pace, sub(goal_w, w))))
    R, p = moved_on(R, p, v, w, t)
    store_pose(S, at.ROTATION, R, p)
    store_twist(S, v, w)


@kernel
def take_target(P, S, C, pose):
    """A new target; the first one, and one that jumped, as it is, at rest.

    A jump ends the plan: the shortest way to a target that is far away is that of the joints, not of the tip.
    """
    t, still, gap = C[at.PERIOD], (0.0, 0.0, 0.0), S[at.LOST] + 1.0
    since = t * gap
    S[at.LOST] = 0.0
    seconds = asked_for(P, S, C) if C[at.SMOOTHING] == at.MEASURED else C[at.SMOOTHING]
    S[at.SMOOTHED] = seconds
    v, w = next_pace(S, t)
    if S[at.STARTED] == 0.0 or not learn(S, t, since, memory_of(S), pose):
        S[at.STARTED], S[at.PLANNED] = 1.0, 0.0
        forget(S, pose[0], pose[1])
        show(S, pose, still, still)
        skip(S)
        measure(S, gap, pose[0], pose[1])
        S[at.ASK_FROM] = 0.0
        return
    measure(S, gap, pose[0], pose[1])
    if seconds == 0.0:
        v, w = last_pace(S, t)
        show(S, pose, v, w)
        return
    R, p = load_pose(S, at.ESTIMATE)
    expected = moved_on(R, p, v, w, t)
    linear, angular = way_to(expected, pose)
    R, p = part_of_way(expected, 1.0 - kept_for(since, ESTIMATED * seconds) ** 4, linear, angular)
    store_pose(S, at.ESTIMATE, R, p)
    go_after(S, t, kept_for(t, FOLLOWED * seconds))


@kernel
def lose_target(S, C):
    """No target: it is expected to go on by its trend, at first as it was, then more and more slowly."""
    t = C[at.PERIOD]
    slower = math.exp(-t / C[at.PATIENCE] * min(t * S[at.LOST] / C[at.PATIENCE], 1.0))
    coast(S, t, slower)
    v, w = last_pace(S, t)
    R, p = load_pose(S, at.ESTIMATE)
    R, p = moved_on(R, p, v, w, t)
    store_pose(S, at.ESTIMATE, R, p)
    go_after(S, t, kept_for(t, FOLLOWED * S[at.SMOOTHED]))
    S[at.LOST] += 1.0
