"""The trend of the target: its velocity, acceleration and jolt, and where it is expected a while ahead.

A fading memory polynomial of third order: exponentially weighted least squares, with no lag behind a target of
constant jolt. What a target does at a singular posture is decided by some millimetres half a second ahead, and these
are a matter of the jolt.

Source: E. Brookner, Tracking and Kalman Filtering Made Easy (1998), section 1.3.
"""

import math

from srs_ik.kernels.algebra.vectors import along, load3, load_pose, norm, store_pose
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.track import ROTATION, TREND, TREND_JOLT, TREND_PACE, TREND_PUSH
from srs_ik.kernels.track.target import JUMP, JUMP_TURN, moved_on, part_of_way, way_to

LASTS = 0.3
"""A jolt is expected to die away with this time constant, seconds."""


@kernel
def forget(S, R, p):
    """Begin anew with a pose at rest."""
    store_pose(S, TREND, R, p)
    for i in range(18):
        S[TREND_PACE + i] = 0.0


@kernel
def mean_pace(S, i, push, jolt):
    """The velocity, linear (i = 0) or angular (3), with parts of the acceleration and the jolt."""
    return along(along(load3(S, TREND_PACE + i), push, load3(S, TREND_PUSH + i)), jolt, load3(S, TREND_JOLT + i))


@kernel
def next_pace(S, t):
    """Mean linear and angular velocity in the period to come."""
    return mean_pace(S, 0, t / 2.0, t * t / 6.0), mean_pace(S, 3, t / 2.0, t * t / 6.0)


@kernel
def last_pace(S, t):
    """Mean linear and angular velocity in the last period."""
    return mean_pace(S, 0, -t / 2.0, t * t / 6.0), mean_pace(S, 3, -t / 2.0, t * t / 6.0)


@kernel
def go_on(S, R, p, t):
    """A period later, at a pose."""
    store_pose(S, TREND, R, p)
    for i in range(6):
        S[TREND_PACE + i] += t * (S[TREND_PUSH + i] + 0.5 * t * S[TREND_JOLT + i])
        S[TREND_PUSH + i] += t * S[TREND_JOLT + i]


@kernel
def learn(S, t, since, memory, pose):
    """Take in a target so long after the last one: whether it is where it can be expected, or has jumped."""
    before = load_pose(S, TREND)
    v, w = next_pace(S, t)
    expected = moved_on(before[0], before[1], v, w, t)
    linear, angular = way_to(expected, pose)
    if norm(linear) > JUMP or norm(angular) > JUMP_TURN:
        return False
    kept = math.exp(-since / memory)
    R, p = part_of_way(expected, 1.0 - kept**4, linear, angular)
    go_on(S, R, p, t)
    left = 1.0 - kept
    pace = left**2 * (11.0 + 14.0 * kept + 11.0 * kept**2) / (6.0 * since)
    push, jolt = 2.0 * left**3 * (1.0 + kept) / since**2, left**4 / since**3
    for i in range(6):
        missed = linear[i] if i < 3 else angular[i - 3]
        S[TREND_PACE + i] += pace * missed
        S[TREND_PUSH + i] += push * missed
        S[TREND_JOLT + i] += jolt * missed
    return True


@kernel
def coast(S, t, slower):
    """No target: it goes on by its trend, more slowly."""
    for i in range(18):
        S[TREND_PACE + i] *= slower
    before = load_pose(S, TREND)
    v, w = next_pace(S, t)
    R, p = moved_on(before[0], before[1], v, w, t)
    go_on(S, R, p, t)


@kernel
def foretold(S, seconds):
    """What is followed of the target, after a while."""
    R, p = load_pose(S, ROTATION)
    # The mean velocity on the way, from a jolt that dies away.
    gone = LASTS * (1.0 - math.exp(-seconds / LASTS)) / seconds
    jolt = LASTS * (0.5 * seconds - LASTS * (1.0 - gone))
    return moved_on(R, p, mean_pace(S, 0, 0.5 * seconds, jolt), mean_pace(S, 3, 0.5 * seconds, jolt), seconds)
