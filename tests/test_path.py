"""Joint paths: continuous, inside limits, on their poses, and no longer than they have to be."""

import numpy as np
import pytest

import srs_ik

BENT = np.array([0.3, 0.4, 0.2, -1.0, 0.3, 0.7, 0.1])


def through(joint, name="iiwa14", count=201):
    """Poses of a joint path that takes one joint through its singular middle."""
    arm = srs_ik.load(name)
    path = np.tile(BENT, (count, 1))
    if joint == 5:
        path[:, 3] += 0.3
    path[:, joint] = np.linspace(-0.4, 0.4, count)
    return arm, path, np.array([arm.forward_kinematics(q).homogeneous for q in path])


def moved(arm, q, offsets):
    """One pose, moved by offsets (n, 3)."""
    poses = np.repeat(arm.forward_kinematics(q).homogeneous[None], len(offsets), 0)
    poses[:, :3, 3] += offsets
    return poses


def assert_follows(arm, poses, path):
    assert path
    assert path.ok.all()
    assert ((path.q >= arm.lower) & (path.q <= arm.upper)).all()
    assert max(max(arm.verify(pose, q)) for pose, q in zip(poses, path.q, strict=True)) < 1e-9


@pytest.mark.parametrize("name", ["iiwa14", "gen3"])
@pytest.mark.parametrize("joint", [1, 3, 5])
def test_a_path_through_a_singularity_takes_no_longer_steps_than_the_known_one(name, joint):
    arm, known, poses = through(joint, name)
    path = arm.solve_path(poses, seed=known[0])
    assert_follows(arm, poses, path)
    step = np.abs(np.diff(known, axis=0)).max()
    assert path.largest_step < 1.2 * step
    assert np.abs(path.q[0] - known[0]).max() < 1.2 * step


@pytest.mark.parametrize("name", ["iiwa14", "gen3", "human_arm"])
def test_a_circle_is_continuous(name):
    arm = srs_ik.load(name)
    q = [0.3, 0.2, -0.3, -1.2, 0.1, 0.2, 0.0] if name == "human_arm" else [0.2, 0.6, 0.1, -1.2, 0.2, 0.8, 0.1]
    turn = np.linspace(0.0, 2.0 * np.pi, 120)
    offsets = 0.08 * np.stack([0.0 * turn, np.sin(turn), np.cos(turn) - 1.0], axis=1)
    poses = moved(arm, q, offsets)
    path = arm.solve_path(poses)
    assert_follows(arm, poses, path)
    assert path.steps.shape == (119, 7)
    assert path.largest_step < 0.03


def test_a_path_is_no_longer_than_the_greedy_one():
    arm = srs_ik.load("iiwa14")
    poses = moved(arm, [0.2, 0.6, 0.1, -1.2, 0.2, 0.8, 0.1], np.linspace([0, 0, 0], [0.1, 0.3, -0.1], 60))
    path = arm.solve_path(poses)
    greedy = [path.q[0]]
    for pose in poses[1:]:
        greedy.append(arm.solve(pose, seed=greedy[-1]).q)
    assert (path.steps**2).sum() <= (np.diff(greedy, axis=0) ** 2).sum() + 1e-9


@pytest.mark.parametrize("name", ["iiwa14", "human_arm"])
def test_postures_on_limits_are_not_past_them(name):
    """Not by rounding either: a path along the limits, as joint lines between random postures make it."""
    arm = srs_ik.load(name)
    for case in (15, 18, 41):
        ends = 1.1 * np.random.default_rng(case).uniform(arm.lower, arm.upper, (2, 7))
        known = np.linspace(*np.clip(ends, arm.lower, arm.upper), 30)
        path = arm.solve_path([arm.forward_kinematics(q) for q in known])
        assert np.maximum(arm.lower - path.q, path.q - arm.upper).max() <= 0.0


