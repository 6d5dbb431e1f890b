"""Spheres that cover links: coverage by sampled surfaces, solids of revolution by turned samples, files of spheres."""

import json
import re

import numpy as np
import pytest
import trimesh

import srs_ik
from srs_ik.collision.forms import Form, planes, surface
from srs_ik.collision.links.bodies import revolved
from srs_ik.collision.links.cover import cover
from srs_ik.errors import InvalidScene, NoBodies


def sampled(form, count=4000):
    """Points of the real surface of a form."""
    rng = np.random.default_rng(0)
    if form.kind == "mesh":
        mesh = trimesh.Trimesh(form.vertices, form.faces, process=False)
        points = trimesh.sample.sample_surface(mesh, count, seed=0)[0]
    elif form.kind == "box":
        points = trimesh.sample.sample_surface(trimesh.creation.box(form.size), count, seed=0)[0]
    elif form.kind == "cylinder":
        r, length = form.size
        turn, z = rng.uniform(-np.pi, np.pi, count), rng.uniform(-0.5, 0.5, count) * length
        rho = np.where(rng.random(count) < 0.5, r, r * np.sqrt(rng.random(count)))
        z = np.where(rho < r, np.sign(z) * 0.5 * length, z)
        points = np.column_stack([rho * np.cos(turn), rho * np.sin(turn), z])
    else:
        directions = rng.normal(size=(count, 3))
        points = form.size[0] * directions / np.linalg.norm(directions, axis=1, keepdims=True)
        if form.kind == "capsule":
            points[:, 2] += np.sign(points[:, 2]) * 0.5 * form.size[1]
    return points @ form.T[:3, :3].T + form.T[:3, 3]


def outside(points, spheres):
    """How far points are outside of all spheres, m; the largest, negative where all are inside."""
    return (np.linalg.norm(points[:, None] - spheres[None, :, :3], axis=2) - spheres[:, 3]).min(axis=1).max()


@pytest.mark.parametrize("name", ["iiwa14", "human_arm", "gen3"])
def test_every_point_of_the_shapes_is_in_a_sphere(name):
    for body in srs_ik.load(name).bodies:
        for form in body.forms:
            assert outside(sampled(form), body.spheres) < 1e-9, body


@pytest.mark.slow
@pytest.mark.parametrize(
    "make", [lambda: trimesh.creation.torus(0.2, 0.03), lambda: trimesh.creation.icosphere(radius=0.1)]
)
def test_all_triangles_are_proved_to_be_covered(make):
    mesh = make()
    for count in (4, 16, 40):
        found = cover(mesh.vertices, mesh.faces, count)
        corners, triangles = trimesh.remesh.subdivide_to_size(mesh.vertices, mesh.faces, 0.002, max_iter=20)
        assert len(found.spheres) <= count
        assert outside(corners, found.spheres) < 1e-9
        assert is_covered(found.spheres, corners, triangles, slack=0.002).all()
    assert found.protrusion < 0.03


def test_protrusion_is_the_distance_from_the_surface():
    mesh = trimesh.creation.icosphere(subdivisions=4, radius=0.1).apply_scale([1.0, 2.0, 0.4])
    found = cover(mesh.vertices, mesh.faces, 12)
    ball = trimesh.creation.icosphere(subdivisions=2).vertices
    points = (found.spheres[:, None, :3] + found.spheres[:, None, 3:] * ball).reshape(-1, 3)
    measured = -trimesh.proximity.signed_distance(mesh, points).min()
    # It is measured to corners of small triangles, which are some millimetres apart.
    assert abs(measured - found.protrusion) < 4e-3


@pytest.mark.parametrize(("joint", "axis"), [(1, 0), (2, 2), (5, 4), (6, 6)])
def test_a_solid_of_revolution_holds_all_turns(joint, axis):
    arm = srs_ik.load("iiwa14")
    (body,) = [body for body in arm.bodies if body.joint == joint]
    rows = revolved(arm, body, axis, (arm.limb.axes, arm.limb.points))
    T = arm.joint_frames(np.zeros(7))[joint]
    direction, point = arm.limb.axes[axis], arm.limb.points[axis]
    for turn in np.linspace(-3, 3, 7):
        R = trimesh.transformations.rotation_matrix(turn, direction, point)
        for form in body.forms:
            points = sampled(form, 500) @ T[:3, :3].T + T[:3, 3]
            assert outside(points @ R[:3, :3].T + R[:3, 3], rows) < 1e-9


@pytest.mark.parametrize(
    ("kind", "size"),
    [("box", (0.1, 0.2, 0.3)), ("cylinder", (0.05, 0.3)), ("capsule", (0.05, 0.3)), ("sphere", (0.1,))],
)
def test_planes_and_triangles_go_around_a_form(kind, size):
    T = srs_ik.pose_from_xyz_rpy([0.1, -0.2, 0.3], [0.4, 0.5, 0.6]).homogeneous
    form = Form(kind, size, T)
    points = sampled(form)
    vertices, faces = surface(form)
    mesh = trimesh.Trimesh(vertices, faces, process=True)
    assert mesh.is_watertight
    assert mesh.volume > 0
    assert trimesh.proximity.signed_distance(mesh, points[:300]).min() > -1e-9
    if kind != "sphere":
        rows = planes(form)
        assert (points @ rows[:, :3].T - rows[:, 3]).max() < 1e-12


