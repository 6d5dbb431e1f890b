"""Joint paths in scenes: what is called clear never collides, looked at densely by Pinocchio on the robot file."""

import json

import numpy as np
import pytest
from arms import generator
from collision_oracle import Truth, clearance, file_of
from command_line import answer, run
from scene_sets import KINDS, file_of_scene, geometry_of, made, scene_of

import srs_ik
from srs_ik.solve.in_scene.surroundings import Surroundings

BETWEEN = 6
"""Postures that are looked at between two poses, beside those of the poses."""


def motion(arm, rng, count, size=1.2):
    """(count, 7) a smooth joint motion inside the limits: two sines a joint."""
    lower = np.where(np.isfinite(arm.lower), arm.lower, -np.pi)
    upper = np.where(np.isfinite(arm.upper), arm.upper, np.pi)
    t = np.linspace(0.0, 1.0, count)[:, None]
    waves = sum(rng.uniform(-1, 1, 7) * np.sin(k * np.pi * t + rng.uniform(-3, 3, 7)) for k in (1, 2))
    middle = lower + (upper - lower) * rng.uniform(0.35, 0.65, 7)
    return np.clip(middle + 0.5 * size * waves, lower + 0.02, upper - 0.02)


def poses_of(arm, q):
    return np.array([arm.forward_kinematics(each).homogeneous for each in q])


def with_truth(name, kind, rng):
    arm = srs_ik.load(name)
    file, folders = file_of(arm)
    truth = Truth(file, arm, folders)
    objects = made(kind, arm, rng)
    for each in objects:
        truth.add(each.name, each.T, geometry_of(each))
    return arm, objects, truth


def lines_that_collide(path, truth):
    """How many lines of a path were looked at, and how many of those without a break hit something."""
    broken = {each.sample for each in path.breaks}
    looked = hits = 0
    for i, step in enumerate(path.steps):
        if i + 1 in broken or not (path.ok[i] and path.ok[i + 1]):
            continue
        looked += 1
        hits += any(truth.collides(path.q[i] + t * step) for t in np.linspace(0.0, 1.0, BETWEEN + 2))
    return looked, hits


def tried(name, kind, number, count, **scene):
    rng = generator(name + kind, number)
    arm, objects, truth = with_truth(name, kind, rng)
    path = arm.solve_path(poses_of(arm, motion(arm, rng, count)), scene=scene_of(objects, **scene), margin=0.005)
    return arm, objects, path, *lines_that_collide(path, truth)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ["iiwa14", "gen3"])
def test_lines_called_clear_never_collide(name, kind):
    _, _, path, looked, hits = tried(name, kind, 0, 40)
    assert hits == 0
    assert looked > 0 or path.breaks


def motion_in_free(arm, rng, scene):
    """(50, 7) a smooth joint motion inside the limits that hits nothing."""
    while True:
        q = motion(arm, rng, 50, 0.8)
        inside = (q > arm.lower + 0.02) & (q < arm.upper - 0.02)
        if inside.all() and not arm.path_collisions(q, scene):
            return q


def beside(arm):
    """A scene with a wall that the arm never reaches."""
    scene = srs_ik.Scene()
    scene.add_box("wall", srs_ik.pose_from_xyz_rpy([3.0, 0.0, 0.5], [0.0, 0.0, 0.3]), [0.1, 2.0, 2.0])
    return scene


@pytest.mark.parametrize("kind", ["none", "beside"])
@pytest.mark.parametrize("name", ["iiwa14", "gen3"])
def test_what_is_not_touched_makes_no_path_dearer(name, kind):
    arm = srs_ik.load(name)
    rng, scene = generator(name + kind), srs_ik.Scene() if kind == "none" else beside(arm)
    for _ in range(3):
        q = motion_in_free(arm, rng, scene)
        poses, least = poses_of(arm, q), (np.diff(q, axis=0) ** 2).sum()
        for known in ({}, {0: q[0], 25: q[25], 49: q[49]}):
            path = arm.solve_path(poses, seed=q[0], known=known, scene=scene)
            assert path
            assert path.value <= least * (1.0 + 1e-6)


