"""The mass of an object in the hand, against Jacobians at its centre and Pinocchio's own bodies."""

import arms
import numpy as np
import pinocchio as pin
import pytest
import trimesh

import srs_ik
from srs_ik.analysis.gravity import gravity_torque
from srs_ik.collision.forms import Form
from srs_ik.collision.links.weight import inertia_of

POSE = srs_ik.pose_from_xyz_rpy([0.03, -0.02, 0.1], [0.4, -0.2, 0.9])
FORMS = {
    "box": ({"size": [0.05, 0.08, 0.2]}, pin.Inertia.FromBox(2.0, 0.05, 0.08, 0.2)),
    "sphere": ({"radius": 0.05}, pin.Inertia.FromSphere(2.0, 0.05)),
    "cylinder": ({"radius": 0.05, "length": 0.3}, pin.Inertia.FromCylinder(2.0, 0.05, 0.3)),
}


def torque_of(arm, q):
    return gravity_torque(arm, "")(q)


def weight_at(arm, q, pose, mass):
    """(7,) torques that hold a mass at the origin of a pose in the tip frame: by virtual work."""
    J = arm.with_tool(pose).jacobian(q)[:3]
    base = arm.model.frames[arm.model.getFrameId(arm.base)].placement
    return -J.T @ (base.rotation.T @ arm.model.gravity.linear) * mass


@pytest.mark.parametrize("name", ["iiwa14", "gen3"])
@pytest.mark.parametrize("form", FORMS)
def test_gravity_and_inertia_are_those_of_the_arm_with_the_body(name, form):
    given, inertia = FORMS[form]
    arm = arms.load(name)
    holding = arm.with_object("part", POSE, **given, mass=2.0)
    model = pin.Model(arm.model)
    tip = model.frames[model.getFrameId(arm.tip)]
    model.appendBodyToJoint(7, inertia, tip.placement * POSE)
    assert (holding.held_mass, arm.held_mass) == (2.0, 0.0)
    assert arm.with_object("part", POSE, **given).model == arm.model
    for q in arms.configurations(name, 5, 91):
        expected = torque_of(arm, q) + weight_at(arm, q, POSE, 2.0)
        np.testing.assert_allclose(torque_of(holding, q), expected, rtol=0.0, atol=1e-11)  # N m, rounding
        M, wanted = (pin.crba(each, each.createData(), arm.configuration(q)) for each in (holding.model, model))
        np.testing.assert_allclose(np.triu(M), np.triu(wanted), rtol=0.0, atol=1e-11)  # kg m^2, rounding


def test_what_is_lifted_with_a_part_in_the_hand_is_less_by_its_weight():
    arm = srs_ik.load("iiwa14").with_tool(POSE)
    q = [0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2]
    holding = arm.with_object("part", np.eye(4), radius=0.03, mass=2.0)
    up = [0.0, 0.0, 1.0]
    empty, full = (srs_ik.force_polytope(each, q).radius_along(up) for each in (arm, holding))
    assert empty - full == pytest.approx(2.0 * 9.81, abs=1e-9)  # N, the centre is the tip point


def test_controllers_and_optima_hold_the_part():
    arm = srs_ik.load("iiwa14")
    holding = arm.with_object("part", POSE, radius=0.03, mass=2.0)
    q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    pose = arm.forward_kinematics(q)
    best = holding.optimise(pose, "gravity_torque")
    value = np.sum((torque_of(holding, best.q) / arm.effort_limit) ** 2)
    assert best.value == pytest.approx(value, rel=1e-9)
    other = arm.optimise(pose, "gravity_torque").q
    assert best.value < np.sum((torque_of(holding, other) / arm.effort_limit) ** 2) - 1e-6
    controller = srs_ik.control.TorqueController(holding, [])
    controller.torque(q, np.zeros(7))
    np.testing.assert_allclose(controller.gravity_torque, torque_of(holding, q), rtol=0.0, atol=1e-9)


def test_the_mass_stays_with_other_tools_bases_limits_and_bodies():
    arm = srs_ik.load("iiwa14").with_object("part", POSE, radius=0.03, mass=2.0)
    q = np.full(7, 0.3)
    expected = torque_of(arm, q)
    turned = arm.with_tool(POSE).with_base(POSE).with_limits(upper=arm.upper - 0.1)
    np.testing.assert_allclose(torque_of(turned, q), expected, rtol=0.0, atol=1e-12)
    two = turned.with_object("more", np.eye(4), radius=0.01, mass=0.5)
    assert two.held_mass == 2.5
    np.testing.assert_allclose(
        torque_of(two, q), torque_of(turned, q) + weight_at(turned, q, np.eye(4), 0.5), rtol=0.0, atol=1e-11
    )


def test_a_mesh_is_a_solid_of_one_density(tmp_path):
    arm, q = srs_ik.load("iiwa14"), np.full(7, 0.4)
    mesh = trimesh.creation.box([0.1, 0.2, 0.3])
    mesh.apply_translation([0.05, 0.0, 0.0])
    torques = []
    for k, faces in enumerate((mesh.faces, mesh.faces[1:])):  # the second has a hole, and counts as its hull
        trimesh.Trimesh(mesh.vertices, faces).export(tmp_path / f"{k}.stl")
        torques.append(torque_of(arm.with_object("part", POSE, file=tmp_path / f"{k}.stl", mass=2.0), q))
    centre = POSE * pin.SE3(np.eye(3), np.array([0.05, 0.0, 0.0]))
    expected = torque_of(arm, q) + weight_at(arm, q, centre, 2.0)
    np.testing.assert_allclose(torques, [expected, expected], rtol=0.0, atol=1e-5)  # N m; the file has single precision


@pytest.mark.parametrize("mass", [0.0, -1.0, np.nan, np.inf, "2"])
def test_masses_that_are_none(mass):
    with pytest.raises(srs_ik.errors.InvalidScene, match="the mass of 'part' is a positive number, kg, not"):
        srs_ik.load("iiwa14").with_object("part", POSE, radius=0.03, mass=mass)


def test_an_arm_without_masses_holds_none():
    model = pin.Model(srs_ik.load("iiwa14").model)
    for k in range(len(model.inertias)):
        model.inertias[k] = pin.Inertia.Zero()
    arm = srs_ik.load(model, base="iiwa_link_0", tip="iiwa_link_ee")
    with pytest.raises(srs_ik.errors.InvalidRobot, match="has no masses"):
        arm.with_object("part", POSE, radius=0.03, mass=1.0)


def test_a_simulated_arm_carries_the_part():
    pytest.importorskip("mujoco")
    from srs_ik.sim.model import make_spec

    arm = srs_ik.load("iiwa14")
    masses = []
    for each in (arm, arm.with_object("part", POSE, radius=0.03, mass=2.0)):
        spec, _ = make_spec(each)
        masses.append(spec.compile().body_subtreemass[spec.body(spec.joint(arm.joint_names[0]).parent.name).id])
    assert masses[1] - masses[0] == pytest.approx(2.0, abs=1e-9)  # kg, of all that joint 1 moves


def test_what_has_no_volume_has_no_mass():
    flat = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.1, 0.1, 0.0]])
    faces = np.array([[0, 1, 2], [1, 3, 2]])
    form = Form("mesh", (), np.eye(4), flat, faces)
    with pytest.raises(srs_ik.InvalidScene, match="'sheet' encloses no volume"):
        inertia_of(form, 1.0, "sheet")
