"""Singular poses leave sums of joints open: answers are the best of all splits, and `free_splits` tells them."""

import runpy
import sys
from pathlib import Path

import arms
import numpy as np
import pytest
from oracles import distance, inside, phases, random_limb, wrapped

import srs_ik
from srs_ik import Status

BENCHMARKS = Path(__file__).resolve().parents[1] / "benchmarks"
TURN = 2.0 * np.pi
ARMS = ("iiwa14", "human_arm", "med7", "openarm_left", "sia5d", "humanoid_left", "romeo_left")


@pytest.fixture(scope="module")
def judge():
    """The script that tries many more."""
    sys.path.insert(0, str(BENCHMARKS))
    yield runpy.run_path(str(BENCHMARKS / "singular.py"), run_name="singular")
    sys.path.remove(str(BENCHMARKS))


def singular(arm, rng, joints=((1,), (5,), (1, 5))):
    """A random posture inside the limits whose shoulder, wrist or both are singular; None if the limits forbid it."""
    angles = phases(arm.limb)
    which = joints[rng.integers(len(joints))]
    q = rng.uniform(np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi))
    q[list(which)] = [angles[j] for j in which]
    return (q, which) if inside(q, arm.lower, arm.upper) else None


def other_splits(arm, q, joint, count=400):
    """The postures of a singular one that turn the two joints beside a middle joint, inside the limits."""
    toward = 1.0 if np.cos(q[joint] - phases(arm.limb)[joint]) > 0.0 else -1.0
    low = np.maximum(arm.lower, -2.0 * TURN)
    high = np.minimum(arm.upper, 2.0 * TURN)
    found = []
    for first in np.linspace(low[joint - 1], high[joint - 1], count):
        for turns in range(-2, 3):
            split = q.copy()
            split[joint - 1] = first
            split[joint + 1] += toward * (q[joint - 1] - first) + TURN * turns
            if inside(split, arm.lower, arm.upper):
                found.append(split)
    return np.array(found).reshape(-1, 7)


def test_the_nearest_split_of_a_wrist():
    """The figures of a case in which another split of the same sum is nearer by 0.73 rad."""
    arm = arms.load("iiwa14")
    q = [-0.3464451480354578, 0.8670134289028599, 2.414502941839209, -1.9503194555446624, -2.70667880780641, 0.0]
    q = np.array([*q, 0.2764494174748311])
    seed = [-0.5818436432497496, 1.6456509963244463, 0.3013765034068836, -1.7213695642179725, 2.2272913798202545]
    seed = np.array([*seed, -0.7903935861344749, -2.0062593569276856])
    nearer = q.copy()
    nearer[[4, 6]] = 0.6233211921935902, -3.053550582525169
    forward = arms.forward("iiwa14")
    pose = forward(q)
    assert max(distance(pose, forward(nearer))) < 1e-12
    solution = arm.solve(pose, seed=seed)
    assert max(distance(pose, forward(solution.q))) < 1e-11
    assert np.linalg.norm(solution.q - seed) < np.linalg.norm(nearer - seed) + 1e-9
    batch = arm.solve_batch([pose], seed=seed)
    assert (batch.q[0] == solution.q).all()


@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_no_split_is_nearer_to_the_seed_or_farther_from_the_limits(name):
    arm, forward, rng = arms.load(name), arms.forward(name), arms.generator(name, 61)
    half = 0.5 * (arm.upper - arm.lower)
    for _ in range(60):
        case = singular(arm, rng)
        if case is None:
            continue
        q, which = case
        pose = forward(q)
        seed = rng.uniform(np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi))
        splits = np.concatenate([other_splits(arm, q, joint) for joint in which])
        assert max(max(distance(pose, forward(split))) for split in splits[::37]) < 1e-11
        near, far = arm.solve(pose, seed=seed), arm.solve(pose)
        at_angle = arm.solve(pose, seed=seed, arm_angle=arm.arm_angle(q))
        for solution in (near, far, at_angle):
            assert solution.status is Status.OK
            assert max(distance(pose, forward(solution.q))) < 1e-11
            assert inside(solution.q, arm.lower, arm.upper)
        least = np.linalg.norm(splits - seed, axis=1).min()
        assert np.linalg.norm(near.q - seed) < least + 1e-9
        assert np.linalg.norm(at_angle.q - seed) < least + 1e-9
        margins = 1.0 - np.abs(splits - 0.5 * (arm.lower + arm.upper)) / half
        margin = 1.0 - np.abs(far.q - 0.5 * (arm.lower + arm.upper)) / half
        assert margin.min() > margins.min(axis=1).max() - 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("name", ["iiwa14", "med7", "rm75"])
