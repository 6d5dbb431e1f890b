"""Real shapes: distances of convex solids against coal, and answers where spheres leave none against Pinocchio."""

import coal
import numpy as np
import pytest
import trimesh
from arms import generator
from collision_oracle import Truth, file_of_and
from numba import njit
from scene_sets import geometry_of, made, scene_of
from scipy.spatial.transform import Rotation

import srs_ik
from srs_ik.kernels.collision.convex import apart
from srs_ik.kernels.collision.shapes import Shapes

ZERO = srs_ik.pose_from_xyz_rpy([0.0, 0.0, 0.0], [0.0, 0.0, 0.0])


@pytest.fixture(scope="module")
def arm():
    return srs_ik.load("iiwa14")


@pytest.fixture(scope="module")
def solids(arm):
    """The solids of an arm and of objects of each kind, with coal's shapes and where these are."""
    scene, rng = srs_ik.Scene(exact=True), generator("solids", 1)
    scene.add_box("box", ZERO, [0.3, 0.2, 0.1])
    scene.add_sphere("ball", [0.0, 0.0, 0.0], 0.1)
    scene.add_capsule("rod", ZERO, 0.05, 0.3)
    stone = trimesh.convex.convex_hull(rng.normal(scale=0.1, size=(40, 3)))
    scene.add_triangles("stone", ZERO, stone.vertices, stone.faces)
    arm.intervals(arm.forward_kinematics(np.full(7, 0.3)), scene=scene)
    world, zero = arm.__dict__["_real_world"], arm.joint_frames(np.zeros(7))
    placed = [
        (part.shape, (np.eye(4) if joint < 0 else zero[joint]) @ part.T)
        for joint, parts in zip(world.joints, world.parts, strict=True)
        for part in parts
    ]
    return world.solids, placed


@njit
def distance(shapes, i, j, frame, start):
    return apart(shapes, i, j, frame, start, np.inf)


@pytest.mark.numba
def test_distances_of_solids_are_those_of_coal(solids):
    """Never more than the true distance, within coal's own tolerance, and no less by a micrometre."""
    tables, placed = solids
    count = len(placed)
    work = np.empty(count), np.empty((8, 12)), np.zeros((16, 3))
    shapes = Shapes(*tables.tables, np.zeros((1, 3), np.int64), tables.outer, *work)
    rng, met, free = generator("distances", 2), 0, 0
    for _ in range(1000):
        i, j = rng.integers(count, size=2)
        turn, shift = Rotation.random(random_state=rng).as_matrix(), rng.uniform(-0.3, 0.3, 3)
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = turn, shift + tables.solids[j, :3] - turn @ tables.solids[i, :3]
        frame = (tuple(turn.ravel().tolist()), tuple(T[:3, 3].tolist()))
        value, normal = distance(shapes, int(i), int(j), frame, tuple(rng.normal(size=3).tolist()))
        (one, T_one), (other, T_other) = placed[i], placed[j]
        where = [coal.Transform3s(M[:3, :3].copy(), M[:3, 3].copy()) for M in (T @ T_one, T_other)]
        true = coal.distance(one, where[0], other, where[1], coal.DistanceRequest(), coal.DistanceResult())
        if true > 1e-5:
            free += 1
            assert true - 5e-6 <= value <= true + 2e-6
            assert abs(np.linalg.norm(normal) - 1.0) < 1e-12
        elif true < -1e-5:
            met += 1
            # As deep as it is told they are, at most.
            assert true - 1e-4 <= value <= 0.0
    assert free > 300
    assert met > 50


@pytest.mark.parametrize("kind", ["table", "shelf", "box"])
def test_where_spheres_leave_nothing_real_shapes_are_asked(arm, kind):
    """Poses of collision-free postures: all are solved, and no answer collides; most by the spheres alone."""
    rng = generator("iiwa14" + kind, 30)
    truth, objects = Truth(*file_of_and(arm)), made(kind, arm, rng)
    for each in objects:
        truth.add(each.name, each.T, geometry_of(each))
    scene = scene_of(objects)
    poses = []
    while len(poses) < 40:
        q = rng.uniform(arm.lower, arm.upper)
        if not truth.collides(q):
            poses.append(arm.forward_kinematics(q).homogeneous)
    found = arm.solve_batch(np.array(poses), scene=scene)
    assert found.ok.mean() >= 0.97
    assert not any(truth.collides(q) for q in found.q[found.ok])
    by_spheres = [bool(arm.intervals(T, scene=scene)) for T in poses]
    assert np.all(found.ok[by_spheres])
    one = [arm.solve(T, scene=scene) for T in poses]
    assert [each.status for each in one] == list(found.status)


def test_at_one_arm_angle_real_shapes_are_asked_too(arm):
    """At an arm angle that is free on real shapes alone, `solve` gives it."""
    rng = generator("iiwa14", 31)
    objects = made("shelf", arm, rng)
    spheres, real = scene_of(objects), scene_of(objects, exact=True)
    looked = 0
    for _ in range(60):
        T = arm.forward_kinematics(rng.uniform(arm.lower, arm.upper))
        called = arm.intervals(T, scene=spheres)
        for each in arm.intervals(T, scene=real):
            psi = 0.5 * (each.lower + each.upper)
            if any(other.branch == each.branch and psi in other for other in called):
                continue
            answer = arm.solve(T, arm_angle=psi, branch=each.branch, scene=spheres)
            assert answer
            assert abs(np.remainder(answer.arm_angle - psi + np.pi, 2 * np.pi) - np.pi) < 1e-9
            looked += 1
    assert looked > 10


def test_what_is_named_is_in_the_way(arm):
    """The two bodies of a collision are too near to each other at the posture that is given, by as much as is told."""
    rng = generator("iiwa14", 32)
    truth, objects = Truth(*file_of_and(arm)), made("shelf", arm, rng)
    for each in objects:
        truth.add(each.name, each.T, geometry_of(each))
    scene, hits = scene_of(objects), 0
    for _ in range(200):
        answer = arm.solve(arm.forward_kinematics(rng.uniform(arm.lower, arm.upper)), scene=scene)
        if answer.collision is None:
            continue
        hits += 1
        assert truth.collides(answer.q)
        assert answer.collision.depth >= 0.0
    assert hits > 5
