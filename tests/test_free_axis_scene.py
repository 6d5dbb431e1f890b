"""Poses that leave a turn free, in a scene: answers hit nothing, and no turn of a sample has a better one."""

import math

import arms
import coal
import numpy as np
import pinocchio as pin
import pytest
from collision_oracle import Truth, clearance, file_of_and
from scene_sets import made, scene_of

import srs_ik
from srs_ik import FreeAxis, InvalidTask, Status

AXIS = np.array([0.0, 0.0, 1.0])
CLOSED_IN = 1e-3
"""How much nearer to the seed, squared rad, a posture at one of 90 rolls may be."""


@pytest.fixture(scope="module")
def arm():
    return srs_ik.load("iiwa14")


def left(name, free, q, T):
    """Distance, and angle of the axis beyond its cone, by Pinocchio on the robot's file."""
    tip = arms.forward(name)(q)
    has, wants = tip.rotation @ free.axis, T[:3, :3] @ free.axis
    lean = math.atan2(np.linalg.norm(np.cross(has, wants)), has @ wants)
    return np.linalg.norm(tip.translation - T[:3, 3]), max(lean - free.cone, 0.0)


def rolled(T, axis, angle):
    turned = T.copy()
    turned[:3, :3] = T[:3, :3] @ pin.exp3(angle * axis)
    return turned


def postures(count, salt):
    """Bent, with no joint near its limits."""
    rng = arms.generator("iiwa14", salt)
    return rng.uniform([-1.2, 0.2, -1.2, -1.8, -1.2, 0.3, -1.2], [1.2, 1.0, 1.2, -0.8, 1.2, 1.2, 1.2], (count, 7))


def hindered(arm, q, axis):
    """A scene with a ball beside the elbow of a posture, which touches it, and its pose, rolled."""
    pose = arm.forward_kinematics(q).homogeneous
    elbow = arm.joint_frames(q)[4, :3, 3]
    out = np.cross(pose[:3, 3], elbow)
    scene = srs_ik.Scene()
    scene.add_sphere("ball", elbow + 0.1 * out / np.linalg.norm(out), 0.06)
    return scene, rolled(pose, axis, -0.4)


@pytest.mark.slow
@pytest.mark.parametrize("free", [FreeAxis(AXIS), FreeAxis(AXIS, cone=0.2)])
def test_the_answer_meets_the_pose_and_hits_nothing(arm, free):
    tried = 0
    for q in postures(12, 7):
        scene, pose = hindered(arm, q, AXIS)
        found = arm.solve(pose, seed=q, free_axis=free, scene=scene)
        assert found.status in (Status.OK, Status.COLLISION)
        if not found:
            continue
        tried += 1
        assert max(left("iiwa14", free, found.q, pose)) < 1e-9
        assert max(found.position_error, found.orientation_error) < 1e-9
        assert clearance(arm, arm.tables(scene), found.q) > -1e-9
        assert ((found.q >= arm.lower) & (found.q <= arm.upper)).all()
        # The posture of the seed itself is met by the pose, but hits the ball.
        assert ((found.q - q) ** 2).sum() > 1e-3
    assert tried >= 6


@pytest.mark.slow
def test_no_turn_of_a_dense_sample_has_a_nearer_posture(arm):
    better = 0
    for q in postures(5, 8):
        scene, pose = hindered(arm, q, AXIS)
        found = arm.solve(pose, seed=q, free_axis=AXIS, scene=scene)
        sweep = [arm.solve(rolled(pose, AXIS, angle), seed=q, scene=scene) for angle in np.arange(90) * math.pi / 45.0]
        nearest = min((((each.q - q) ** 2).sum() for each in sweep if each), default=np.inf)
        assert bool(found) == math.isfinite(nearest)
        if found:
            assert ((found.q - q) ** 2).sum() <= nearest + CLOSED_IN
            better += ((found.q - q) ** 2).sum() < nearest
    assert better


def test_where_nothing_is_in_the_way_the_answer_is_the_one_without_a_scene(arm):
    scene = srs_ik.Scene()
    scene.add_sphere("far", [3.0, 0.0, 0.0], 0.1)
    for q in postures(5, 9):
        pose = rolled(arm.forward_kinematics(q).homogeneous, AXIS, 1.0)
        alone, found = (arm.solve(pose, seed=q, free_axis=AXIS, **around) for around in ({}, {"scene": scene}))
        np.testing.assert_allclose(found.q, alone.q, atol=1e-12)


