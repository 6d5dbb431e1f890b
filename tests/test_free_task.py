"""Tasks that leave a turn of the hand free: what is to be kept is kept, and no turn of a dense grid is better."""

import arms
import numpy as np
import pinocchio as pin
import pytest

from srs_ik import FreeAxis, InvalidTask, Task
from srs_ik.errors import SrsIkError

BETTER = 2e-4
"""How much closer to the plane of its task, rad, a turn of the grid may be: distances from the seed count, too."""

Z = np.array([0.0, 0.0, 1.0])
AXES = ([0.0, 0.0, 1.0], [0.6, -0.3, 0.8])


def random_task(name, salt):
    """A task with a hand that a random posture has."""
    rng = arms.generator(name, salt)
    q = arms.configurations(name, 1, salt)[0]
    tip = arms.forward(name)(q)
    velocity, force, grasp, across = rng.normal(size=(4, 3))
    return Task(tip.translation, velocity, force, grasp, across)


def plane_off(arm, task, q):
    """Angle between the plane of shoulder, elbow and wrist of joint angles and that of a task, without the package."""
    posture = arm.solve_task(task).posture
    normal = np.cross(task.velocity, task.force)
    own = np.cross(posture.elbow - posture.shoulder, posture.wrist - posture.elbow)
    cosine = abs(own @ normal) / np.linalg.norm(own) / np.linalg.norm(normal)
    return np.arccos(min(cosine, 1.0))


def turned(task, R, turn):
    """The task with its hand turned in the tip frame."""
    by = R @ turn @ R.T
    return Task(task.position, task.velocity, task.force, by @ task.grasp, by @ task.pronosupination)


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("name", arms.here("human_arm", "iiwa14"))
def test_no_roll_of_a_dense_grid_serves_the_task_better(name, axis):
    arm, free = arms.load(name), FreeAxis(axis)
    compared = 0
    for salt in range(6):
        task = random_task(name, 300 + salt)
        R = arm.solve_task(task).T_base_tip[:3, :3]
        found = arm.solve_task(task, free_axis=axis)
        best = np.inf
        for angle in np.linspace(-np.pi, np.pi, 360, endpoint=False):
            other = turned(task, R, pin.exp3(angle * free.axis))
            rival = arm.solve_task(other)
            if rival:
                best = min(best, plane_off(arm, other, rival.q) + rival.angle_lost)
        if np.isfinite(best):
            compared += 1
            assert found
            tip = arms.forward(name)(found.q)
            np.testing.assert_allclose(tip.translation, task.position, atol=1e-9)
            np.testing.assert_allclose(tip.rotation @ free.axis, R @ free.axis, atol=1e-9)
            at_best = turned(task, R, R.T @ found.T_base_tip[:3, :3])
            assert plane_off(arm, at_best, found.q) + found.angle_lost <= best + BETTER
    assert compared >= 2


@pytest.mark.parametrize("name", arms.here("human_arm", "iiwa14"))
def test_a_turn_that_narrow_limits_leave_is_found(name):
    """Limits leave little more than one posture, whose hand leans from that of the task, but within the cone."""
    rng = arms.generator(name, 330)
    for q in arms.configurations(name, 12, 331):
        tip, hand = arms.forward(name)(q), arms.load(name).hand
        arm = arms.load(name).with_limits(lower=q - 0.03, upper=q + 0.03)
        lean = pin.exp3(0.15 * rng.uniform(0.5, 1.0) * pin.exp3(rng.uniform(0.0, 6.0) * Z)[:, 0])
        velocity, force = rng.normal(size=(2, 3))
        grasp, across = (tip.rotation @ lean @ axis for axis in hand)
        found = arm.solve_task(Task(tip.translation, velocity, force, grasp, across), free_axis=FreeAxis(Z, cone=0.15))
        assert found
        reached = arms.forward(name)(found.q)
        np.testing.assert_allclose(reached.translation, tip.translation, atol=1e-9)
        assert FreeAxis(Z, cone=0.15).lean(reached.rotation, tip.rotation @ lean) < 1e-9


def test_within_a_cone_it_is_no_worse_than_the_roll_alone():
    arm = arms.load("human_arm")
    for salt in range(3):
        task = random_task("human_arm", 320 + salt)
        R = arm.solve_task(task).T_base_tip[:3, :3]
        free = FreeAxis([0, 0, 1], cone=0.3)
        roll, cone = arm.solve_task(task, free_axis=[0, 0, 1]), arm.solve_task(task, free_axis=free)
        assert bool(cone) >= bool(roll)
        if cone:
            tip = arms.forward("human_arm")(cone.q)
            np.testing.assert_allclose(tip.translation, task.position, atol=1e-9)
            assert free.lean(tip.rotation, R) < 1e-9
        if roll:
            costs = []
            for found in (roll, cone):
                normals = np.abs(found.posture.normal @ found.posture.task_normal)
                costs.append(np.arccos(min(normals, 1.0)) + found.angle_lost)
            assert costs[1] <= costs[0] + 0.02


def test_many_tasks_are_those_one_by_one():
    arm = arms.load("human_arm")
    tasks = [random_task("human_arm", 340 + k) for k in range(3)]
    fields = ("position", "velocity", "force", "grasp", "pronosupination")
    many = Task(*(np.array([getattr(task, field) for task in tasks]) for field in fields))
    seed = 0.5 * (arm.lower + arm.upper)
    whole = arm.solve_task(many, free_axis=[0, 0, 1], seed=seed)
    for task, found in zip(tasks, whole, strict=True):
        np.testing.assert_array_equal(found.q, arm.solve_task(task, free_axis=[0, 0, 1], seed=seed).q)


def test_a_hand_whose_rotation_is_open_has_no_axis_to_be_freed():
    with pytest.raises(InvalidTask, match="give the task grasp and pronosupination"):
        arms.load("human_arm").solve_task(Task([0.4, 0.1, -0.2], [1, 0, 0], [0, 0, 1]), free_axis=[0, 0, 1])
    task = Task([0.4, 0.1, -0.2], [1, 0, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0])
    with pytest.raises(SrsIkError, match="free_axis"):
        arms.load("human_arm").solve_task(task, free_axis="z")
