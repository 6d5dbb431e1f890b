"""Tasks that some posture meets are met: rolls that move the wrist, wrists beyond the nearest exact limb's reach."""

import arms
import numpy as np
import pinocchio as pin
import pytest

import srs_ik
from srs_ik import Task

MET = 1e-8
"""How far a tip may be from where its task wants it, m, and its grasp direction."""

TOOL = srs_ik.pose_from_xyz_rpy([0.15, 0.0, 0.1], [0.0, 0.8, 0.0])
"""A tip beside the line through its wrist along the grasp."""


def with_hand(name):
    """An arm that knows how its hand lies, and the two axes of that."""
    arm = arms.load(name)
    if arm.hand is None:
        arm = srs_ik.load(arms.file_of(name), base=arm.base, tip=arm.tip, hand=[[0, 0, 1], [1, 0, 0]])
    return arm, np.array(arm.hand.grasp), np.array(arm.hand.pronosupination)


@pytest.mark.slow
@pytest.mark.parametrize("name", arms.here("iiwa14", "human_arm", "gen3"))
def test_a_roll_that_moves_the_wrist_is_found(name):
    arm, rng = arms.load(name).with_tool(TOOL), arms.generator(name, 71)
    grasp = np.array(arm.hand.grasp)
    tips = [arms.forward(name)(q) * pin.SE3(TOOL) for q in arms.configurations(name, 60, 71)]
    v, f = rng.normal(size=(2, len(tips), 3))
    goals = np.array([[tip.translation, tip.rotation @ grasp] for tip in tips])
    found = arm.solve_task(Task(goals[:, 0], v, f, goals[:, 1]))
    assert found.ok.all()
    for i, (one, goal) in enumerate(zip(found, goals, strict=True)):
        tip = arms.forward(name)(one.q) * pin.SE3(TOOL)
        assert np.abs(tip.translation - goal[0]).max() < MET
        assert np.abs(tip.rotation @ grasp - goal[1]).max() < MET
        assert (one.q >= arm.lower - 1e-9).all()
        assert (one.q <= arm.upper + 1e-9).all()
        if i < 10:
            assert (arm.solve_task(Task(goal[0], v[i], f[i], goal[1])).q == one.q).all()


@pytest.mark.parametrize("name", arms.here(*arms.NEAR))
@pytest.mark.parametrize("side", ["left", "right"])
def test_a_wrist_beyond_the_reach_of_the_nearest_exact_limb_is_met(name, side):
    (arm, grasp, across), rng = with_hand(name), arms.generator(name, 72)
    q = arms.configurations(name, 300, 72)
    q[:, 3] = np.clip(rng.normal(size=len(q)) * 0.02, arm.lower[3], arm.upper[3])
    tips = [arms.forward(name)(each) for each in q]
    v, f = rng.normal(size=(2, len(tips), 3))
    given = ([tip.rotation @ axis for tip in tips] for axis in (grasp, across))
    found = arm.solve_task(Task([tip.translation for tip in tips], v, f, *given), side=side)
    assert found.ok.all()
    for one, tip in zip(found, tips, strict=True):
        there = arms.forward(name)(one.q)
        assert np.abs(there.homogeneous - tip.homogeneous).max() < MET
