"""Half-spaces and real shapes, against heights above a plane in closed form, of the shapes of the robot's own file."""

import coal
import numpy as np
import pinocchio as pin
import pytest
import trimesh
from arms import generator
from collision_oracle import Truth, file_of_and

import srs_ik

UP = np.array([0.0, 0.6, 0.8])


def least(shape, n):
    """The least that a shape reaches along a unit vector, m."""
    if isinstance(shape, coal.Box):
        return -shape.halfSide @ np.abs(n)
    if isinstance(shape, coal.Sphere):
        return -shape.radius
    if isinstance(shape, coal.Capsule):
        return -shape.radius - shape.halfLength * abs(n[2])
    assert isinstance(shape, coal.Cylinder)
    return -shape.halfLength * abs(n[2]) - shape.radius * np.hypot(n[0], n[1])


def lowest(truth, q, point, normal):
    """The least height above a plane of what the arm moves, m, and which link that is."""
    data = pin.GeometryData(truth.shapes)
    pin.updateGeometryPlacements(truth.model, truth.data, truth.shapes, data, truth.arm.configuration(q, truth.model))
    moved = {body.name for body in truth.arm.bodies if body.joint > 0}
    base = truth.model.frames[truth.model.getFrameId(truth.arm.base)].placement
    heights = {}
    for shape, link, placed in zip(truth.shapes.geometryObjects, truth.owner, data.oMg, strict=True):
        placed = base.actInv(placed)
        own = least(shape.geometry, placed.rotation.T @ normal)
        if link in moved:
            height = normal @ (placed.translation - point) + own
            heights[link] = min(heights.get(link, np.inf), height)
    link = min(heights, key=heights.get)
    return heights[link], link


@pytest.fixture(scope="module", params=["iiwa14", "gen3"])
def truth(request):
    return Truth(*file_of_and(srs_ik.load(request.param)))


def tables(truth, count, salt):
    """Poses, and a table a few centimetres below the tip, tilted, as a scene of real shapes, with its point."""
    arm, rng = truth.arm, generator(truth.arm.name, salt)
    lower, upper = np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi)
    for _ in range(count):
        T = arm.forward_kinematics(rng.uniform(lower, upper)).homogeneous
        point = T[:3, 3] - rng.uniform(0.0, 0.1) * UP
        scene = srs_ik.Scene(exact=True)
        scene.add_half_space("table", point, UP)
        yield T, point, scene


def postures(arm, T, rng, each_has=4):
    for each in arm.intervals(T):
        for psi in rng.uniform(each.lower, each.upper, each_has):
            answer = arm.solve(T, arm_angle=psi, branch=each.branch)
            if answer:
                yield each.branch, psi, answer.q


@pytest.mark.slow
def test_real_shapes_are_free_of_a_half_space_where_they_are(truth):
    arm, rng = truth.arm, generator(truth.arm.name, 52)
    free = called = 0
    for T, point, scene in tables(truth, 40 if arm.limb.kind == "exact" else 8, 51):
        left = arm.intervals(T, scene=scene)
        for branch, psi, q in postures(arm, T, rng):
            height, _ = lowest(truth, q, point, UP)
            is_called = any(each.branch == branch and psi in each for each in left)
            assert height > -1e-6 or not is_called
            if height > 1e-3 and not truth.collides(q):
                free, called = free + 1, called + is_called
    assert free > 15
    assert called >= 0.98 * free


@pytest.mark.slow
def test_what_is_deepest_in_a_half_space_is_told_as_it_is(truth):
    arm, rng = truth.arm, generator(truth.arm.name, 54)
    told = 0
    for T, point, scene in tables(truth, 60 if arm.limb.kind == "exact" else 12, 53):
        answer = arm.solve(T, scene=scene)
        if answer.status != "COLLISION":
            assert lowest(truth, answer.q, point, UP)[0] > -1e-6
            continue
        for _, _, q in postures(arm, T, rng):
            assert lowest(truth, q, point, UP)[0] < 1e-3 or truth.collides(q)
        if answer.collision.second == "table":
            height, link = lowest(truth, answer.q, point, UP)
            assert answer.collision.first == link
            assert abs(answer.collision.depth + height) < 1e-6
            told += 1
    assert told >= 3


def test_a_half_space_moves_and_is_seen_along_a_path():
    arm = srs_ik.load("iiwa14")
    truth = Truth(*file_of_and(arm))
    q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    T = arm.forward_kinematics(q)
    scene = srs_ik.Scene(exact=True)
    scene.add_half_space("floor", [0, 0, 0], [0, 0, 1])
    assert arm.solve(T, scene=scene)
    scene.move("floor", srs_ik.pose_from_xyz_rpy(T.translation, [0, 0, 0]))
    answer = arm.solve(T, scene=scene)
    height, link = lowest(truth, answer.q, T.translation, np.array([0.0, 0.0, 1.0]))
    assert answer.collision[:2] == (link, "floor")
    assert abs(answer.collision.depth + height) < 1e-6
    # A path just above the lowest link of one posture: by spheres, which stick out, there would be none.
    low = lowest(truth, q, np.zeros(3), np.array([0.0, 0.0, 1.0]))[0]
    scene = srs_ik.Scene(exact=True)
    scene.add_half_space("floor", [0, 0, low - 0.003], [0, 0, 1])
    path = arm.solve_path([T.homogeneous, T.homogeneous], seed=q, scene=scene)
    assert (path.status == srs_ik.Status.OK).all()
    assert not path.breaks


def test_a_hollow_mesh_in_the_hand_is_as_near_to_a_wall_as_its_nearest_vertex(tmp_path):
    ring = trimesh.creation.annulus(r_min=0.1, r_max=0.12, height=0.03)
    ring.export(tmp_path / "ring.stl")
    at_tip = srs_ik.pose_from_xyz_rpy([0.05, 0.0, 0.1], [0.4, 0.9, 0.0]).homogeneous
    arm = srs_ik.load("iiwa14").with_object("ring", at_tip, file=tmp_path / "ring.stl")
    told = free = 0
    rng = generator("iiwa14", 55)
    for q in rng.uniform([-1, 0.3, -1, -1.6, -1, 0.3, -1], [1, 1, 1, -0.8, 1, 1.2, 1], (30, 7)):
        T = arm.forward_kinematics(q).homogeneous
        placed = T @ at_tip
        # A wall beyond the ring, seen from the shoulder.
        n = (arm.limb.shoulder - placed[:3, 3]) / np.linalg.norm(arm.limb.shoulder - placed[:3, 3])
        near = ((ring.vertices @ placed[:3, :3].T + placed[:3, 3]) @ n).min()
        for missing in (-1e-4, rng.uniform(0.0, 0.03)):
            scene = srs_ik.Scene(exact=True)
            scene.add_half_space("wall", (near + missing) * n, n)
            answer = arm.solve(T, scene=scene)
            free += bool(answer) and missing < 0.0
            assert answer.status == "COLLISION" or missing < 0.0
            if answer.status == "COLLISION" and answer.collision[:2] == ("ring", "wall"):
                assert abs(answer.collision.depth - missing) < 1e-6
                told += 1
    assert told > 20
    assert free > 20
