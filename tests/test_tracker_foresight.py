"""What a tracker foresees: motions that it stays on as it looks ahead, and what it says on its way."""

import arms
import numpy as np
import pytest
from motions import motion, off_target
from tracked import NEAR_TARGET

DT = 0.002
SEEN = (
    ("iiwa14", "joints", 3400019),
    ("iiwa14", "joints", 3400035),
    ("iiwa14", "limits", 3400002),
    ("gen3", "singular", 3400016),
    ("gen3", "limits", 3400026),
)
"""Motions of 10 s that a plan of half a second leaves for 2 to 4 s."""

IN_TWO_STEPS = (("iiwa14", "joints", 8200022), ("iiwa14", "singular", 8200019))
"""Motions of 10 s that are left, by 2 and 22 mm, where plans are one step of Gauss and Newton from the plan before."""

SLOWLY = 0.02
AT_SLOW_RATES = (
    ("iiwa14", "singular", 3400001),
    ("iiwa14", "joints", 3400005),
    ("iiwa14", "joints", 3400007),
    ("gen3", "singular", 3400004),
    ("gen3", "joints", 3400000),
)
"""Motions at 50 targets a second. A tip that comes back as gently at every update as at 500 a second stays off them."""

MET = 1e-6
"""A tip this close to its target, m and rad, is on it."""

USED_UP = 0.98


MOTIONS = [(DT, *case) for case in SEEN + IN_TWO_STEPS] + [(SLOWLY, *case) for case in AT_SLOW_RATES]


@pytest.mark.parametrize(("dt", "name", "kind", "seed"), [case for case in MOTIONS if case[1] in arms.here(case[1])])
def test_what_lies_a_second_ahead_is_prepared_for_at_slow_rates_too(dt, name, kind, seed):
    arm = arms.load(name)
    moving = motion(arm, seed, 10.0, dt, kind, trouble=False)
    tracker = arm.tracker(moving.q0, dt)
    q = np.array([tracker.update(T).q for T in moving.true])
    position, angle = off_target(arms.forward(name), q, moving.true)
    assert position.max() < NEAR_TARGET[0]
    assert angle.max() < NEAR_TARGET[1]


@pytest.mark.parametrize("seed", [3400000, 3400001, 3400002])
def test_a_tip_on_its_target_is_said_to_be_there_and_only_joints_at_a_limit_cannot_move_faster(seed):
    arm = arms.load("iiwa14")
    moving = motion(arm, seed, 6.0, DT, "singular", trouble=False)
    tracker = arm.tracker(moving.q0, DT)
    steps = [tracker.update(T) for T in moving.true]
    q = np.array([step.q for step in steps])
    position, angle = off_target(arms.forward("iiwa14"), q, moving.true)
    there = (position < MET) & (angle < MET)
    assert there.mean() > 0.3
    assert all(step.status == "OK" for step, on in zip(steps, there, strict=True) if on)
    # Turns count by the reach, which is less than a metre.
    off = (position > MET) | (angle > 2.0 * MET)
    assert not any(step.status == "OK" for step, away in zip(steps, off, strict=True) if away)
    for step in steps:
        if "cannot move faster" in step.message:
            j = arm.joint_names.index(step.joint)
            fast = abs(step.velocity[j]) / tracker.velocity_limit[j]
            assert max(fast, abs(step.acceleration[j]) / tracker.acceleration_limit[j]) > USED_UP
