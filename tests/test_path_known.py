"""Postures that a path has to take, of arms whose joints turn without end: in the turns in which they are given."""

from functools import cache

import numpy as np
import pytest
from arms import file_of, forward, load

import srs_ik

TURN = 2.0 * np.pi

Q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
WAY = np.array([2.0, 0.3, -0.2, 0.3, 0.2, -0.4, 9.0])
MOTION = Q + np.linspace(0.0, 1.0, 60)[:, None] * WAY
"""Joint 7 turns more than once."""


@cache
def arm_without_ends(name, joints):
    """The exact arm, its joints of these numbers without ends; gen3 has four such joints."""
    if name == "gen3":
        return load(name)
    arm = load(name)
    none = {arm.joint_names[j]: {"lower": -np.inf, "upper": np.inf} for j in joints}
    return srs_ik.load(file_of(name), base=arm.base, tip=arm.tip, limits=none)


def poses_of(name, motion):
    return np.array([forward(name)(q).homogeneous for q in motion])


def turned(*turns):
    """Joints 1 and 7 turned by whole turns."""
    return TURN * np.array([turns[0], 0, 0, 0, 0, 0, turns[1]])


CASES = (("gen3", ()), ("made_offsets", (0, 2, 4, 6)), ("made_offsets", (0, 6)))


@pytest.mark.parametrize(("name", "joints"), CASES)
@pytest.mark.parametrize("turns", [(0, 0), (1, -1), (-3, 2)])
@pytest.mark.parametrize("poses", [(0,), (25,), (59,), (10, 40), (0, 30, 59)])
def test_a_posture_is_taken_in_the_turns_in_which_it_is_given(name, joints, turns, poses):
    arm, known = arm_without_ends(name, joints), MOTION + turned(*turns)
    path = arm.solve_path(poses_of(name, MOTION), known={i: known[i] for i in poses})
    assert path
    np.testing.assert_array_equal(path.q[list(poses)], known[list(poses)])
    assert np.abs(path.steps).max() < 0.5
    np.testing.assert_allclose(path.steps, np.diff(path.q, axis=0))


@pytest.mark.parametrize(("name", "joints"), CASES)
def test_a_given_posture_counts_for_more_than_the_seed(name, joints):
    arm, known = arm_without_ends(name, joints), MOTION + turned(1, -1)
    poses = poses_of(name, MOTION)
    seeded, both = arm.solve_path(poses, seed=known[0]), arm.solve_path(poses, seed=known[0], known={30: MOTION[30]})
    assert seeded
    assert both
    assert np.abs(seeded.q[0] - known[0]).max() < 0.5
    np.testing.assert_array_equal(both.q[30], MOTION[30])


@pytest.mark.parametrize(("name", "joints"), CASES)
def test_behind_a_break_a_given_posture_is_taken_as_it_is_given(name, joints):
    """Motions that nothing joins: those of the second half are in turns of their own."""
    arm, motion = arm_without_ends(name, joints), MOTION.copy()
    motion[30:] = MOTION[30:] * [1.0, -1.0, 1.0, 1.0, -1.0, 1.0, 1.0] + turned(2, -2)
    path = arm.solve_path(poses_of(name, motion), known={0: motion[0], 59: motion[59]})
    assert [each.sample for each in path.breaks]
    np.testing.assert_array_equal(path.q[[0, 59]], motion[[0, 59]])


@pytest.mark.parametrize(("name", "joints"), CASES)
def test_turns_are_counted_on_over_poses_that_are_not_reached(name, joints):
    arm, poses = arm_without_ends(name, joints), poses_of(name, MOTION)
    lost = [*range(20, 22), 41]
    poses[lost, :3, 3] += 9.0
    path = arm.solve_path(poses, known={30: MOTION[30]})
    kept = np.setdiff1d(np.arange(60), lost)
    assert path.ok[kept].all()
    assert not path.ok[lost].any()
    assert np.isfinite(path.q).all()
    np.testing.assert_array_equal(path.q[30], MOTION[30])
    assert np.abs(np.diff(path.q[kept], axis=0)).max() < 1.5
    # Those in place of what is not reached are no more than half a turn from the pose before.
    before = path.q[[19, 19, 40]]
    assert np.abs(path.q[lost] - before)[:, np.isinf(arm.upper)].max() <= 0.5 * TURN + 1e-9


