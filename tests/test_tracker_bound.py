"""How far a tracker's tip is off a target that can be followed, against what the limits imply (`bounded.py`)."""

import arms
import numpy as np
import pytest
from bounded import Chaser, Follower, beyond, can_be_followed, known_motion, off_by, run
from motions import motion, off_target
from tracked import passed, velocities

DT = 0.002
ROUNDING = 1e-9
"""Limits are kept to this, rad, rad/s and rad/s^2."""

ARMS = arms.here("iiwa14", "gen3")


def limits(arm):
    """The arm's velocity limits, and accelerations that lead to them in 0.2 s."""
    return velocities(arm), 5.0 * velocities(arm)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", ARMS)
def test_motions_can_be_followed_but_where_they_jump(name, seed):
    arm = arms.load(name)
    known = known_motion(arm, seed, DT)
    free = can_be_followed(known.q, limits(arm), DT)
    # Two jumps; a jump is one velocity and two changes of it.
    assert 1 <= (~free).sum() <= 4
    assert (known.q >= arm.lower).all()
    assert (known.q <= arm.upper).all()


@pytest.mark.parametrize("name", ARMS)
def test_the_follower_keeps_the_limits_and_loses_nothing_of_what_can_be_followed(name):
    arm = arms.load(name)
    known = known_motion(arm, 0, DT)
    follower = Follower(arm, (known.q[0], np.zeros(7)), (known.q[0], np.zeros(7)), limits(arm), DT)
    left, q = [], []
    for each in known.q:
        left.append(follower.step(each))
        q.append(follower.q)
    assert passed(arm, known.q[0], np.array(q), limits(arm), DT).max() < ROUNDING
    jump = int(np.argmax(~can_be_followed(known.q, limits(arm), DT)))
    # Time-optimal, and no sample late: on the target until it jumps, and again once joints could be.
    assert max(left[:jump]) < ROUNDING
    assert left[jump] > 1e-3
    least = 2.0 * np.sqrt(left[jump] / limits(arm)[1].max())
    back = DT * int(np.argmax(np.array(left[jump:]) < 1e-6))
    assert least < back < 4.0 * least + 0.2


@pytest.mark.parametrize("name", ARMS)
def test_the_chaser_keeps_the_limits_and_is_back_after_a_jump_by_poses_alone(name):
    arm, forward = arms.load(name), arms.forward(name)
    known = known_motion(arm, 0, DT)
    jump = int(np.argmax(~can_be_followed(known.q, limits(arm), DT)))
    chaser = Chaser(arm, (known.q[jump - 1], np.zeros(7)), None, limits(arm), DT)
    q, off = [], []
    for each in known.q[jump : jump + 400]:
        chaser.chase(forward(each))
        q.append(chaser.q)
        off.append(off_by(forward, chaser.q, forward(each)))
    assert passed(arm, known.q[jump - 1], np.array(q), limits(arm), DT).max() < ROUNDING
    assert off[0][0] > 1e-3
    assert np.max(off[-50:], axis=0) == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize(("name", "seed", "most"), [("iiwa14", 302, 0.1), ("iiwa14", 306, 0.01), ("gen3", 300, 0.05)])
def test_the_tip_is_no_farther_off_than_the_limits_imply(name, seed, most):
    """With 302 the goal went ahead of the joints around a singular shoulder: for 3.4 s, 0.6 m off, 35 % beyond."""
    arm, forward = arms.load(name), arms.forward(name)
    found, bounds = run(arm, forward, known_motion(arm, seed, DT), DT)
    past = beyond(arm, forward, found, bounds, DT, told=True)
    counted = np.isfinite(past[:, 0])
    assert counted.mean() > 0.9
    assert (past[counted] > 0.0).any(axis=1).mean() < most
    # What counts is checked by Pinocchio on a sample.
    k = int(np.argmax(counted))
    assert off_by(forward, found.q[k + 1], forward(found.known.q[k])) == pytest.approx(found.off[k], abs=1e-12)


def test_along_limits_the_arm_is_ahead_of_what_comes():
    """A target foretold by velocity and acceleration alone was met for 75.6 % of the time."""
    arm, met = arms.load("human_left"), []
    for seed in range(81000, 81012):
        moving = motion(arm, seed, 8.0, DT, "limits", trouble=False)
        tracker = arm.tracker(moving.q0, DT, velocities(arm))
        q = np.array([tracker.update(T).q for T in moving.given])
        position, angle = off_target(arms.forward("human_left"), q, moving.true)
        met.append(((position < 1e-3) & (angle < 1e-2)).mean())
    assert np.mean(met) > 0.82