@pytest.mark.parametrize(("name", "number"), [("iiwa14", 73), ("gen3", 28), ("gen3", 72)])
def test_around_what_is_in_the_way_no_path_costs_more_than_a_known_motion(name, number):
    arm = srs_ik.load(name)
    q = motion(arm, generator(name + "around", number), 40, 0.8)
    poses = poses_of(arm, q)
    through = arm.solve_path(poses).q
    elbows = [arm.joint_frames(each[20])[4, :3, 3] for each in (through, q)]
    away = elbows[0] - elbows[1]
    scene = srs_ik.Scene()
    scene.add_sphere("ball", elbows[0] + 0.04 * away / np.linalg.norm(away), 0.04)
    assert arm.path_collisions(through, scene)
    assert not arm.path_collisions(q, scene)
    path = arm.solve_path(poses, scene=scene)
    assert path
    assert not arm.path_collisions(path.q, scene)
    assert path.value <= (np.diff(q, axis=0) ** 2).sum() * (1.0 + 1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("number", range(5))
@pytest.mark.parametrize("kind", KINDS)
def test_twenty_scenes_of_two_hundred_poses(kind, number):
    _, _, path, looked, hits = tried("iiwa14", kind, 10 + number, 200)
    assert hits == 0
    assert all(each.message for each in path.breaks)
    print(f"{kind} {number}: {looked} lines, {len(path.breaks)} breaks, {path.solved} poses")


Q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])


@pytest.fixture(scope="module")
def arm():
    return srs_ik.load("iiwa14")


def line_of(arm, count, way=(-0.1, 0.4, 0.0)):
    poses = np.repeat(arm.forward_kinematics(Q).homogeneous[None], count, axis=0)
    poses[:, :3, 3] += np.linspace(0.0, 1.0, count)[:, None] * way
    return poses