@pytest.mark.parametrize("free_axis", [None, [0, 0, 1]])
def test_postures_of_poses_beyond_the_limits_do_not_turn_to_and_fro(free_axis):
    motion = Q + 0.02 * np.arange(80)[:, None]
    arm = load("gen3")
    found = arm.solve_path(poses_of("gen3", motion), free_axis=free_axis)
    unmet = ~found.ok
    endless = np.isinf(arm.upper)
    assert unmet.sum() > 2, "the last poses are beyond the limit of joint 2"
    between = np.diff(found.q, axis=0)[unmet[1:] | unmet[:-1]]
    assert np.abs(between[:, endless]).max() <= np.pi + 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("name", ["gen3", "iiwa14"])
@pytest.mark.parametrize("cone", [0.0, 0.3, np.pi])
def test_paths_with_a_free_axis_of_poses_out_of_reach_are_broken_everywhere(name, cone):
    poses = poses_of(name, MOTION[:6])
    poses[:, 0, 3] += 9.0
    for seed in (None, Q):
        found = load(name).solve_path(poses, seed=seed, free_axis=srs_ik.FreeAxis(cone=cone))
        assert not found.ok.any()
        assert len(found.breaks) == 6
        assert np.isfinite(found.q).all()


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_paths_with_a_free_axis_refuse_poses_that_are_none(bad):
    poses = poses_of("gen3", MOTION[:6])
    poses[3, 0, 3] = bad
    with pytest.raises(srs_ik.InvalidPose, match="3 of 6"):
        load("gen3").solve_path(poses, free_axis=srs_ik.FreeAxis())


def winding_path(begin, end, count, free):
    """Poses of a straight line of joint angles of gen3, each rolled on."""
    poses = poses_of("gen3", np.linspace(begin, end, count))
    for k, pose in enumerate(poses):
        pose[:3, :3] = pose[:3, :3] @ free.rolled(0.4 * k)
    return poses


@pytest.mark.slow
def test_paths_with_a_free_axis_begin_in_the_turns_of_the_seed():
    """Whole turns of the seed change nothing but the turns in which the path begins."""
    arm, free = load("gen3"), srs_ik.FreeAxis([0.261298, -0.820744, -0.508038], cone=0.3)
    seed = np.array([-1.349458, 0.136224, 1.055414, -2.367334, -0.442472, 0.232258, -2.783776])
    end = [-1.539527, 0.938284, 1.837397, 2.281255, 0.723879, 1.918978, -2.689664]
    poses = winding_path(seed, end, 15, free)
    beside = arm.solve_path(poses, seed=seed, free_axis=free)
    turns = TURN * np.array([-2.0, 0.0, 0.0, 0.0, -2.0, 0.0, 0.0])
    found = arm.solve_path(poses, seed=seed + turns, free_axis=free)
    assert found
    assert found.value == pytest.approx(beside.value, rel=1e-2)
    assert np.abs(found.q[0] - seed - turns).max() < 0.5


def test_paths_with_a_free_axis_are_followed_from_the_seed_too():
    """Paths through sampled turns all begin 3 rad away from it."""
    arm, free = load("gen3"), srs_ik.FreeAxis([-0.238985, -0.964329, 0.113823], cone=1.2)
    begin = np.array([-0.639522, -0.25093, 0.063039, 2.078522, -1.34148, -1.264606, -0.348236])
    end = [1.217777, -0.209741, -1.503314, 2.57, -2.060479, -1.217172, -2.14728]
    seed = begin + np.array([0.001109, -0.078279, 0.112137, -0.004511, 0.299328, 0.220802, -0.204823])
    found = arm.solve_path(winding_path(begin, end, 9, free), seed=seed, objective="time", free_axis=free)
    assert found
    assert np.abs(found.q[0] - seed).max() < 0.5


def test_poses_are_named_by_whatever_is_an_index():
    arm, q = load("iiwa14"), Q + np.linspace(0.0, 1.0, 8)[:, None] * 0.1 * WAY
    poses = poses_of("iiwa14", q)
    found = arm.solve_path(poses, known={np.int64(3): q[3], np.uint8(7): q[7]})
    np.testing.assert_array_equal(found.q, arm.solve_path(poses, known={3: q[3], -1: q[7]}).q)
    for bad in (True, 3.0, "3", np.float64(3.0), 8, -9, None):
        with pytest.raises(srs_ik.InvalidConfiguration, match="there is no pose"):
            arm.solve_path(poses, known={bad: q[3]})


