"""Paths of random limbs: a motion that is known, of which the arm gets the poses, is never better."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from oracles import limbs
from test_path_best import known_motion, poses_of, total

import srs_ik


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
