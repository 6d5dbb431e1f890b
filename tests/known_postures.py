"""Postures that are known by construction, next to singular ones, and whether intervals lose nothing of their poses."""

import runpy
from pathlib import Path

import arms
import numpy as np
from oracles import distance, inside, phases

BENCHMARKS = Path(__file__).resolve().parents[1] / "benchmarks"


def placed(name, q, joints, offset, rng):
    """A posture with some middle joints this close to singular, inside the limits; None where these forbid it."""
    arm, q, angles = arms.load(name), q.copy(), phases(arms.load(name).limb)
    for joint in joints:
        q[joint] = angles[joint] + offset * rng.choice([-1.0, 1.0])
    return q if inside(q, arm.lower, arm.upper) else None


def postures(name, count, salt, together, offsets):
    rng = arms.generator(name, salt)
    for number, q in enumerate(arms.configurations(name, count, salt)):
        for joints in together:
            near = placed(name, q, joints, offsets[(number + len(joints)) % len(offsets)], rng)
            if near is not None:
                yield near


def assert_all_is_met(name, pose, count):
    """Every arm angle of every interval has a posture in its branch, inside the limits, by Pinocchio."""
    arm, forward, asked = arms.load(name), arms.forward(name), 0
    for interval in arm.intervals(pose):
        for share in np.linspace(0.0, 1.0, count):
            psi = interval.lower + share * interval.width
            solution = arm.solve(pose, arm_angle=psi, branch=interval.branch)
            assert solution, (interval, share, solution)
            assert max(distance(pose, forward(solution.q))) < 1e-9
            assert inside(solution.q, arm.lower, arm.upper)
            asked += 1
    return asked


def assert_is_inside(bench, name, q):
    """The arm angle of a posture is in an interval of its branch, or where a joint is singular of either side of it."""
    arm, pose = arms.load(name), arms.forward(name)(q)
    away = bench["beside"](arm, bench["Case"](q, pose, q, (), 0.0), arm.intervals(pose))
    assert away < 1e-6, (away, q.tolist())


def subjects():
    return runpy.run_path(str(BENCHMARKS / "subjects.py"), run_name="subjects")


def assert_is_whole(bench, arm, q):
    """A posture is in an interval of its pose, as closely as its bend is told, and all arm angles of all are met."""
    case = bench["Case"](q, arm.forward_kinematics(q).homogeneous, q, (), 0.0)
    intervals = arm.intervals(case.pose)
    bend = abs(np.sin(q[3] - bench["singular_angles"](arm.limb)[3]))
    away = bench["beside"](arm, case, intervals)
    assert away < bench["BESIDE"] + bench["ROUNDING"] / max(bend, 1e-300), (away, q.tolist())
    assert not list(bench["missed"](arm, [case], [intervals]))


def assert_intervals_are_met(bench, arm, q):
    case = bench["Case"](q, arm.forward_kinematics(q).homogeneous, q, (), 0.0)
    intervals = arm.intervals(case.pose)
    assert intervals
    assert not list(bench["missed"](arm, [case], [intervals]))