def near_elbow(arm, path, radius=0.07):
    """A scene with a ball where the elbow of a path is in its middle."""
    scene = srs_ik.Scene()
    scene.add_sphere("ball", arm.joint_frames(path.q[len(path) // 2])[4, :3, 3], radius)
    return scene


@pytest.mark.slow
def test_a_path_goes_around_what_the_best_one_would_hit(arm):
    poses = line_of(arm, 50)
    through = arm.solve_path(poses)
    scene = near_elbow(arm, through)
    around = arm.solve_path(poses, scene=scene, margin=0.01)
    assert around
    assert np.abs(around.steps).max() < 0.5
    assert around.value == pytest.approx((around.steps**2).sum())
    assert through.value < around.value
    assert 0.0 < around.lower_bound <= through.value
    tables = arm.tables(scene)
    assert min(clearance(arm, tables, q) for q in through.q) < 0.0
    between = [q + t * step for q, step in zip(around.q, around.steps, strict=False) for t in (0.0, 0.3, 0.6)]
    assert min(clearance(arm, tables, q) for q in between) >= 0.01 - 1e-9


def test_a_pose_that_nothing_frees_names_two_bodies(arm):
    poses = line_of(arm, 30)
    scene = srs_ik.Scene()
    scene.add_sphere("lamp", poses[15, :3, 3], 0.03)
    path = arm.solve_path(poses, scene=scene)
    assert not path
    missed = [each for each in path.breaks if each.sample == 15]
    assert missed[0].bodies == ("iiwa_link_7", "lamp")
    assert "iiwa_link_7" in missed[0].message
    assert "lamp" in missed[0].message
    assert path[15].status is srs_ik.Status.COLLISION
    assert path[15].collision.second == "lamp"
    assert path[0].status is srs_ik.Status.OK


def test_what_is_only_between_two_poses_is_seen(arm):
    # The tip passes a thin pole between two poses a hand's breadth apart: each pose alone is free.
    poses = line_of(arm, 4, (0.0, 0.5, 0.0))[:3]
    scene = srs_ik.Scene()
    middle = 0.5 * (poses[1, :3, 3] + poses[2, :3, 3])
    scene.add_sphere("pole", middle, 0.004)
    path = arm.solve_path(poses, scene=scene, longest_step=2.0)
    assert path.ok.all()
    assert not path
    (only,) = path.breaks
    assert only.sample == 2
    assert only.bodies[1] == "pole"
    assert "Between poses 1 and 2" in only.message
    near = [np.linspace(path.q[1], path.q[2], 200)]
    assert min(clearance(arm, arm.tables(scene), q) for q in near[0]) < 0.0


def test_a_break_says_what_is_in_the_way(arm):
    # A wall grows across the free arm angles: the elbow has to be on one side before, and on the other behind it.
    poses = line_of(arm, 40)
    path = arm.solve_path(poses)
    scene = srs_ik.Scene()
    for k, q in enumerate(path.q[::4]):
        scene.add_sphere(f"wall {k}", arm.joint_frames(q)[4, :3, 3], 0.12)
    around = arm.solve_path(poses, scene=scene, seed=path.q[0] + 0.0)
    assert all(each.bodies is None or each.bodies[0] in {b.name for b in arm.bodies} for each in around.breaks)
    tables = arm.tables(scene)
    assert all(clearance(arm, tables, q) >= -1e-9 for q, ok in zip(around.q, around.ok, strict=True) if ok)


def test_a_known_posture_that_hits_something_is_refused(arm):
    poses = line_of(arm, 10)
    scene = srs_ik.Scene()
    scene.add_sphere("ball", arm.joint_frames(Q)[4, :3, 3], 0.07)
    with pytest.raises(srs_ik.InvalidConfiguration, match=r"pose 0, iiwa_link_. meets ball"):
        arm.solve_path(poses, known={0: Q}, scene=scene)


def test_an_empty_path_and_one_pose(arm):
    assert len(arm.solve_path(np.empty((0, 4, 4)), scene=srs_ik.Scene())) == 0
    assert arm.solve_path(line_of(arm, 1), scene=srs_ik.Scene())


def test_a_closed_path(arm):
    out = line_of(arm, 15)
    poses = np.concatenate([out, out[-2::-1]])
    scene = near_elbow(arm, arm.solve_path(poses))
    path = arm.solve_path(poses, closed=True, scene=scene)
    assert path
    assert np.abs(path.q[0] - path.q[-1]).max() < 1e-9
    assert min(clearance(arm, arm.tables(scene), q) for q in path.q) >= 0.0


def test_real_shapes_go_where_spheres_do_not(arm):
    rng = generator("iiwa14", 8)
    arm, objects, truth = with_truth("iiwa14", "cage", rng)
    path = arm.solve_path(line_of(arm, 8), scene=scene_of(objects, exact=True), margin=0.002)
    looked, hits = lines_that_collide(path, truth)
    assert hits == 0
    assert looked > 0 or path.breaks


def test_where_spheres_leave_nothing_a_path_goes_by_real_shapes(arm):
    # A ball beside the hand: at each pose the spheres always meet it, and the shapes leave a wide interval.
    places = [[0.5, 0.1 + 0.01 * k, 0.6] for k in range(5)]
    poses = srs_ik.pose_from_xyz_rpy(places, [[0.0, 1.5707963, 0.0]] * 5)
    scene = srs_ik.Scene()
    scene.add_sphere("ball", [0.6, 0.3, 0.7], 0.1)
    assert not any(len(Surroundings(arm, arm.packed, scene, 0.0).all_free(T, True)) for T in poses)
    path = arm.solve_path(poses, scene=scene)
    assert path
    assert not arm.path_collisions(path.q, scene)
    far = poses.copy()
    far[2, 0, 3] = 5.0
    broken = arm.solve_path(far, scene=scene)
    assert [each.sample for each in broken.breaks] == [2]


def test_given_postures_are_refused_for_what_they_hit_by_the_real_shapes_alone(arm):
    poses = srs_ik.pose_from_xyz_rpy([[0.5, 0.1 + 0.01 * k, 0.6] for k in range(3)], [[0.0, 1.5707963, 0.0]] * 3)
    for exact in (False, True):
        scene = srs_ik.Scene(exact=exact)
        scene.add_sphere("ball", [0.6, 0.3, 0.7], 0.1)
        clear, hits = arm.solve(poses[0], 1.0, scene=scene), arm.solve(poses[2], -0.2)
        assert clear
        assert arm.collision(hits.q, scene)
        path = arm.solve_path(poses, known={0: clear.q}, scene=scene)
        assert path
        assert (path.q[0] == clear.q).all()
        for still in (poses[:1], poses[[0, 0, 0]]):
            assert arm.solve_path(still, scene=scene)
        with pytest.raises(srs_ik.InvalidConfiguration, match="pose 2, iiwa_link_6 meets ball"):
            arm.solve_path(poses, known={2: hits.q}, scene=scene)


def test_a_path_with_a_free_roll_goes_by_real_shapes_too(arm):
    # The ball is straight ahead of the hand, whatever its roll.
    poses = srs_ik.pose_from_xyz_rpy([[0.5, 0.1 + 0.01 * k, 0.6] for k in range(3)], [[0.0, 1.5707963, 0.0]] * 3)
    scene = srs_ik.Scene()
    scene.add_sphere("ball", [0.66, 0.11, 0.6], 0.1)
    path = arm.solve_path(poses, free_axis=[0.0, 0.0, 1.0], scene=scene)
    assert path
    assert not arm.path_collisions(path.q, scene)


def test_the_command(arm, tmp_path):
    poses = line_of(arm, 12)
    rows = ["x,y,z,roll,pitch,yaw"]
    rows += [",".join(f"{x:.12g}" for x in (*T[:3, 3], *_rpy(T))) for T in poses]
    (tmp_path / "poses.csv").write_text("\n".join(rows))
    objects = made("table", arm, generator("iiwa14", 9))
    (tmp_path / "scene.json").write_text(json.dumps(file_of_scene(objects)))
    words = "path", "iiwa14", str(tmp_path / "poses.csv"), "--scene", str(tmp_path / "scene.json"), "--margin", "0.01"
    found = answer(*words)
    wanted = arm.solve_path(poses, scene=scene_of(objects), margin=0.01)
    # Shoulder and wrist may be turned over at the same cost.
    assert (np.diff(found["q"], axis=0) ** 2).sum() == pytest.approx(wanted.value, rel=1e-6)
    tables = arm.tables(scene_of(objects))
    for T, q in zip(poses, found["q"], strict=True):
        assert max(arm.verify(T, q)) < 1e-8
        assert clearance(arm, tables, np.array(q)) > 0.0
    (tmp_path / "all.json").write_text('{"objects": [{"name": "all", "sphere": 3}]}')
    refused = run(*words[:4], str(tmp_path / "all.json"))
    assert refused.exit_code == 1
    assert "all" in refused.stderr


def _rpy(T):
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(T[:3, :3]).as_euler("xyz")


def test_a_path_of_which_every_pose_hits_something_is_told_pose_by_pose():
    arm = srs_ik.load("iiwa14")
    poses = poses_of(arm, motion(arm, generator("all hit"), 40))
    scene = srs_ik.Scene()
    scene.add_sphere("ball around the shoulder", [0.0, 0.0, 0.36], 0.3)
    path = arm.solve_path(poses, scene=scene)
    assert not path.ok.any()
    assert {int(status) for status in path.status} == {int(srs_ik.Status.COLLISION)}
    assert np.isfinite(path.q).all()
    assert path.breaks