def test_continuous_joints_go_on_turning():
    arm = srs_ik.load("gen3")
    turns = np.linspace(0.0, 4.0 * np.pi, 200)
    known = np.tile(BENT, (200, 1))
    known[:, 0] += turns
    poses = [arm.forward_kinematics(q) for q in known]
    path = arm.solve_path(poses, seed=known[0])
    assert path
    assert np.abs(np.diff(path.q, axis=0)).max() == pytest.approx(path.largest_step)
    assert (path.steps**2).sum() <= (np.diff(known, axis=0) ** 2).sum() + 1e-9
    assert np.abs(path.q).max() > np.pi


def test_out_of_reach_is_a_break_with_its_sample():
    arm = srs_ik.load("iiwa14")
    poses = moved(arm, [0.2, 0.6, 0.1, -1.2, 0.2, 0.8, 0.1], np.linspace([0, 0, 0], [0.8, 0, 0], 40))
    path = arm.solve_path(poses)
    assert not path
    first = path.breaks[0]
    assert not path.ok[first.sample]
    assert path.ok[: first.sample].all()
    assert f"Pose {first.sample} is not reached" in first.message
    assert np.isfinite(path.q).all()
    assert ((path.q >= arm.lower) & (path.q <= arm.upper)).all()


def test_a_step_too_long_is_a_break_with_its_joint():
    arm = srs_ik.load("iiwa14")
    poses = [arm.forward_kinematics(BENT), arm.forward_kinematics([-2.0, 1.2, 0.5, 1.2, -1.0, -0.9, 1.0])]
    path = arm.solve_path(poses, seed=BENT)
    assert path.ok.all()
    assert not path
    assert path.breaks[0].sample == 1
    assert path.breaks[0].joint in arm.joint_names
    assert path.breaks[0].jump == pytest.approx(path.largest_step)


def test_velocity_limits_are_kept_where_they_can_be():
    arm = srs_ik.load("iiwa14")
    poses = moved(arm, [0.2, 0.6, 0.1, -1.2, 0.2, 0.8, 0.1], np.linspace([0, 0, 0], [0.05, 0.2, 0.0], 50))
    path = arm.solve_path(poses, dt=0.02)
    assert_follows(arm, poses, path)
    assert (np.abs(path.steps) <= arm.velocity_limit * 0.02).all()


def test_no_poses_make_an_empty_path():
    path = srs_ik.load("iiwa14").solve_path(np.empty((0, 4, 4)))
    assert len(path) == 0
    assert path.q.shape == (0, 7)


@pytest.mark.parametrize("options", [{"dt": 0.0}, {"dt": "fast"}, {"longest_step": -1.0}, {"seed": [0.0] * 6}])
def test_wrong_options_are_refused(options):
    arm = srs_ik.load("iiwa14")
    with pytest.raises(srs_ik.InvalidConfiguration):
        arm.solve_path([arm.forward_kinematics(BENT)], **options)


def test_a_bad_pose_is_named():
    arm = srs_ik.load("iiwa14")
    poses = moved(arm, BENT, np.zeros((3, 3)))
    poses[1, 0, 3] = np.nan
    with pytest.raises(srs_ik.InvalidPose, match="1 of 3"):
        arm.solve_path(poses)


@pytest.mark.parametrize("robot", ["gen3", "iiwa14"])
@pytest.mark.parametrize("reached", [0, 1, 200])
def test_a_path_none_or_only_the_last_of_whose_poses_is_in_reach_is_answered(robot, reached):
    arm = srs_ik.load(robot)
    poses = np.tile(arm.forward_kinematics(0.5 * np.ones(7)).homogeneous, (max(reached, 2) + 1, 1, 1))
    poses[: len(poses) - reached, 0, 3] += 5.0
    for seed in (None, 0.4 * np.ones(7)):
        path = arm.solve_path(poses, seed=seed)
        assert path.ok.sum() == reached
        assert np.isfinite(path.q).all()
        assert path.breaks