def test_seeded_answers_against_a_sweep_that_scipy_polishes(judge, name):
    arm = arms.load(name)
    known, rng = judge["Known"](arm), arms.generator(name, 62)
    for case in judge["cases"](arm, 25, rng, ((1,), (5,))):
        assert judge["farther"](arm, known, case) < 1e-6, case


@pytest.mark.slow
@pytest.mark.parametrize(("name", "joints"), [("iiwa14", (1, 3, 5)), ("iiwa14", (1, 3)), ("human_arm", (1, 3))])
def test_seeded_answers_with_an_elbow_as_good_as_flat(judge, name, joints):
    """The pose does not tell its bend: each has a curve of postures of its own."""
    arm = arms.load(name)
    known, rng = judge["Known"](arm), arms.generator(name, 63)
    for case in judge["cases"](arm, 25, rng, (joints,)):
        assert judge["farther"](arm, known, case) < 1e-6, case


@pytest.mark.parametrize("seed", range(12))
def test_seeded_answers_of_random_limbs(judge, seed):
    limb = random_limb(
        seed, "tilted", ("straight", "offset")[seed % 2], ("usual", "wide", "continuous", "mixed")[seed % 4]
    )
    arm = srs_ik.load(limb.model, base="base", tip="tool")
    known = judge["Known"](arm)
    for case in judge["cases"](arm, 4, limb.rng, ((1,), (5,))):
        assert judge["farther"](arm, known, case) < 1e-6, case


@pytest.mark.parametrize("name", ARMS)
def test_free_splits_are_postures_of_the_pose(name):
    arm, forward, rng = arms.load(name), arms.forward(name), arms.generator(name, 63)
    found = 0
    for _ in range(30):
        case = singular(arm, rng)
        if case is None:
            continue
        q, which = case
        pose = forward(q)
        segments = arm.free_splits(pose)
        for joint in which:
            own = [s for s in segments if s.joints == (joint - 1, joint + 1)]
            # The posture itself lies on one of them, and so does every other split of its sum.
            for split in [q, *other_splits(arm, q, joint, 40)]:
                assert any(is_on(s, split, which) for s in own), (joint, split)
        for segment in segments:
            found += 1
            for share in (0.0, 0.3, 1.0):
                posture = segment.at(share)
                assert inside(posture, arm.lower, arm.upper)
                assert max(distance(pose, forward(posture))) < 1e-10
            assert segment.width >= 0.0
            assert arm.branch(segment.at(0.5)) // 4 == segment.branches[0] // 4
            if segment.arm_angle is not None:
                assert abs(wrapped(arm.arm_angle(segment.at(0.5)) - segment.arm_angle)) < 1e-7
    assert found or name in ("humanoid_left", "romeo_left", "human_arm")


def is_on(segment, q, which):
    """Whether a posture lies on a segment; the split of another singular joint is free as well."""
    first, last = segment.joints
    rest = [j for j in range(7) if not any(j in (k - 1, k + 1) for k in which)]
    if np.abs(wrapped(segment.lower[rest] - q[rest])).max() > 1e-6:
        return False
    share = (q[first] - segment.lower[first]) / max(segment.width, 1e-12)
    return -1e-6 <= share <= 1.0 + 1e-6 and abs(segment.at(share)[last] - q[last]) < 1e-6


def test_free_splits_of_ordinary_poses_and_of_limits_left_aside():
    arm, rng = arms.load("iiwa14"), arms.generator("iiwa14", 64)
    for q in arms.configurations("iiwa14", 50, 65):
        assert arm.free_splits(arm.forward_kinematics(q)) == []
    q, _ = singular(arm, rng, ((5,),))
    for segment in arm.free_splits(arm.forward_kinematics(q), respect_limits=False):
        assert abs(segment.width - TURN) < 1e-12
    q[5] = 1e-6
    assert arm.free_splits(arm.forward_kinematics(q)) == []
    upright = arm.free_splits(arm.forward_kinematics(np.zeros(7)))
    assert upright
    assert all(segment.arm_angle is None for segment in upright)
    assert "every arm angle" in repr(upright[0])
    with pytest.raises(srs_ik.InvalidPose):
        arm.free_splits(np.full((4, 4), np.nan))


