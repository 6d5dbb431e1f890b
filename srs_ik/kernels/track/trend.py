"""The trend of the target: its velocity, acceleration and jolt, and where it is expected a while ahead.

A fading memory polynomial of third order: exponentially weighted least squares, with no lag behind a target of
constant jolt. What a target does at a singular posture is decided by some millimetres half a second ahead, and these
are a matter of the jolt.

Source: E. Brookner, Tracking and Kalman Filtering Made Easy (1998), section 1.3.
"""

import math

from srs_ik.kernels.algebra.vectors import along, dot, load3, load_pose, norm, scale, store_pose
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import FAR
from srs_ik.kernels.layout.track import (
    EVERY,
    NOISE,
    PERIOD,
    ROTATION,
    SMOOTHED,
    TREND,
    TREND_JOLT,
    TREND_PACE,
    TREND_PUSH,
)
from srs_ik.kernels.track.target import JUMP, JUMP_TURN, moved_on, part_of_way, way_to

MEMORY = 0.03
TRENDED = 1.5
"""Time constant with which the trend is forgotten, seconds: of a target without noise, and what is added by the time
constant of the smoothing."""

PACE_SHAKEN, PUSH_SHAKEN, JOLT_SHAKEN = 185.0 / 32.0, 81.0 / 32.0, 5.0 / 32.0
"""What white noise of variance 1 makes of a velocity, acceleration and jolt of the trend, squared, where targets and
memory are a second: of 2 n + 1 powers of the memory, by the Laguerre polynomials that the trend is made of."""

DOUBT = 2.0
"""So many times its mean square counts as noise: of a target at rest, most of what the trend says is less."""

LASTS = 0.3
"""A jolt is expected to die away with this time constant, seconds."""


@kernel
def forget(S, R, p):
    """Begin anew with a pose at rest."""
    store_pose(S, TREND, R, p)
    for i in range(18):
        S[TREND_PACE + i] = 0.0


@kernel
def mean_pace(S, i, of):
    """The velocity, linear (i = 0) or angular (3), by factors of the trend's velocity, acceleration and jolt."""
    pace = along(scale(of[0], load3(S, TREND_PACE + i)), of[1], load3(S, TREND_PUSH + i))
    return along(pace, of[2], load3(S, TREND_JOLT + i))


@kernel
def next_pace(S, t):
    """Mean linear and angular velocity in the period to come."""
    of = 1.0, t / 2.0, t * t / 6.0
    return mean_pace(S, 0, of), mean_pace(S, 3, of)


@kernel
def last_pace(S, t):
    """Mean linear and angular velocity in the last period."""
    of = 1.0, -t / 2.0, t * t / 6.0
    return mean_pace(S, 0, of), mean_pace(S, 3, of)


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
def memory_of(S):
    """The time constant with which the trend is forgotten, seconds."""
    return MEMORY + TRENDED * S[SMOOTHED]


@kernel
def sure_share(S, i, lever, noise):
    """The share of a derivative of the trend that is more than noise."""
    v, w = load3(S, i), load3(S, i + 3)
    size = dot(v, v) + lever**2 * dot(w, w)
    return 1.0 - noise / size if size > noise else 0.0


@kernel
def sure_of(P, S, C):
    """How much of velocity, acceleration and jolt of the trend is more than what jitter makes of a target at rest.

    Source: W. James, C. Stein, Estimation with Quadratic Loss (1961).
    """
    memory, lever = memory_of(S), P[FAR]
    shaken = 3.0 * (S[NOISE] ** 2 + (lever * S[NOISE + 1]) ** 2)
    noise = DOUBT * shaken * C[PERIOD] * S[EVERY] / memory**3
    return (
        sure_share(S, TREND_PACE, lever, PACE_SHAKEN * noise),
        sure_share(S, TREND_PUSH, lever, PUSH_SHAKEN * noise / memory**2),
        sure_share(S, TREND_JOLT, lever, JOLT_SHAKEN * noise / memory**4),
    )


@kernel
def foretold(S, seconds, sure):
    """What is followed of the target, after a while, by what is sure of its trend: shares as of `sure_of`."""
    R, p = load_pose(S, ROTATION)
    # The mean velocity on the way, from a jolt that dies away.
    gone = LASTS * (1.0 - math.exp(-seconds / LASTS)) / seconds
    jolt = LASTS * (0.5 * seconds - LASTS * (1.0 - gone))
    of = sure[0], 0.5 * seconds * sure[1], jolt * sure[2]
    return moved_on(R, p, mean_pace(S, 0, of), mean_pace(S, 3, of), seconds)
