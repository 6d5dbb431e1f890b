"""Paths of random limbs: a motion that is known, of which the arm gets the poses, is never better."""

import arms
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from oracles import limbs
from test_path_best import known_motion, poses_of, total

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
