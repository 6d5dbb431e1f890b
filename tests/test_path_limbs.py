"""Paths of random limbs: a motion that is known, of which the arm gets the poses, is never better."""

import arms
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from known_paths import known_motion, poses_of, total
from oracles import TURN, limbs, phases, random_limb

import srs_ik
from srs_ik.kernels.entries import path as entries


def assert_known_motion_is_no_better(limb, share, seeded):
    arm = srs_ik.load(limb.model, base="base", tip="tool")
    known = known_motion(arm, limb.rng, 40, share)
    path = arm.solve_path(poses_of(arm, known), seed=known[0] if seeded else None)
    assert np.isfinite(path.q).all()
    assert ((path.q >= arm.lower) & (path.q <= arm.upper)).all()
    assert path, path.breaks
    assert total(path, known[0] if seeded else None) <= (np.diff(known, axis=0) ** 2).sum() * (1.0 + 1e-6)
    assert max(max(arm.verify(pose, q)) for pose, q in zip(poses_of(arm, known), path.q, strict=True)) < 1e-9


@given(limbs(limits=("usual", "narrow", "beyond", "mixed")), st.floats(0.03, 0.14), st.booleans())
def test_known_motions_of_random_limbs(limb, share, seeded):
    assert_known_motion_is_no_better(limb, share, seeded)


@pytest.mark.parametrize("name", arms.here("gen3", "h1_2_left", "iiwa14", "rm75"))
def test_postures_taken_to_poses_together_are_on_them_and_in_limits_like_those_taken_alone(name):
    arm, forward = arms.load(name), arms.forward(name)
    rng = np.random.default_rng(23)
    known = np.repeat(arms.configurations(name, 6, 24), 21, axis=0)
    poses = np.array([forward(q).homogeneous for q in known])
    starts = np.clip(known + rng.uniform(-0.05, 0.05, known.shape), arm.lower, arm.upper)
    # Some are far away, and others on limits.
    starts[::13] = np.clip(known[::13] + rng.uniform(-2.0, 2.0, known[::13].shape), arm.lower, arm.upper)
    together, met = starts.copy(), np.zeros(len(starts), bool)
    entries.bridge(arm.packed.family, poses, together, met)
    alone, met_alone = starts.copy(), np.zeros(len(starts), bool)
    for i in range(len(starts)):
        entries.bridge(arm.packed.family, poses[i : i + 1], alone[i : i + 1], met_alone[i : i + 1])
    assert met_alone.mean() > 0.9
    assert met[met_alone].all()
    for q, T in zip(together[met], poses[met], strict=True):
        assert np.abs(forward(q).homogeneous - T).max() < 1e-9
        assert (q >= arm.lower).all()
        assert (q <= arm.upper).all()
    # Alone, steps are damped at first: both go the shortest way, more or less.
    moved, moved_alone = np.linalg.norm(together - starts, axis=1), np.linalg.norm(alone - starts, axis=1)
    close = met_alone & (np.abs(starts - known).max(axis=1) < 0.06)
    assert (moved[close] < 1.2 * moved_alone[close] + 0.05).all()


def through_singular(arm, rng, known):
    """A known motion, some of whose joints 2, 4 and 6 pass their singular angles slowly."""
    n = len(known)
    for joint, angle in phases(arm.limb).items():
        if rng.random() < 0.6:
            there = next((a for a in angle + TURN * np.array([0.0, 0.5, -0.5]) if inside_of(arm, joint, a)), None)
            if there is not None:
                width, share = rng.uniform(0.02, 0.4), np.linspace(-1.0, 1.0, n) * rng.uniform(0.3, 1.0)
                way = there + width * (share + rng.uniform(-0.3, 0.3)) * n / 40
                if np.abs(np.diff(way)).max() < 0.14:
                    known[:, joint] = np.clip(way, arm.lower[joint], arm.upper[joint])
    return known


def inside_of(arm, joint, angle):
    return arm.lower[joint] <= angle <= arm.upper[joint]


SLOWLY = [(203046, "oblique", "straight", "mixed", 0.02, 0), (206009, "coordinate", "offset", "usual", 0.005, 0)]
"""Limbs and the numbers of motions: coarse strips cut where a curve bends, and a closed curve as small as 0.1 rad."""


@pytest.mark.parametrize(("seed", "pattern", "elbow", "limits", "miss", "number"), SLOWLY)
def test_slow_motions_through_singular_angles_of_near_limbs_are_no_better(seed, pattern, elbow, limits, miss, number):
    arm = srs_ik.load(random_limb(seed, pattern, elbow, limits, miss).model, base="base", tip="tool")
    rng = np.random.default_rng([seed, 7])
    for _ in range(number + 1):
        known = through_singular(arm, rng, known_motion(arm, rng, 40, rng.uniform(0.02, 0.14)))
    for start in (known[0], None):
        path = arm.solve_path(poses_of(arm, known), seed=start)
        assert path, path.breaks
        assert path.value <= (np.diff(known, axis=0) ** 2).sum() * (1.0 + 1e-6)


def test_seven_joints_with_two_turns_each_are_planned_in_those_that_a_path_needs():
    """Strips of 128 turns were more than there is room for, and what was left out had the best path."""
    arm = srs_ik.load(random_limb(204003, "oblique", "straight", "wide").model, base="base", tip="tool")
    rng = np.random.default_rng([204003, 7])
    known = known_motion(arm, rng, 40, rng.uniform(0.02, 0.14))
    poses = poses_of(arm, known)
    path = arm.solve_path(poses, seed=known[0])
    assert path
    assert ((path.q >= arm.lower) & (path.q <= arm.upper)).all()
    assert path.value <= (np.diff(known, axis=0) ** 2).sum() * (1.0 + 1e-6)
    # Where the turns are given, or the path has to end as it began, it is in these.
    held = arm.solve_path(poses, known={0: known[0], 39: known[39]})
    np.testing.assert_array_equal(held.q[[0, 39]], known[[0, 39]])
    there_and_back = np.concatenate([poses[:20], poses[18::-1]])
    closed = arm.solve_path(there_and_back, seed=known[0], closed=True)
    np.testing.assert_array_equal(closed.q[0], closed.q[-1])


@pytest.mark.parametrize("joint", [0, 2, 6])
def test_a_joint_of_two_turns_stays_inside_its_limits_where_a_path_without_them_would_not(joint):
    free = arms.load("iiwa14")
    ends = {free.joint_names[joint]: {"lower": -6.6, "upper": 0.3}}
    arm = srs_ik.load("iiwa14", limits=ends)
    known = np.array([0.1, 0.7, 0.1, -1.1, 0.5, 0.8, 0.1]) + np.linspace(0.0, 1.0, 40)[:, None] * np.full(7, 0.5)
    for seed in (None, known[0]):
        path = arm.solve_path(poses_of(free, known), seed=seed)
        assert ((path.q >= arm.lower) & (path.q <= arm.upper)).all()
        assert path or seed is not None, path.breaks
