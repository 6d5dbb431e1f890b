"""Where a target is expected: its trend, against polynomials and an integration by SciPy."""

import numpy as np
import pinocchio as pin
import pytest
from numba import njit
from scipy.integrate import solve_ivp

from srs_ik.kernels.algebra.pointers import keep, row
from srs_ik.kernels.algebra.vectors import store_pose
from srs_ik.kernels.layout.track import ROTATION, STATE, TREND_JOLT, TREND_PACE, TREND_PUSH
from srs_ik.kernels.track.trend import (
    JOLT_SHAKEN,
    LASTS,
    PACE_SHAKEN,
    PUSH_SHAKEN,
    coast,
    foretold,
    forget,
    learn,
)

DT = 0.002
MEMORY = 0.03
SEEN = 1.2
"""Time constant of the trend, and for how long the target is seen: all of the beginning is forgotten; seconds."""


@njit
def seen(state, every, R, p):
    """Let a trend learn from poses, one in so many periods."""
    S = row(state, 0)
    for k in range(len(R)):
        a, b = R[k], p[k]
        pose = (a[0], a[1], a[2], a[3], a[4], a[5], a[6], a[7], a[8]), (b[0], b[1], b[2])
        store_pose(S, ROTATION, pose[0], pose[1])
        if k > 0:
            for _ in range(every - 1):
                coast(S, DT, 1.0)
        if k == 0 or not learn(S, DT, every * DT, MEMORY, pose):
            forget(S, pose[0], pose[1])
    keep(state)


@njit
def expected(state, seconds):
    """Where it is expected then."""
    R, p = foretold(row(state, 0), seconds, (1.0, 1.0, 1.0))
    keep(state)
    return R, p


def cubic(t, powers):
    """The polynomial of third order with these derivatives at zero."""
    t = np.asarray(t, float)[..., None]
    return powers[0] * t + powers[1] * t**2 / 2.0 + powers[2] * t**3 / 6.0


def dying(seconds, powers):
    """The way from there if the third derivative dies away."""
    rise = solve_ivp(
        lambda t, x: [x[1], x[2], np.exp(-t / LASTS)], (0.0, seconds), np.zeros(3), rtol=1e-10, atol=1e-14
    ).y[0, -1]
    return powers[0] * seconds + powers[1] * seconds**2 / 2.0 + powers[2] * rise


@pytest.mark.parametrize("every", [1, 5])
@pytest.mark.parametrize("seed", range(4))
def test_a_target_of_constant_jolt_is_foretold_without_a_lag(seed, every):
    rng = np.random.default_rng(seed)
    move, spin = rng.normal(size=(3, 3)) * [[0.3], [1.0], [4.0]], rng.normal(size=3) * [0.5, 1.0, 4.0]
    axis = pin.exp3(rng.normal(size=3))[:, 0]
    t = DT * np.arange(-round(SEEN / DT), 1)
    angles = cubic(t, spin[:, None])[:, 0]
    R = np.array([pin.exp3(angle * axis).ravel() for angle in angles])
    state = np.zeros((1, STATE))
    seen(state, every, R[::every], cubic(t, move)[::every])
    for seconds in (0.02, 0.1, 0.25, 0.45):
        rotation, p = expected(state, seconds)
        np.testing.assert_allclose(p, dying(seconds, move), atol=1e-8)
        turn = pin.log3(np.array(rotation).reshape(3, 3))
        np.testing.assert_allclose(turn, dying(seconds, spin) * axis, atol=1e-8)
        # Nearer to where it truly goes than without a jolt.
        straight = np.linalg.norm(move[2]) * seconds**3 / 6.0
        assert np.linalg.norm(p - cubic(seconds, move)) < 0.4 * straight + 1e-8


SHAKEN_MEMORY = 0.1
"""Long against a period, s: what noise makes of a trend is known for that."""


@njit
def shaken(state, p, found):
    """What a trend is after each of many poses that do not turn: velocity, acceleration and jolt along one axis."""
    S = row(state, 0)
    R = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    forget(S, R, (0.0, 0.0, 0.0))
    for k in range(len(p)):
        learn(S, DT, DT, SHAKEN_MEMORY, (R, (p[k], 0.0, 0.0)))
        found[k, 0], found[k, 1], found[k, 2] = S[TREND_PACE], S[TREND_PUSH], S[TREND_JOLT]
    keep(state)


def test_what_white_noise_makes_of_a_trend_is_known():
    noise = np.random.default_rng(77).normal(0.0, 1e-3, 200_000)
    found = np.empty((len(noise), 3))
    shaken(np.zeros((1, STATE)), noise, found)
    squares = (found[2000:] ** 2).mean(axis=0)
    told = 1e-6 * DT / SHAKEN_MEMORY ** np.array([3.0, 5.0, 7.0]) * [PACE_SHAKEN, PUSH_SHAKEN, JOLT_SHAKEN]
    # A period is a fiftieth of the memory, which comes in up to the seventh power.
    assert squares == pytest.approx(told, rel=0.15)