def test_spheres_of_curobo_and_foam(tmp_path):
    arm = srs_ik.load("iiwa14")
    (tmp_path / "a.yml").write_text(
        "robot_cfg: {kinematics: {collision_spheres: {\n"
        "  iiwa_link_3: [{center: [0, 0, 0.1], radius: 0.1}, {center: [0, 0, 0], radius: -1}],\n"
        "  iiwa_link_4: [{center: [0.0, 0.1, 0.0], radius: 0.05}]}}}\n"
    )
    (tmp_path / "b.json").write_text(json.dumps({"iiwa_link_3": {"spheres": [{"origin": [0, 0, 0.1], "radius": 0.1}]}}))
    a = arm.with_bodies(spheres=tmp_path / "a.yml").bodies
    assert [(body.name, len(body.spheres), body.source) for body in a] == [
        ("iiwa_link_3", 1, "spheres"),
        ("iiwa_link_4", 1, "spheres"),
    ]
    (b,) = arm.with_bodies(spheres=tmp_path / "b.json").bodies
    assert np.allclose(b.spheres, a[0].spheres)
    T = arm.forward_kinematics(np.full(7, 0.5))
    assert arm.with_bodies(spheres=tmp_path / "a.yml").intervals(T, scene=srs_ik.Scene())
    for wrong in ("[]", "{", '{"iiwa_link_3": 3}', '{"iiwa_link_3": [[1, 2]]}', '{"iiwa_link_3": [[1, 2, 3, 1e999]]}'):
        (tmp_path / "c.json").write_text(wrong)
        with pytest.raises(InvalidScene, match=r"c\.json"):
            arm.with_bodies(spheres=tmp_path / "c.json").bodies  # noqa: B018


def test_an_arm_without_shapes_says_so():
    arm = srs_ik.load("iiwa14")
    bare = srs_ik.load(arm.model, base=arm.base, tip=arm.tip)
    with pytest.raises(NoBodies, match="no shapes"):
        bare.intervals(np.eye(4), scene=srs_ik.Scene())


def test_an_arm_with_shapes_of_its_base_alone_says_so():
    base, rest = srs_ik.load("iiwa14").drawing.file.read_text().split("</link>", 1)
    rest = re.sub(r"<(collision|visual)\b.*?</\1>", "", rest, flags=re.DOTALL)
    arm = srs_ik.load(f"{base}</link>{rest}", tip="iiwa_link_ee")
    with pytest.raises(NoBodies, match="no shapes of links that move"):
        arm.intervals(np.eye(4), scene=srs_ik.Scene())


def test_what_the_hand_holds_counts():
    arm = srs_ik.load("iiwa14")
    holding = arm.with_object("stick", srs_ik.pose_from_xyz_rpy([0.2, 0, 0], [0, 0, 0]), size=[0.3, 0.02, 0.02])
    assert [body.name for body in holding.bodies][-1] == "stick"
    scene = srs_ik.Scene()
    q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    T = arm.forward_kinematics(q)
    end = (T.homogeneous @ [0.34, 0, 0, 1])[:3]
    scene.add_sphere("bump", end, 0.03)
    assert arm.solve(T, scene=scene)
    hit = holding.solve(T, scene=scene)
    assert hit.status == "COLLISION"
    assert set(hit.collision[:2]) == {"stick", "bump"}
    assert hit.collision.depth > 0.02
    with pytest.raises(InvalidScene, match="already"):
        holding.with_object("stick", np.eye(4), radius=0.1)
    with pytest.raises(InvalidScene, match="is given by"):
        arm.with_object("stick", np.eye(4))
    for link in ("iiwa_link_3", "iiwa_link_ee"):
        with pytest.raises(InvalidScene, match=f"'{link}' is a link of iiwa14: an object in its hand needs another"):
            holding.with_object(link, np.eye(4), radius=0.1)
    scene.add_sphere("stick", [0.0, 0.0, 3.0], 0.1)
    with pytest.raises(InvalidScene, match="'stick' is a body of the arm"):
        holding.solve(T, scene=scene)
    tool = holding.with_tool(srs_ik.pose_from_xyz_rpy([0.1, 0, 0], [0, 0, 0]))
    assert "stick" in [body.name for body in tool.bodies]


