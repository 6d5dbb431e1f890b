"""Exact arms unlike those of makers: ranges of turns or of none, ends at singular angles, odd axes and lengths."""

from itertools import islice
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from chains import CONTINUOUS, QUARTER, TURN, Line, Y, Z, arm, pose
from oracles import inside

import srs_ik

BENCHMARKS = Path(__file__).resolve().parents[1] / "benchmarks"
HALF = 0.5 * TURN
EVEN = ((-2.9, 2.9), (-2.0, 2.0), (-2.9, 2.9), (-2.1, 2.1), (-2.9, 2.9), (-2.0, 2.0), (-3.0, 3.0))
"""Ranges of joints 1 to 7, rad, like those of common arms."""

AXES = (Z, Y, Z, Y, Z, Y, Z)
OBLIQUE = (0.0, 0.5**0.5, 0.5**0.5)


def lines(limits, upper=400, fore=350, beside=0, axes=AXES, rpy=(0, 0, 0)):
    """Axes of an arm along z, millimetres: its upper arm, its forearm, and how far its elbow is beside it."""
    turn = pin.rpy.rpyToMatrix(*rpy)
    heights = (300, 300, 300, 300 + upper, 300 + upper, 300 + upper + fore, 300 + upper + fore)
    points = [turn @ (beside * (joint == 3), 0, z) for joint, z in enumerate(heights)]
    return [Line(turn @ axis, point, ends) for axis, point, ends in zip(axes, points, limits, strict=True)]


ARMS = {
    "even": lines(EVEN),
    "turns": lines(((-12, 15), (-7, 8), (-20, 9), (-6.5, 9.5), (-10, 14), (-9, 6.6), (-16, 13))),
    "narrow": lines(((-0.2, 0.25), (-1e-3, 2e-3), (-0.1, 0.3), (-0.05, 1.2), (-2e-3, 1e-3), (-0.3, 0.2), (-0.4, 0.4))),
    "one_free": lines(((-0.3, 0.2), (-0.4, 0.2), CONTINUOUS, (-0.3, 1), (-0.2, 0.4), (-0.3, 0.3), (-0.3, 0.5))),
    "quarters": lines(
        ((-HALF, HALF), (-QUARTER, QUARTER), (-QUARTER, HALF), (0, QUARTER), (-HALF, QUARTER), (0, QUARTER), (-1, 1))
    ),
    "half": lines(((-2.9, 2.9), (0, 2), (-2.9, 2.9), (0, 2.5), (-2.9, 2.9), (0, 2), (-3, 3))),
    "short_upper": lines(EVEN, upper=50, fore=500),
    "offset": lines((*EVEN[:3], (-3.1, 3.0), *EVEN[4:]), upper=200, fore=250, beside=320),
    "huge": lines(EVEN, upper=40_000, fore=35_000),
    "tilted": lines(EVEN, rpy=(0.3, 0.7, -1.1)),
    "oblique": lines(EVEN, axes=(OBLIQUE, Y, OBLIQUE, Y, Z, OBLIQUE, Z)),
}


EQUAL = {
    "equal": lines((*EVEN[:3], (-3.3, 3.3), *EVEN[4:]), upper=400, fore=400),
    "equal_free": lines((CONTINUOUS,) * 7, upper=400, fore=400),
}
"""Links of one length."""


@pytest.fixture(scope="module")
def load(tmp_path_factory):
    folder = tmp_path_factory.mktemp("unlike")

    def loaded(name, limits=None):
        file = folder / f"{name}.urdf"
        file.write_text(f'<robot name="{name}">{arm((ARMS | EQUAL)[name], pose((0, 0, 1150)))}</robot>')
        return srs_ik.load(file, base="link_0", tip="tool", limits=limits)

    return loaded


@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_known_postures_are_in_intervals_and_all_of_these_is_met(bench, load, name):
    some = list(bench["cases"](load(name), 30, np.random.default_rng(5), bench["TOGETHER"], 0.3))
    intervals = list(load(name).intervals_batch(np.array([case.pose for case in some]), threads=1))
    for case, found in zip(some, intervals, strict=True):
        assert bench["beside"](load(name), case, found) < 1e-4, case.q.tolist()
    assert not list(bench["missed"](load(name), some, intervals))


def test_a_gap_of_nanoradians_between_intervals_is_a_gap(load):
    """Shoulder and wrist pass their singularity there within 1e-8 rad of arm angle, outside the limits of joint 1."""
    q = [
        1.4327768756171655,
        1e-9,
        -1.2843542280051987,
        -1.2218023090496555,
        -0.757597386641411,
        -1e-9,
        -1.4434160659883792,
    ]
    robot = load("offset")
    pose = robot.forward_kinematics(q)
    own = [i for i in robot.intervals(pose) if i.branch == 5]
    for psi in np.concatenate([-np.geomspace(1e-6, 1e-10, 17), [0.0], np.geomspace(1e-10, 1e-6, 17)]):
        inside_one = any(i.lower <= psi <= i.upper for i in own)
        assert bool(robot.solve(pose, arm_angle=psi, branch=5)) == inside_one, psi


