"""The paper's optimisation as printed, by SciPy, against the exact method: independent, and never better."""

import arms
import numpy as np
import pytest
from objective_parameters import PARAMETERS
from oracles import inside

from srs_ik import InvalidConfiguration, InvalidPose, InvalidTask, Objective
from srs_ik.paper import printed_optimum

ACCURACY = 1e-8


def rounded(optimum):
    """What a pose met only to the accuracy is worth at most."""
    return 1e-6 * max(1.0, abs(optimum.value))


@pytest.mark.parametrize("robot", ["iiwa14", "gen3"])
@pytest.mark.parametrize("name", ["force_velocity_ratio", "twist", "wrench", "manipulability"])
def test_it_is_never_better_and_often_the_same(robot, name):
    arm = arms.load(robot)
    same = 0
    for q in arms.configurations(robot, 3, 60):
        pose = arm.forward_kinematics(q)
        exact = arm.optimise(pose, name, **PARAMETERS[name])
        printed = printed_optimum(arm, pose, name, accuracy=ACCURACY, **PARAMETERS[name])
        assert printed
        assert max(printed.position_error, printed.orientation_error) < 1.01 * ACCURACY
        assert inside(printed.q, arm.lower, arm.upper)
        sign = -1.0 if exact.objective.maximise else 1.0
        assert sign * printed.value >= sign * exact.value - rounded(exact)
        same += abs(printed.value - exact.value) < rounded(exact)
    assert same > 0


@pytest.mark.parametrize("name", ["force_then_velocity", "velocity_then_force"])
def test_lexicographic_objectives_agree_where_it_finds_the_first_optimum(name):
    arm = arms.load("iiwa14")
    same = 0
    for q in arms.configurations("iiwa14", 3, 61):
        pose = arm.forward_kinematics(q)
        exact = arm.optimise(pose, name, **PARAMETERS[name])
        printed = printed_optimum(arm, pose, name, accuracy=ACCURACY, **PARAMETERS[name])
        sign = -1.0 if exact.objective.maximise else 1.0
        best = arm.optimise(pose, name, **PARAMETERS[name], tolerance=0.0).value
        if sign * printed.value <= sign * best + 0.01 * abs(best) + 1e-6:
            assert -sign * printed.second_value >= -sign * exact.second_value - 1e-6
            same += abs(printed.second_value - exact.second_value) < 1e-6
    assert same > 0


def test_from_the_optimum_it_stays():
    arm = arms.load("human_arm")
    for q in arms.configurations("human_arm", 3, 62):
        pose = arm.forward_kinematics(q)
        exact = arm.optimise(pose, "wrench", **PARAMETERS["wrench"])
        printed = printed_optimum(arm, pose, exact.objective, accuracy=ACCURACY, starts=exact.q)
        assert printed.reached == 1
        assert printed.value == pytest.approx(exact.value, abs=rounded(exact))


def test_a_position_alone_leaves_more_room_than_a_pose():
    arm = arms.load("iiwa14")
    pose = arm.forward_kinematics(arms.configurations("iiwa14", 1, 63)[0])
    exact = arm.optimise(pose, "manipulability")
    free = printed_optimum(arm, pose, "manipulability", constraint="position", starts=[exact.q])
    assert free.position_error < 1.01e-6
    assert free.value > exact.value


def test_without_limits_it_may_leave_them():
    arm = arms.load("human_arm")
    objective = Objective(lambda q: q[0])
    pose = arm.forward_kinematics(arms.configurations("human_arm", 1, 64)[0])
    kept = printed_optimum(arm, pose, objective, starts=5)
    free = printed_optimum(arm, pose, objective, starts=5, respect_limits=False)
    assert inside(kept.q, arm.lower, arm.upper)
    assert free.value <= kept.value + 1e-6


def test_out_of_reach_nothing_is_reached_and_the_error_is_told():
    arm = arms.load("iiwa14")
    pose = np.eye(4)
    pose[:3, 3] = 3.0, 0.0, 0.0
    printed = printed_optimum(arm, pose, "manipulability", starts=2)
    assert not printed
    assert printed.reached == len(printed.values) == 0
    assert printed.position_error > 1.0
    assert np.isfinite(printed.q).all()


def test_wrong_input_is_refused():
    arm, pose = arms.load("iiwa14"), np.eye(4)
    with pytest.raises(InvalidTask, match="constraint must be"):
        printed_optimum(arm, pose, "manipulability", constraint="wrist")
    with pytest.raises(InvalidTask, match="accuracy must be"):
        printed_optimum(arm, pose, "manipulability", accuracy=0.0)
    with pytest.raises(InvalidTask, match="accuracy must be"):
        printed_optimum(arm, pose, "manipulability", accuracy="high")
    with pytest.raises(InvalidPose):
        printed_optimum(arm, np.diag([1.0, 1.0, -1.0, 1.0]), "manipulability")
    with pytest.raises(InvalidTask, match="at least one start"):
        printed_optimum(arm, pose, "manipulability", starts=0)
    with pytest.raises(InvalidConfiguration, match="a start"):
        printed_optimum(arm, pose, "manipulability", starts=[[0.0] * 6])
    for none in (np.empty((0, 7)), []):
        with pytest.raises(InvalidTask, match="at least one start"):
            printed_optimum(arm, pose, "manipulability", starts=none)
    for wrong in ("many", [[0.0], [0.0, 1.0]], None, True, 2.5, np.zeros((2, 2, 7))):
        with pytest.raises(InvalidConfiguration, match="start"):
            printed_optimum(arm, pose, "manipulability", starts=wrong)
    for wrong in (-1, 0.5, None, "0", True):
        with pytest.raises(InvalidTask, match="seed must be a whole number from 0"):
            printed_optimum(arm, pose, "manipulability", seed=wrong)
    with pytest.raises(InvalidTask, match="constraint must be"):
        printed_optimum(arm, pose, "manipulability", constraint=np.array(["pose", "position"]))
