"""`Arm.intervals_batch`: the intervals of one call at a time, bit for bit, on any number of threads."""

from concurrent.futures import ThreadPoolExecutor

import arms
import numpy as np
import pinocchio as pin
import pytest

from srs_ik import Interval, InvalidPose, SrsIkError
from srs_ik.kernels.layout.answer import MOST_INTERVALS
from srs_ik.solve import intervals as feasible

COUNT = {"iiwa14": 120, "romeo_left": 120, "gen3": 24}


def poses_of(name):
    """Poses inside the limits and outside, within reach and out of it."""
    arm, half = arms.load(name), COUNT[name] // 2
    q = np.vstack([arms.configurations(name, half, 61), arms.generator(name, 62).uniform(-3, 3, (half, 7))])
    poses = np.array([arm.forward_kinematics(x).homogeneous for x in q])
    poses[::10, :3, 3] *= 3.0
    return q, poses


def assert_same(one, other):
    for field in ("branch", "lower", "upper", "offsets"):
        assert getattr(one, field).tobytes() == getattr(other, field).tobytes(), field


@pytest.mark.parametrize("respect_limits", [True, False])
@pytest.mark.parametrize("name", list(COUNT))
def test_intervals_are_those_of_single_calls(name, respect_limits):
    arm = arms.load(name)
    _, poses = poses_of(name)
    batch = arm.intervals_batch(poses, respect_limits=respect_limits, threads=1)
    assert_same(batch, arm.intervals_batch(poses, respect_limits=respect_limits, threads=2))
    assert_same(batch, arm.intervals_batch(poses, respect_limits=respect_limits))
    single = [arm.intervals(pose, respect_limits=respect_limits) for pose in poses]
    assert list(batch) == single
    assert [batch[i] for i in range(-len(poses), 0)] == single
    assert batch.counts.tolist() == [len(each) for each in single]
    assert min(batch.counts) == 0 < max(batch.counts)
    assert len(batch) == len(poses)
    assert batch.width.tolist() == [interval.width for each in single for interval in each]
    assert repr(batch) == f"IntervalsBatch({len(batch.branch)} intervals of {len(poses)} poses)"


@pytest.mark.parametrize("name", ["iiwa14", "gen3"])
def test_middles_of_intervals_are_postures_for_pinocchio(name):
    arm, forward = arms.load(name), arms.forward(name)
    q, poses = poses_of(name)
    batch = arm.intervals_batch(poses[: len(q) // 2])
    seen = 0
    for i, intervals in enumerate(batch):
        for interval in intervals:
            solution = arm.solve(poses[i], 0.5 * (interval.lower + interval.upper), branch=interval.branch)
            assert solution
            reached = forward(solution.q).homogeneous
            assert np.abs(reached - poses[i]).max() < arms.tolerance(name)
            assert (solution.q >= arm.lower).all()
            assert (solution.q <= arm.upper).all()
            seen += 1
    assert seen == len(batch.branch) > len(batch)


def test_small_blocks_give_the_same(monkeypatch):
    arm = arms.load("iiwa14")
    _, poses = poses_of("iiwa14")
    expected = arm.intervals_batch(poses)
    for block in (MOST_INTERVALS, MOST_INTERVALS + 1, 2 * MOST_INTERVALS):
        monkeypatch.setattr(feasible, "BLOCK", block)
        assert_same(arm.intervals_batch(poses), expected)
        assert_same(arm.intervals_batch(poses, threads=1), expected)


def test_many_python_threads_at_once():
    arm = arms.load("iiwa14")
    _, poses = poses_of("iiwa14")
    expected = arm.intervals_batch(poses, threads=1)
    with ThreadPoolExecutor(6) as pool:
        for found in pool.map(lambda _: arm.intervals_batch(poses, threads=2), range(12)):
            assert_same(found, expected)


def test_no_pose_one_pose_and_other_forms():
    arm = arms.load("iiwa14")
    empty = arm.intervals_batch([])
    assert len(empty) == 0
    assert list(empty) == []
    assert empty.offsets.tolist() == [0]
    assert empty.branch.shape == empty.lower.shape == empty.upper.shape == (0,)
    pose = arm.forward_kinematics(np.full(7, 0.3))
    one = arm.intervals_batch([pose])
    assert one[0] == one[-1] == arm.intervals(pose)
    assert all(type(interval) is Interval and type(interval.branch) is int for interval in one[0])
    for wrong in (1, -2):
        with pytest.raises(IndexError):
            one[wrong]


def test_parts_of_a_batch_are_those_of_its_poses():
    arm = arms.load("iiwa14")
    _, poses = poses_of("iiwa14")
    batch = arm.intervals_batch(poses)
    odd = np.arange(len(poses)) % 2 == 1
    for part in (slice(3, 40, 4), slice(None, None, -1), slice(5, 5), [7, 0, 7], odd):
        assert_same(batch[part], arm.intervals_batch(poses[part]))
    with pytest.raises(IndexError, match="there is no pose 120 of 120"):
        batch[120]
    for wrong in (0.5, "a", (0, 1)):
        with pytest.raises(IndexError):
            batch[wrong]


def test_the_whole_circle_and_nothing():
    arm = arms.load("human_arm")
    far = np.eye(4)
    far[0, 3] = 9.0
    near = arm.forward_kinematics([0.1, 0.2, 0.3, -1.0, 0.2, 0.3, 0.1]).homogeneous
    batch = arm.intervals_batch([far, near, far], respect_limits=False)
    assert batch.counts.tolist()[::2] == [0, 0]
    assert {(each.lower, each.upper) for each in batch[1]} >= {(-np.pi, np.pi)}


def test_threads_are_the_second_argument_as_of_reachable_batch():
    arm = arms.load("iiwa14")
    _, poses = poses_of("iiwa14")
    assert_same(arm.intervals_batch(poses[:16], 2), arm.intervals_batch(poses[:16], threads=1))
    assert_same(arm.intervals_batch(poses[:16], None, False), arm.intervals_batch(poses[:16], respect_limits=False))
    # What meant "without limits" before is refused, not read as no threads.
    with pytest.raises(SrsIkError, match="threads"):
        arm.intervals_batch(poses[:16], False)


def test_malformed_input_is_refused():
    arm = arms.load("iiwa14")
    _, poses = poses_of("iiwa14")
    for bad, value in (((70, 0, 3), np.nan), ((70, 1, 1), 4.0)):
        spoilt = poses.copy()
        spoilt[bad] = value
        for threads in (1, 2):
            with pytest.raises(InvalidPose, match=r"\b70\b"):
                arm.intervals_batch(spoilt, threads=threads)
    for malformed in (np.eye(4), 7, None, pin.SE3()):
        with pytest.raises(InvalidPose):
            arm.intervals_batch(malformed)
    with pytest.raises(SrsIkError, match="threads"):
        arm.intervals_batch(poses, threads=0)