def test_statuses_say_what_is_the_matter(arm):
    q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    pose = arm.forward_kinematics(q).homogeneous
    scene = srs_ik.Scene()
    scene.add_sphere("wall", pose[:3, 3], 0.1)
    found = arm.solve(pose, seed=q, free_axis=AXIS, scene=scene)
    assert found.status == Status.COLLISION
    assert found.collision is not None
    assert "collides" in found.message or "hits" in found.message or found.collision.first in found.message
    pose[:3, 3] *= 4.0
    assert arm.solve(pose, free_axis=AXIS, scene=scene).status == Status.UNREACHABLE
    with pytest.raises(InvalidTask, match="does not go with arm_angle"):
        arm.solve(pose, arm_angle=0.0, free_axis=AXIS, scene=scene)


def test_a_batch_gives_what_single_calls_give(arm):
    scene = scene_of(made("shelf", arm, arms.generator("iiwa14", 3)))
    seeds = arms.configurations("iiwa14", 6, 11)
    poses = np.array([arm.forward_kinematics(each).homogeneous for each in arms.configurations("iiwa14", 6, 12)])
    many = arm.solve_batch(poses, seed=seeds, free_axis="any", scene=scene)
    for i, T in enumerate(poses):
        one = arm.solve(T, seed=seeds[i], free_axis="any", scene=scene)
        assert many.status[i] == one.status
        np.testing.assert_allclose(many.q[i], one.q, atol=1e-12)
        assert many[i].collision == one.collision


def test_what_is_named_is_in_the_way_where_the_arm_comes_nearest_to_being_free(arm):
    """A wall through the tip hits it at every turn, also where the arm's own links meet: no pair is deeper."""
    rng, truth_of = arms.generator("walls", 1), file_of_and(arm)
    for q in postures(8, 10):
        pose = arm.forward_kinematics(q).homogeneous
        T = srs_ik.pose_from_xyz_rpy(pose[:3, 3], rng.uniform(-3.0, 3.0, 3))
        scene = srs_ik.Scene()
        scene.add_box("wall", T, [1.0, 1.0, 0.04])
        found = arm.solve(pose, seed=q, free_axis=AXIS, scene=scene)
        assert found.status == Status.COLLISION
        assert "wall" in (found.collision.first, found.collision.second)
        truth = Truth(*truth_of)
        truth.add("wall", T.homogeneous, coal.Box(1.0, 1.0, 0.04))
        deepest, between = truth.deepest(found.q)
        assert "wall" in between
        assert abs(found.collision.depth - deepest) < 1e-3


BOXES = (
    ((0.5, 0.2, 0.3), (0.2, 0.2, 0.6)),
    ((-0.3, 0.5, 0.6), (0.2, 0.2, 0.4)),
    ((0.0, -0.5, 0.5), (0.5, 0.1, 0.2)),
    ((0.5, -0.2, 0.9), (0.2, 0.2, 0.2)),
)


@pytest.mark.slow
def test_turns_of_which_spheres_leave_nothing_are_asked_of_the_real_shapes():
    arm, scene = srs_ik.load("iiwa14"), srs_ik.Scene()
    for k, (place, size) in enumerate(BOXES):
        scene.add_box(f"box {k}", srs_ik.pose_from_xyz_rpy(place, [0, 0, 0]), size)
    rng, met = np.random.default_rng(1), 0
    seeds = [([-1.39, 1.93, -0.1, 2.07, 1.35, -1.88, 2.67], [-1.5, 2.0, -0.5, 2.1, 1.3, -1.9, 3.1], 2.46)]
    for _ in range(40):
        q = rng.uniform(arm.lower, arm.upper)
        seeds.append((q, np.clip(q + rng.uniform(-0.5, 0.5, 7), arm.lower, arm.upper), rng.uniform(-3.0, 3.0)))
    for q, near, roll in seeds:
        pose = arm.forward_kinematics(q).homogeneous
        held = arm.solve(pose, seed=near, scene=scene)
        found = arm.solve(rolled(pose, AXIS, roll), seed=near, free_axis=AXIS, scene=scene)
        met += bool(held)
        # The roll as it was is one of those that are free.
        assert not held or (found and np.linalg.norm(found.q - near) <= np.linalg.norm(held.q - near) + 1e-3)
    assert met > 20