def assert_none_is_farther(bench, robot, rng, count):
    for case in islice(bench["cases"](robot, count, rng, bench["TOGETHER"], 0.5), count):
        seed = np.clip(case.q + 10.0 ** rng.uniform(-3.0, -0.5) * rng.normal(size=7), robot.lower, robot.upper)
        found = robot.solve(case.pose, seed=seed)
        assert found
        assert inside(found.q, robot.lower, robot.upper)
        assert np.linalg.norm(found.q - seed) <= np.linalg.norm(case.q - seed) + 1e-6, (case.q.tolist(), seed.tolist())


@pytest.mark.parametrize("number", [0, 26, 32, 38])
@pytest.mark.parametrize("name", ARMS)
def test_no_answer_is_farther_from_a_seed_than_a_known_posture(bench, load, name, number):
    assert_none_is_farther(bench, load(name), np.random.default_rng(number), 20)


@pytest.mark.parametrize(("name", "number"), [("quarters", 4), ("half", 5), ("tilted", 15)])
def test_nor_where_one_posture_alone_keeps_the_limits(bench, load, name, number):
    assert_none_is_farther(bench, load(name), np.random.default_rng(number), 20)


@pytest.mark.parametrize("angle", [0.4, -1.0])
def test_a_singular_shoulder_with_a_joint_that_cannot_move_is_in_an_interval(bench, load, angle):
    robot = load("even", {"joint_3": {"lower": angle, "upper": angle}})
    rng = np.random.default_rng(8)
    for _ in range(10):
        q = rng.uniform(robot.lower, robot.upper)
        q[1], q[3] = 0.0, rng.choice([-1.0, 1.0]) * rng.uniform(0.3, 2.0)
        case = bench["Case"](q, robot.forward_kinematics(q).homogeneous, q, (1,), 0.0)
        assert bench["beside"](robot, case, robot.intervals(case.pose)) < 1e-6
        found = robot.solve(case.pose, arm_angle=robot.arm_angle(q))
        assert found
        assert found.q[2] == angle


@pytest.mark.parametrize("offset", [1e-10, 1e-9, 1e-8, 1e-7])
def test_so_is_one_whose_elbow_is_as_good_as_straight(bench, load, offset):
    robot = load("even", {"joint_3": {"lower": 0.4, "upper": 0.4}})
    rng = np.random.default_rng(8)
    some = []
    for _ in range(10):
        q = rng.uniform(robot.lower, robot.upper)
        q[1] = rng.choice([-offset, offset])
        q[3] = -q[1]
        some.append(bench["Case"](q, robot.forward_kinematics(q).homogeneous, q, (1, 3), offset))
    intervals = list(robot.intervals_batch(np.array([case.pose for case in some]), threads=1))
    for case, found in zip(some, intervals, strict=True):
        # The smaller the bend, the worse it tells the arm angle: rounding of directions over it, rad.
        assert bench["beside"](robot, case, found) < 1e-6 + 1e-14 / offset, case.q.tolist()
    assert not list(bench["missed"](robot, some, intervals))


def folded(bench, robot, rng, joints, offset):
    """A posture with its wrist back on its shoulder, or as far from it as the bend tells."""
    q = rng.uniform(-1.5, 1.5, 7)
    for joint in (1, 5):
        q[joint] = rng.choice([-1.0, 1.0]) * (offset if joint in joints else rng.uniform(0.3, 1.5))
    q[3] = np.pi - offset
    return bench["Case"](q, robot.forward_kinematics(q).homogeneous, q, joints, offset)


@pytest.mark.parametrize("joints", [(3,), (1, 3), (3, 5)])
@pytest.mark.parametrize(("offset", "share"), [(3e-10, 0.0), (1e-10, 0.05), (3e-11, 0.05)])
def test_links_of_one_length_that_are_folded_meet_their_intervals(bench, load, joints, offset, share):
    """Where S-W is shorter than 1e-10 m some are still not met: 1 to 4 % of them."""
    robot, rng = load("equal"), np.random.default_rng(2)
    some = [folded(bench, robot, rng, joints, offset) for _ in range(40)]
    intervals = list(robot.intervals_batch(np.array([case.pose for case in some]), threads=1))
    for case, found in zip(some, intervals, strict=True):
        assert bench["beside"](robot, case, found) < 1e-6 + 1e-14 / case.offset, case.q.tolist()
    asked = sum(len(bench["asked"](found)) for found in intervals)
    assert len(list(bench["missed"](robot, some, intervals))) <= share * asked


@pytest.mark.parametrize("offset", [0.0, 1e-16, 1e-14, 1e-13, 1e-12, 1e-11])
def test_all_arm_angles_close_however_short_the_way_from_shoulder_to_wrist(bench, load, offset):
    robot, rng = load("equal_free"), np.random.default_rng(3)
    poses = np.array([folded(bench, robot, rng, (3,), offset).pose for _ in range(40)])
    angles = rng.uniform(-np.pi, np.pi, len(poses))
    for branch in range(8):
        found = robot.solve_batch(poses, arm_angle=angles, branch=branch, threads=1)
        assert found.ok.all()
        _, _, tip, turned = bench["Known"](robot).moved(found.q)
        assert np.abs(tip - poses[:, :3, 3]).max() < 1e-13
        assert np.abs(turned - poses[:, :3, :3]).max() < 1e-13