@pytest.mark.parametrize("objective", ["sum_of_squares", "largest_step", "time"])
@pytest.mark.parametrize("lost", [[0], [1], [3, 4, 5], [7, 8], [0, 4, 8]])
def test_poses_that_are_not_reached_are_the_only_breaks_and_the_rest_costs_what_it_did(lost, objective):
    arm, q = srs_ik.load("iiwa14"), np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    poses = moved(arm, q, np.linspace([0, 0, 0], [0, 0.16, 0], 9))
    whole = arm.solve_path(poses, seed=q, objective=objective, dt=0.05)
    poses[lost, :3, 3] = 3.0, 0.0, 0.0
    path = arm.solve_path(poses, seed=q, objective=objective, dt=0.05)
    assert [each.sample for each in path.breaks] == lost
    np.testing.assert_array_equal(np.flatnonzero(~path.ok), lost)
    # Over a gap steps count in even parts, as if its poses lay on a straight line; the search for the largest step,
    # which is a local one, ends a few per cent above.
    above = 1.1 if objective == "largest_step" else 1.01
    assert path.lower_bound <= path.value < above * whole.value
    assert path.largest_step < above * whole.largest_step
    assert path.velocity_use.max() < 1.0
    met = path.q[path.ok]
    np.testing.assert_allclose(path.steps.sum(axis=0), met[-1] - met[0], atol=1e-12)


def test_behind_a_pose_that_is_not_reached_the_path_is_where_it_was():
    arm, q = srs_ik.load("gen3"), np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    poses = moved(arm, q, np.array([[0, 0, 0], [3, 0, 0], [0, 0, 0]]))
    path = arm.solve_path(poses, seed=q)
    np.testing.assert_allclose(path.q[[0, 2]], [q, q], atol=1e-7)
    assert path.value < 1e-12
    assert [each.sample for each in path.breaks] == [1]


def test_a_path_is_timed_straight_over_poses_that_are_not_reached():
    arm, q, limit = srs_ik.load("iiwa14"), np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2]), np.full(7, 5.0)
    poses = moved(arm, q, np.linspace([0, 0, 0], [0, 0.16, 0], 9))
    whole = arm.solve_path(poses, seed=q, objective="time", acceleration_limit=limit)
    poses[4, :3, 3] = 3.0, 0.0, 0.0
    path = arm.solve_path(poses, seed=q, objective="time", acceleration_limit=limit)
    assert path.value == path.times[-1] < 1.05 * whole.value
    assert (np.diff(path.times) > 0.0).all()


def test_a_jump_behind_a_gap_is_no_break_beside_that_of_the_gap():
    """And one elsewhere is."""
    arm = srs_ik.load("iiwa14")
    far = BENT + np.array([1.5, 0, 0, 0, 0, 0, 0])
    poses = np.array([arm.forward_kinematics(q).homogeneous for q in (BENT, BENT, far, far, BENT, BENT)])
    poses[1, :3, 3] = 3.0, 0.0, 0.0
    path = arm.solve_path(poses, seed=BENT)
    assert [each.sample for each in path.breaks] == [1, 4]
    assert path.breaks[1].jump > 0.5
    assert path.largest_step > 0.5


@pytest.mark.parametrize("asked", [{"free_axis": [0, 0, 1]}, {"scene": srs_ik.Scene()}, {"closed": True}])
def test_a_gap_is_the_only_break_whatever_else_is_asked_for(asked):
    arm, q = srs_ik.load("iiwa14"), np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    way = np.linspace([0, 0, 0], [0, 0.1, 0], 6)
    poses = moved(arm, q, np.vstack([way, way[4::-1]]))
    whole = arm.solve_path(poses, seed=q, **asked)
    poses[3, :3, 3] = 3.0, 0.0, 0.0
    path = arm.solve_path(poses, seed=q, **asked)
    assert [each.sample for each in path.breaks] == [3]
    assert path.value < 1.01 * whole.value


@pytest.mark.filterwarnings("error")
def test_times_that_no_velocity_can_keep_are_told_and_give_no_warning():
    arm, _, poses = through(1, count=5)
    for dt in (1e-12, 1e-320):
        use = arm.solve_path(poses, dt=dt).velocity_use
        assert (use > 1.0).all()
        assert np.isfinite(use).all()
