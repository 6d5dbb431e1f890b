"""Answers out of limits: no posture violates a limit by less, and of those as good at its arm angle none is closer.

Postures that meet a pose, whatever the limits, come from a sweep over all arm angles, and Pinocchio says that they do;
SciPy finds the posture that an answer is before it is put on the limits.
"""

from itertools import product

import arms
import numpy as np
import pytest
from oracles import TURN, Forward, distance, random_limb, wrapped
from scipy.optimize import least_squares

import srs_ik

ELBOW_OUT = np.array([2.132266, 1.106972, -1.576121, -2.817568, -1.094298, -1.914423, 2.54565])
"""A posture of `iiwa14`, of whose pose joint 4 is farthest out at every arm angle."""

SWEEP = np.linspace(-np.pi, np.pi, 360, endpoint=False)
EQUAL = 1e-6
"""Violations, rad, and measures of closeness that differ by less are equal: SciPy ends that close."""

TWO_OF_ONE = srs_ik.pose_from_xyz_rpy(
    [0.12214737027566913, 0.27135848456148526, -0.35071006942331007],
    [1.3547266484248972, -2.514775122454964, -2.4891856130239884],
)
"""A pose of `iiwa14` with joint 2 as far out in all branches at arm angle 0; joint 3 is 0 there, or half a turn."""


def limb_of(name):
    if not name.startswith("limb"):
        return arms.load(name), arms.forward(name)
    limb = random_limb(int(name.removeprefix("limb")))
    arm = srs_ik.load(limb.model, base="base", tip="tool")
    return arm, Forward(limb.model, "base", "tool", arm.joint_names)


def violation(arm, q):
    return np.maximum(np.maximum(arm.lower - q, q - arm.upper), 0.0).max(axis=-1)


def turned(arm, q):
    """The turn of each angle that violates its limits least."""
    turns = np.asarray(q)[..., None] + TURN * np.arange(-2, 3)
    off = np.maximum(np.maximum(arm.lower[:, None] - turns, turns - arm.upper[:, None]), 0.0) + 1e-9 * np.abs(turns)
    return np.take_along_axis(turns, off.argmin(axis=-1)[..., None], axis=-1)[..., 0]


def swept(arm, forward, pose, psis):
    """(n, 7) postures of all branches at some arm angles."""
    many = np.tile(pose.homogeneous, (len(psis), 1, 1))
    found = arm.solve_batch(many, arm_angle=psis, all_branches=True, respect_limits=False, threads=1)
    Q = turned(arm, found.q[found.ok])
    assert all(max(distance(pose, forward(q))) < 1e-8 for q in Q[::97])
    return Q


def before_limits(arm, forward, pose, q, Q):
    """The posture for the pose that q is when it is put on the limits."""

    def off(x):
        there = forward(x)
        turn = pose.rotation.T @ there.rotation
        return np.r_[
            there.translation - pose.translation, (turn - np.eye(3)).ravel(), np.clip(x, arm.lower, arm.upper) - q
        ]

    Q = q + wrapped(Q - q)
    nearest = np.linalg.norm(np.clip(Q, arm.lower, arm.upper) - q, axis=1).argsort()
    for start in Q[nearest[:40]]:
        found = least_squares(off, start, xtol=1e-15, ftol=1e-15, gtol=1e-15)
        if np.abs(found.fun).max() < 1e-8:
            return found.x
    raise AssertionError("the answer is no posture put on its limits")


def measure(arm, pose, reached):
    """That of docs/conventions.md, of closeness."""
    away, angle = distance(pose, reached)
    return (away / (arm.limb.upper_arm + arm.limb.forearm)) ** 2 + 2.0 - 2.0 * np.cos(angle)


def either_limit(arm, q):
    """A posture, with each of its joints that is outside its limits in either turn beside them."""
    out = np.maximum(arm.lower - q, q - arm.upper) > 0.0
    turns = [(x, x + TURN, x - TURN) if o else (x,) for x, o in zip(q, out, strict=True)]
    return np.array(list(product(*turns)))


def out_of_limits(arm, forward, rng, count):
    poses = (forward(rng.uniform(-np.pi, np.pi, 7)) for _ in range(10 * count))
    some = (pose for pose in poses if arm.solve(pose).status == "OUT_OF_LIMITS")
    return [pose for pose, _ in zip(some, range(count), strict=False)]


