"""Postures of exact limbs in step: eight at arm angles and in branches of their own, against Pinocchio on the file."""

import math

import arms
import numpy as np
import oracles
import pytest
from numba import njit

from srs_ik.kernels.algebra.lane_trig import angle_of
from srs_ik.kernels.algebra.lanes import ALL, gather, scatter
from srs_ik.kernels.algebra.pointers import keep, row
from srs_ik.kernels.chain.eight import put_eight
from srs_ik.kernels.layout import limb as at
from srs_ik.kernels.limb.postures_eight import eight_branches, eight_postures
from srs_ik.kernels.limb.triangle import elbow_side, place


@njit
def angles(cosines, sines, out):
    scatter(row(out, 0), 0, 1, angle_of(gather(row(cosines, 0), 0, 1), gather(row(sines, 0), 0, 1)))
    keep(cosines), keep(sines), keep(out)


@njit
def in_branches(limb, R, p, branches, psis, rows):
    P = row(limb, 0)
    place_ = place(P, R, p)
    sides = (elbow_side(P, place_, 0), elbow_side(P, place_, 1))
    c, s = np.cos(psis), np.sin(psis)
    turns = gather(row(c, 0), 0, 1), gather(row(s, 0), 0, 1)
    q, sure = eight_postures(P, sides, gather(row(branches, 0), 0, 1), turns[0], turns[1])
    put_eight(row(rows, 0), 7, sure, q)
    keep(limb), keep(branches), keep(rows), keep(c), keep(s)
    return sure


@njit
def at_angle(limb, R, p, psi, rows):
    P = row(limb, 0)
    q, sure = eight_branches(P, place(P, R, p), psi)
    put_eight(row(rows, 0), 7, ALL, q)
    keep(limb), keep(rows)
    return sure


def figures(pose):
    return tuple(pose.rotation.ravel().tolist()), tuple(pose.translation.tolist())


def branch_of(limb, q):
    """Number of a branch, from the sides of the singular angles of the elbow, shoulder and wrist."""
    below = {joint: np.sin(q[joint] - phase) < 0.0 for joint, phase in oracles.phases(limb).items()}
    return 4 * below[3] + 2 * below[1] + below[5]


def test_angles_are_those_of_math():
    rng, out = np.random.default_rng(4), np.empty(8)
    drawn = rng.uniform(-np.pi, np.pi, (400, 8))
    drawn[200:] *= 10.0 ** rng.uniform(-20.0, 0.0, (200, 8))
    for x in (*drawn, 0.25 * np.pi * np.array([0, 1, 2, 3, -1, -2, -3, 4.0])):
        length = 10.0 ** rng.uniform(-9.0, 9.0, 8)
        c, s = length * np.cos(x), length * np.sin(x)
        angles(c, s, out)
        expected = np.array([math.atan2(*each) for each in zip(s, c, strict=True)])
        assert (np.abs(out - expected) <= 4.0 * np.spacing(np.abs(expected))).all()
    angles(np.zeros(8), np.zeros(8), out)
    assert (out == 0.0).all()


@pytest.mark.parametrize("name", ["iiwa14", "human_arm"])
def test_eight_postures_meet_the_pose_each_at_its_arm_angle_in_its_branch(name):
    arm, forward = arms.load(name), arms.forward(name)
    rng = np.random.default_rng(6)
    seen = 0
    for known in arms.configurations(name, 20, 31):
        pose = forward(known)
        psis, branches = rng.uniform(-np.pi, np.pi, 8), rng.permutation(8).astype(float)
        rows = np.zeros((8, 7))
        sure = in_branches(arm.packed.family, *figures(pose), branches, psis, rows)
        together = np.zeros((8, 7))
        sure_together = at_angle(arm.packed.family, *figures(pose), psis[0], together)
        asked = [(q, psi, b, sure >> i & 1) for i, (q, psi, b) in enumerate(zip(rows, psis, branches, strict=True))]
        asked += [(q, psis[0], b, sure_together) for b, q in enumerate(together)]
        for q, psi, branch, is_sure in asked:
            if not is_sure:
                continue
            seen += 1
            assert max(oracles.distance(pose, forward(q))) < 1e-12
            assert abs(np.sin(0.5 * (oracles.arm_angle(forward, arm.limb, q) - psi))) < 1e-9
            assert branch_of(arm.limb, q) == branch
    assert seen > 150


def test_a_singular_shoulder_is_unsure():
    arm = arms.load("iiwa14")
    q = np.array([0.3, 0.0, 0.4, 1.1, 0.2, 0.9, -0.3])
    q[1] = arm.packed.family[0, at.SHOULDER + at.PHASE]
    rows = np.zeros((8, 7))
    sure = at_angle(arm.packed.family, *figures(arm.forward_kinematics(q)), arm.arm_angle(q), rows)
    assert not sure