SINGULAR_LINES = {
    "shoulder and wrist": (
        "2.017711025457009 -0.008267714712858955 -2.1198794694934198 1.316012867885938 "
        "-0.10680629851781473 0.001120319035913151 0.14079622272391926",
        "1.8712767704973545 0.008267714712858955 -2.034903280051642 1.206120115783147 "
        "-0.16651954508743919 -0.001120319035913151 0.052711913431277645",
        59,
    ),
    "shoulder and wrist, too fast": (
        "0.11164483769464947 -0.0015132406235200844 -1.8697903861683065 1.6298526069757093 "
        "-2.198059310241264 -0.07360665765159921 1.2378146406049562",
        "-0.038270409035051606 0.0015132406235200844 -1.9376261014763794 1.583097056640045 "
        "-2.2739924754878857 0.07360665765159921 1.405048711368783",
        55,
    ),
    "shoulder": (
        "-1.4312766816117177 -0.008551153393705022 2.7757807309673024 -0.609598389226498 "
        "0.41950965010022045 -2.0943951023931953 -2.8933963361303965",
        "-1.2362446713527233 0.008551153393705022 2.4086166905005437 -0.5037682199258569 "
        "0.26991459086300384 -1.9274780759567172 -2.4904768322544317",
        31,
    ),
    "from anywhere": (
        "-1.1054796170832542 0.06344687796664822 -1.251453909895012 0.6210395367274414 "
        "0.06847405889145405 0.12067680099692196 -0.40809401442036414",
        "-1.0420049695466567 -0.06344687796664822 -0.8217757867272844 0.43976134389505134 "
        "-0.06941190859110466 -0.12067680099692196 -0.433457853490197",
        39,
    ),
}
"""Straight lines of joint angles of iiwa14 whose middle posture has a singular shoulder, or wrist too."""


def singular_line(name):
    begin, end, count = SINGULAR_LINES[name]
    return np.linspace(*(np.array(each.split(), float) for each in (begin, end)), count)


@pytest.mark.parametrize("line", list(SINGULAR_LINES)[:3])
@pytest.mark.parametrize("seeded", [False, True])
def test_through_singular_postures_a_known_motion_is_no_better(line, seeded):
    arm, motion = load("iiwa14"), singular_line(line)
    start = {"seed": motion[0]} if seeded else {"known": {0: motion[0]}}
    found = arm.solve_path(poses_of("iiwa14", motion), dt=0.05, **start)
    assert found
    assert (found.steps**2).sum() <= (np.diff(motion, axis=0) ** 2).sum()
    assert found.velocity_use.max() < 0.12


@pytest.mark.parametrize("line", list(SINGULAR_LINES)[:2])
def test_through_singular_postures_the_largest_step_of_a_known_motion_is_no_smaller(line):
    motion = singular_line(line)
    poses = poses_of("iiwa14", motion)
    found = load("iiwa14").solve_path(poses, known={0: motion[0]}, objective="largest_step")
    assert found
    assert np.abs(found.steps).max() <= 1.005 * np.abs(np.diff(motion, axis=0)).max()


def test_through_singular_postures_a_path_from_anywhere_costs_no_more_than_a_known_motion():
    """Strips hold lines alone of the postures of the middle pose, whose shoulder and wrist both turn on the spot."""
    motion = singular_line("from anywhere")
    found = load("iiwa14").solve_path(poses_of("iiwa14", motion))
    assert found
    assert (found.steps**2).sum() <= (np.diff(motion, axis=0) ** 2).sum()


OUT_OF_SINGULAR = (
    ([2.37, 0.0, 1.96, 1.7, -2.38, -2.05, -0.87], [2.31, -0.34, 1.23, 1.64, -1.97, -1.64, -1.06], 37),
    ([2.4, -1.85, -1.94, 0.43, -0.19, 0.0, 0.98], [2.34, -1.11, -1.27, 0.15, -0.36, -0.72, 1.18], 36),
    ([0.0, 0.0, 0.0, -1.2, 0.0, 0.0, 0.0], [0.5, 0.6, 0.1, -1.0, 0.2, 0.8, 0.1], 40),
    ([0.0, 0.0, 0.0, 1.57, 0.0, 0.0, 0.0], [0.2, -0.3, 0.1, 1.2, 0.2, -0.4, 0.5], 40),
)
"""Straight joint lines that begin with a singular shoulder, wrist, or both, as at a home pose."""


@pytest.mark.parametrize(("first", "last", "count"), OUT_OF_SINGULAR)
def test_a_path_whose_end_is_given_begins_in_a_singular_posture_as_cheaply_as_a_known_motion(first, last, count):
    arm, Q = load("iiwa14"), np.linspace(first, last, count)
    path = arm.solve_path(arm.forward_kinematics_batch(Q), known={count - 1: Q[-1]})
    assert path.breaks == []
    assert (np.diff(path.q, axis=0) ** 2).sum() < 1.1 * (np.diff(Q, axis=0) ** 2).sum()