@pytest.mark.parametrize("name", [*arms.BUILT_IN, "limb0", "limb2", "limb7", "limb11", "limb20"])
def test_no_posture_violates_limits_by_less(name):
    arm, forward = limb_of(name)
    rng = arms.generator("least violating", len(name))
    for pose in out_of_limits(arm, forward, rng, 5):
        Q = swept(arm, forward, pose, SWEEP)
        for solution in (arm.solve(pose), arm.solve(pose, seed=rng.uniform(-1.0, 1.0, 7))):
            assert solution.status == "OUT_OF_LIMITS"
            own = before_limits(arm, forward, pose, solution.q, Q)
            assert violation(arm, own) <= violation(arm, Q).min() + EQUAL


@pytest.mark.parametrize("name", ["iiwa14", "human_arm"])
def test_of_postures_that_violate_limits_equally_the_closest_is_given(name):
    arm, forward = limb_of(name)
    poses = out_of_limits(arm, forward, arms.generator("equals", len(name)), 5)
    for pose in [TWO_OF_ONE, *poses] if name == "iiwa14" else poses:
        solution = arm.solve(pose)
        assert solution.status == "OUT_OF_LIMITS"
        own = before_limits(arm, forward, pose, solution.q, swept(arm, forward, pose, SWEEP))
        for q in swept(arm, forward, pose, np.array([arm.arm_angle(own)])):
            for turn in either_limit(arm, q):
                if violation(arm, turn) <= violation(arm, own) + EQUAL:
                    there = forward(np.clip(turn, arm.lower, arm.upper))
                    assert measure(arm, pose, forward(solution.q)) <= measure(arm, pose, there) + EQUAL


@pytest.mark.parametrize("name", ["iiwa14", "human_arm", "limb14"])
def test_of_postures_that_violate_limits_equally_the_nearest_to_a_seed_is_given(name):
    """As of a robot that rests a little beyond the limit of its elbow."""
    arm, forward = limb_of(name)
    rng, seen = arms.generator("beyond a limit", len(name)), 0
    for _ in range(12):
        q = rng.uniform(np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi))
        out = 10.0 ** rng.uniform(-6.0, -3.0)
        q[3] = arm.lower[3] - out if rng.random() < 0.5 else arm.upper[3] + out
        pose, seed = forward(q), q + rng.uniform(-0.2, 0.2, 7) * (rng.random() < 0.7)
        psi = arm.arm_angle(q)
        for solution, psis in ((arm.solve(pose, seed=seed), SWEEP), (arm.solve(pose, psi, seed), np.array([psi]))):
            if solution.status != "OUT_OF_LIMITS":
                continue
            Q = np.vstack([q, swept(arm, forward, pose, psis)])
            equals = Q[violation(arm, Q) <= violation(arm, Q).min() + 1e-9]
            if len(equals) > 1:
                nearest = np.linalg.norm(np.clip(equals, arm.lower, arm.upper) - seed, axis=1).min()
                assert np.linalg.norm(solution.q - seed) < nearest + 2.0 * out + 1e-6
                seen += 1
    assert seen > 5


def closest_around(arm, forward, pose):
    """(n,) how close the closest of the least violating postures comes at each arm angle of a sweep that has one."""
    least, closest = violation(arm, swept(arm, forward, pose, SWEEP)).min(), []
    for psi in SWEEP[::2]:
        turns = [turn for q in swept(arm, forward, pose, np.array([psi])) for turn in either_limit(arm, q)]
        equals = [np.clip(q, arm.lower, arm.upper) for q in turns if violation(arm, q) <= least + EQUAL]
        closest += [min(measure(arm, pose, forward(q)) for q in equals)] if equals else []
    return np.array(closest)


@pytest.mark.parametrize("name", ["iiwa14", "limb7"])
def test_where_the_elbow_alone_decides_an_answer_is_closer_than_at_most_arm_angles(name):
    """At three quarters of them at least: the best of twelve all around is among these unless closeness is ragged."""
    arm, forward = limb_of(name)
    poses = [forward(ELBOW_OUT)] if name == "iiwa14" else []
    seen = 0
    for pose in [*poses, *out_of_limits(arm, forward, arms.generator("elbow out", len(name)), 12)]:
        closest = closest_around(arm, forward, pose)
        if len(closest) > 30:
            solution, seen = arm.solve(pose), seen + 1
            assert solution.status == "OUT_OF_LIMITS"
            assert measure(arm, pose, forward(solution.q)) <= np.quantile(closest, 0.25) + EQUAL
    assert seen > 1