@pytest.mark.slow
@pytest.mark.parametrize("joint", [1, 5])
def test_no_split_is_better_by_an_objective(joint):
    arm, forward, rng = arms.load("iiwa14"), arms.forward("iiwa14"), arms.generator("iiwa14", 66)
    shift, weight = np.arange(7.0), np.array([1.0, 0.2, 1.5, 0.3, 1.1, 0.1, 0.9])

    def waves(q):
        return float(weight @ np.sin(q + shift))

    for offset in (0.0, 1e-12, 1e-9, 1e-6):
        for _ in range(3):
            q, _ = singular(arm, rng, ((joint,),))
            q[joint] = offset
            pose = forward(q)
            splits = other_splits(arm, q, joint)
            force, velocity = rng.normal(size=3), rng.normal(size=3)
            ratio = [srs_ik.force_velocity_ratio(arm.jacobian(s), force, velocity) for s in splits]
            # Next to a singular pose, a split is a posture as far as the offset goes.
            give = 1e-9 + 1e3 * offset
            for optimum, values in (
                (arm.optimise(pose, waves), [waves(s) for s in splits]),
                (arm.optimise(pose, "force_velocity_ratio", force=force, velocity=velocity), ratio),
            ):
                assert max(distance(pose, forward(optimum.q))) < 1e-11
                assert optimum.value <= min(values) + give * max(1.0, abs(min(values)))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["iiwa14", "human_arm", "openarm_left"])
def test_splits_are_searched_to_their_ends_while_another_joint_stands_on_its_limit(name):
    arm, forward, rng = arms.load(name), arms.forward(name), arms.generator(name, 70)
    for joint in (1, 5):
        for _ in range(25):
            case = singular(arm, rng, ((joint,),))
            if case is None:
                continue
            q = case[0]
            still = rng.choice([j for j in range(7) if abs(j - joint) > 1])
            q[still] = rng.choice([arm.lower[still], arm.upper[still]])
            pose = forward(q)
            twist = rng.normal(size=6)
            splits = np.vstack([q, other_splits(arm, q, joint)])
            values = [np.sum((twist / np.linalg.norm(twist) @ arm.jacobian(s)) ** 2) for s in splits]
            optimum = arm.optimise(pose, "twist", twist=twist)
            assert max(distance(pose, forward(optimum.q))) < 1e-11
            assert optimum.value >= max(values) * (1.0 - 1e-9)


def test_no_pair_of_splits_is_better_by_an_objective():
    """Shoulder and wrist singular at once leave a surface of postures."""
    arm, forward, rng = arms.load("iiwa14"), arms.forward("iiwa14"), arms.generator("iiwa14", 67)
    shift, weight = np.arange(7.0), np.array([1.0, 0.2, 1.5, 0.3, 1.1, 0.1, 0.9])

    def waves(q):
        return float(weight @ np.sin(q + shift + 0.3 * q[0] * q[4]))

    for _ in range(2):
        q, _ = singular(arm, rng, ((1, 5),))
        pose = forward(q)
        least = min(waves(both) for one in other_splits(arm, q, 1, 80) for both in other_splits(arm, one, 5, 80))
        optimum = arm.optimise(pose, waves)
        assert max(distance(pose, forward(optimum.q))) < 1e-11
        assert optimum.value <= least + 1e-9


def test_a_path_starts_at_the_nearest_split():
    arm, forward, rng = arms.load("iiwa14"), arms.forward("iiwa14"), arms.generator("iiwa14", 68)
    for _ in range(10):
        q, which = singular(arm, rng, ((1,), (5,)))
        pose = forward(q).homogeneous
        splits = other_splits(arm, q, which[0])
        seed = splits[rng.integers(len(splits))] + rng.uniform(-0.05, 0.05, 7)
        path = arm.solve_path(np.repeat(pose[None], 3, axis=0), seed=seed)
        assert path
        assert np.linalg.norm(path.q[0] - seed) < np.linalg.norm(splits - seed, axis=1).min() + 1e-6


def test_the_arm_angle_of_a_singular_posture_is_in_an_interval():
    """Even if the limits leave no other arm angle: its curve keeps them for a few of the splits alone."""
    outer = [arms.load("iiwa14").joint_names[joint] for joint in (0, 2, 4, 6)]
    arm = srs_ik.load("iiwa14", limits={name: {"lower": -0.3, "upper": 0.3} for name in outer})
    rng, points = arms.generator("iiwa14", 69), 0
    for _ in range(200):
        q, _ = singular(arm, rng, ((1,), (5,)))
        of_elbow = [i for i in arm.intervals(arm.forward_kinematics(q)) if i.branch // 4 == arm.branch(q) // 4]
        off = [abs(wrapped(arm.arm_angle(q) - 0.5 * (i.lower + i.upper))) - 0.5 * i.width for i in of_elbow]
        assert min(off) < 1e-7, q
        points += of_elbow[int(np.argmin(off))].width < 1e-9
    assert points > 100