@pytest.mark.slow
def test_a_base_and_a_tool_leave_what_was_found_of_the_links(monkeypatch):
    arm = srs_ik.load("iiwa14")
    scene = srs_ik.Scene()
    q = [0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2]
    T = arm.forward_kinematics(q)
    expected = arm.intervals(T, scene=scene)

    def refuse(*args):
        raise AssertionError("looked for again")

    monkeypatch.setattr("srs_ik.collision.links.bodies.cover", refuse)
    monkeypatch.setattr("srs_ik.collision.links.ranges.Bounds.over", refuse)
    rng = np.random.default_rng(3)
    for _ in range(5):
        T_base, T_tool = (srs_ik.pose_from_xyz_rpy(rng.normal(size=3), rng.uniform(-3, 3, 3)) for _ in range(2))
        other = arm.with_base(T_base).with_tool(T_tool)
        found = other.intervals(T_base @ T.homogeneous @ T_tool, scene=scene)
        assert [i.branch for i in found] == [i.branch for i in expected]
        # Arm angles are told from a direction that no base changes.
        for a, b in zip(found, expected, strict=True):
            assert abs(a.upper - a.lower - (b.upper - b.lower)) < 1e-9


@pytest.mark.parametrize("name", ["iiwa14", "gen3"])
def test_an_arm_on_another_base_has_the_same_spheres(name):
    arm, T = srs_ik.load(name), srs_ik.pose_from_xyz_rpy([0.3, -0.2, 0.5], [1.0, -0.7, 2.0]).homogeneous
    here, there = (each.tables(srs_ik.Scene()) for each in (arm, arm.with_base(T)))
    # The balls around them come first; these depend on the axes of the base.
    own, moved = (tables.bodies[tables.groups[0, 0] :] for tables in (here, there))
    np.testing.assert_allclose(moved[:, :3], own[:, :3] @ T[:3, :3].T + T[:3, 3], atol=1e-9)
    np.testing.assert_allclose(moved[:, 3], own[:, 3], atol=1e-12)


def test_spheres_of_links_that_are_not_there_are_refused(tmp_path):
    arm, one = srs_ik.load("iiwa14"), [{"center": [0, 0, 0.1], "radius": 0.1}]

    def with_spheres(links):
        (tmp_path / "a.json").write_text(json.dumps(links))
        return arm.with_bodies(spheres=tmp_path / "a.json")

    with pytest.raises(InvalidScene, match=r"given for 'iiwa_lnk_2' \(did you mean 'iiwa_link_2'"):
        with_spheres({"iiwa_link_1": one, "iiwa_lnk_2": one}).intervals(np.eye(4), scene=srs_ik.Scene())
    with pytest.raises(NoBodies, match="no link that moves"):
        with_spheres({"iiwa_link_0": one}).bodies  # noqa: B018
    # As cuRobo writes of an object that is not held yet.
    held = {"attached_object": [{"center": [0, 0, 0], "radius": -10.0}]}
    assert [body.name for body in with_spheres({"iiwa_link_1": one, **held}).bodies] == ["iiwa_link_1"]


def test_spheres_may_be_given_by_the_names_of_links(tmp_path):
    arm = srs_ik.load("iiwa14")
    given = {"iiwa_link_3": np.array([[0, 0, 0.1, 0.1], [0, 0, 0.2, 0.05]]), "iiwa_link_4": [[0.0, 0.1, 0.0, 0.05]]}
    (tmp_path / "all.json").write_text(json.dumps({name: np.array(rows).tolist() for name, rows in given.items()}))
    direct, by_file = arm.with_bodies(spheres=given), arm.with_bodies(spheres=tmp_path / "all.json")
    assert [body.name for body in direct.bodies] == list(given)
    for one, other in zip(direct.bodies, by_file.bodies, strict=True):
        assert np.array_equal(one.spheres, other.spheres)
    # A model has no shapes.
    bare = srs_ik.load(arm.model, base=arm.base, tip=arm.tip)
    T, scene = arm.forward_kinematics([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2]), srs_ik.Scene()
    with pytest.raises(srs_ik.NoBodies):
        bare.solve(T, scene=scene)
    assert bare.with_bodies(spheres=given).solve(T, scene=scene)


@pytest.mark.parametrize(
    ("rows", "says"), [("x", "iiwa_link_3"), ([[0, 0, 1]], "iiwa_link_3"), ([[0, 0, np.nan, 1]], "iiwa_link_3")]
)
def test_spheres_that_are_none_are_named(rows, says):
    arm = srs_ik.load("iiwa14")
    with pytest.raises(srs_ik.InvalidScene, match=says):
        arm.with_bodies(spheres={"iiwa_link_3": rows}).bodies  # noqa: B018


def is_covered(spheres, corners, triangles, slack=0.0):
    """(m,) whether each triangle lies in one sphere, whole: a proof that it is covered, where it is true.

    Spheres (n, 4) are centre and radius, corners (k, 3), triangles (m, 3); `slack` is added to the radii, all m.
    """
    distance = np.linalg.norm(corners[:, None, :] - spheres[None, :, :3], axis=2)
    reach = np.maximum.reduce([distance[triangles[:, k]] for k in range(3)])
    return np.asarray((reach <= spheres[:, 3] + slack).any(axis=1))


def test_spheres_without_a_size_are_none():
    arm = srs_ik.load("iiwa14").with_bodies(spheres={"iiwa_link_4": [[0.0, 0.0, 0.1, -0.06]]})
    with pytest.raises(
        srs_ik.NoBodies, match="no link that moves has one of the spheres that are given, of radii above 0"
    ):
        arm.bodies  # noqa: B018
