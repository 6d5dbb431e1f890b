"""The trend of the target: its velocity and acceleration, and where it is expected a while ahead.

A fading memory polynomial of second order: exponentially weighted least squares, with no lag behind a target of
constant acceleration.

Source: E. Brookner, Tracking and Kalman Filtering Made Easy (1998), section 1.3.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.vectors import along, load3, norm
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.track import PERIOD, ROTATION, TREND, TREND_PACE, TREND_PUSH
from srs_ik.kernels.track.target import JUMP, JUMP_TURN, load_pose, moved_on, part_of_way, store_pose, way_to

MEMORY = 0.02
"""Time constant, seconds, with which the trend forgets."""

LASTS = 1.0
"""An acceleration is expected to die away with this time constant, seconds."""


@kernel
def store3(S, k, a):
    """Write three figures from place k on."""
    for i in range(3):
        S[k + i] = a[i]


@kernel
def forget(S, R, p):
    """Begin anew with a pose at rest."""
    store_pose(S, TREND, R, p)
    for i in range(12):
        S[TREND_PACE + i] = 0.0


@kernel
def learn(S, C, known):
    """Take in where the smoothed target is now; one that has jumped, or was not known before, is at rest."""
    R, p = load_pose(S, ROTATION)
    period = C[PERIOD]
    a, b = load3(S, TREND_PUSH), load3(S, TREND_PUSH + 3)
    v, w = along(load3(S, TREND_PACE), period, a), along(load3(S, TREND_PACE + 3), period, b)
    before = load_pose(S, TREND)
    expected = moved_on(before[0], before[1], along(v, -0.5 * period, a), along(w, -0.5 * period, b), period)
    linear, angular = way_to(expected, (R, p))
    if not known or norm(linear) > JUMP or norm(angular) > JUMP_TURN:
        forget(S, R, p)
        return
    kept = math.exp(-period / MEMORY)
    left = 1.0 - kept
    R, p = part_of_way(expected, 1.0 - kept**3, linear, angular)
    store_pose(S, TREND, R, p)
    gain = 1.5 * left * left * (1.0 + kept) / period
    store3(S, TREND_PACE, along(v, gain, linear))
    store3(S, TREND_PACE + 3, along(w, gain, angular))
    gain = left**3 / period**2
    store3(S, TREND_PUSH, along(a, gain, linear))
    store3(S, TREND_PUSH + 3, along(b, gain, angular))


@kernel
def foretold(S, seconds):
    """The pose of the target after a while."""
    R, p = load_pose(S, ROTATION)
    # The mean velocity on the way, from an acceleration that dies away.
    gain = LASTS * (1.0 - LASTS / seconds * (1.0 - math.exp(-seconds / LASTS)))
    v = along(load3(S, TREND_PACE), gain, load3(S, TREND_PUSH))
    w = along(load3(S, TREND_PACE + 3), gain, load3(S, TREND_PUSH + 3))
    return moved_on(R, p, v, w, seconds)
