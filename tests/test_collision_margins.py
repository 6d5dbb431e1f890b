"""Margins between links: refused only where no posture keeps them, by distances of coal of all pairs not adjacent."""

import numpy as np
import pinocchio as pin
import pytest
from arms import generator
from collision_oracle import Truth, file_of_and, with_a_thick_neck

import srs_ik
from srs_ik.solve.in_scene.surroundings import Surroundings


class Distances:
    """Least distance of all links of an arm that are not on one joint, adjacent, or touching by design."""

    def __init__(self, arm):
        self.arm, self.truth = arm, Truth(*file_of_and(arm))
        designed = {frozenset((p.first, p.second)) for p in arm.pairs if not (p.kept or "never" in p.reason)}
        shapes, owner = self.truth.shapes, self.truth.owner
        shapes.removeAllCollisionPairs()
        for i, first in enumerate(owner):
            for j in range(i):
                if first != owner[j] and frozenset((first, owner[j])) not in designed:
                    shapes.addCollisionPair(pin.CollisionPair(j, i))

    def at(self, q):
        """By pair of links, m."""
        truth = self.truth
        data = pin.GeometryData(truth.shapes)
        whole = self.arm.configuration(q, truth.model)
        pin.updateGeometryPlacements(truth.model, truth.data, truth.shapes, data, whole)
        pin.computeDistances(truth.shapes, data)
        found = {}
        for pair, result in zip(truth.shapes.collisionPairs, data.distanceResults, strict=True):
            key = frozenset((truth.owner[pair.first], truth.owner[pair.second]))
            found[key] = min(found.get(key, np.inf), result.min_distance)
        return found


@pytest.fixture(scope="module")
def distances():
    return Distances(srs_ik.load("gen3"))


def poses(arm, count, salt):
    rng = generator(arm.name, salt)
    lower, upper = np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi)
    return [arm.forward_kinematics(rng.uniform(lower, upper)).homogeneous for _ in range(count)]


@pytest.mark.parametrize("exact", [False, True])
def test_a_margin_that_a_posture_keeps_is_kept(distances, exact):
    arm = distances.arm
    # The widest posture of this pose keeps 68.9 mm between all links.
    q = [2.45004, 1.44423, -0.12574, -1.3756, 1.89677, 1.77036, -1.46945]
    answer = arm.solve(arm.forward_kinematics(q), scene=srs_ik.Scene(exact=exact), margin=0.05)
    assert answer.status == "OK"
    assert min(distances.at(answer.q).values()) > 0.05 - 1e-5


@pytest.mark.slow
@pytest.mark.parametrize("margin", [0.03, 0.05])
def test_a_margin_is_refused_only_where_no_posture_keeps_it(distances, margin):
    arm, refused, kept = distances.arm, 0, 0
    for T in poses(arm, 14, 61):
        answer = arm.solve(T, scene=srs_ik.Scene(), margin=margin)
        if answer:
            kept += 1
            assert min(distances.at(answer.q).values()) > margin - 1e-5
            continue
        refused += 1
        for each in arm.intervals(T):
            for psi in np.linspace(each.lower, each.upper, 9):
                at = arm.solve(T, arm_angle=psi, branch=each.branch)
                assert not at or min(distances.at(at.q).values()) < margin + 1e-3
    assert kept > 5


@pytest.mark.slow
def test_free_arm_angles_keep_the_margin(distances):
    arm, rng, looked, least = distances.arm, generator("gen3", 63), 0, np.inf
    for T in poses(arm, 8, 64):
        for each in arm.intervals(T, scene=srs_ik.Scene(exact=True), margin=0.04):
            for psi in rng.uniform(each.lower, each.upper, 4):
                answer = arm.solve(T, arm_angle=psi, branch=each.branch)
                if answer:
                    looked, least = looked + 1, min(least, *distances.at(answer.q).values())
    assert looked > 40
    assert 0.04 - 1e-5 < least < 0.06


@pytest.mark.slow
@pytest.mark.parametrize("name", ["gen3", "iiwa14"])
def test_what_is_missing_to_a_margin_is_told_as_it_is(name):
    distances = Distances(srs_ik.load(name))
    arm, told = distances.arm, 0
    for T in poses(arm, 8, 65):
        answer = arm.solve(T, scene=srs_ik.Scene(exact=True), margin=0.08)
        if answer.status == "COLLISION":
            told += 1
            first, second, depth = answer.collision
            found = distances.at(answer.q)
            assert abs(found[frozenset((first, second))] - (0.08 - depth)) < 1e-5
            assert min(found.values()) > 0.08 - depth - 1e-5
    assert told > 4


@pytest.mark.slow
def test_paths_keep_a_margin_that_no_range_of_a_joint_keeps(distances):
    arm, scene, checked = distances.arm, srs_ik.Scene(), 0
    q = np.array([0.3, 0.9, -0.4, -1.3, 0.5, 0.9, -0.2])
    path = [arm.forward_kinematics(q + 0.05 * k * np.ones(7)).homogeneous for k in range(4)]
    assert Surroundings(arm, arm.packed, scene, 0.06).jammed is not None
    found = arm.solve_path(path, seed=q, scene=scene, margin=0.06)
    assert set(found.status) == {srs_ik.Status.OK}
    between = {each.sample for each in found.breaks}
    for i in set(range(1, 4)) - between:
        for share in np.linspace(0.0, 1.0, 9):
            checked += 1
            at = (1.0 - share) * found.q[i - 1] + share * found.q[i]
            assert min(distances.at(at).values()) > 0.06 - 2e-5
    assert checked >= 18


def test_where_a_margin_is_too_much_the_posture_given_does_not_collide(tmp_path):
    arm, scene = with_a_thick_neck(tmp_path), srs_ik.Scene()
    truth, asked = Truth(*file_of_and(arm)), 0
    for T in poses(arm, 100, 58):
        answer = arm.solve(T, scene=scene, margin=0.02)
        if answer.status is srs_ik.Status.COLLISION and arm.solve(T, scene=scene):
            asked += 1
            assert not truth.collides(answer.q)
            assert 0.0 < answer.collision.depth <= 0.02
    assert asked > 10
