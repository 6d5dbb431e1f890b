"""What a simulated arm meets: walls, pegs, boxes and payloads; and how a motion is replayed."""

import re
from pathlib import Path

import arms
import numpy as np
import pinocchio as pin
import pytest
from browser import PATIENCE, SIZE, changed, chromium, orange, pixels, until

import srs_ik
from srs_ik.control import ForceProfile, FractalImpedance, TorqueController

pytest.importorskip("mujoco", "3.14")

from srs_ik.sim import Box, Payload, Peg, Plant, Wall, World, simulate
from srs_ik.sim.scenery import meshes

HOME = np.array([0.0, 0.6, 0.0, -1.4, 0.0, 0.8, 0.0])


def controller(arm, **options):
    profiles = {"tip": (1000.0, 60.0), "orientation": (60.0, 12.0), "elbow": (600.0, 40.0)}
    ports = [FractalImpedance(on, ForceProfile.tanh(*gains), per_axis=True) for on, gains in profiles.items()]
    return TorqueController(arm, ports, **options)


def test_a_wall_faces_where_its_normal_says():
    arm = arms.load("iiwa14")
    tip = arm.forward_kinematics(HOME).translation
    for normal in np.array([[1.0, 0.0, 0.0], [0.0, -2.0, 0.0], [0.3, 0.4, -0.5], [0.0, 0.0, -1.0]]):
        n = normal / np.linalg.norm(normal)
        for depth in (0.01, -0.01):
            # The ball at the tip has a radius of 20 mm.
            plant = Plant(arm, World(walls=(Wall(tip - (0.02 - depth) * n, normal),)))
            plant.reset(HOME)
            plant.step(plant.bias)
            assert plant.data.ncon == (depth > 0.0)
            if depth > 0.0:
                assert plant.data.contact[0].dist == pytest.approx(-depth, abs=1e-4)


def test_a_wall_bears_the_force_of_the_profile():
    arm = arms.load("iiwa14")
    T = arm.forward_kinematics(HOME)
    wall = Wall(T.translation - 0.07 * np.eye(3)[2], [0.0, 0.0, 1.0])
    plant, c = Plant(arm, World(walls=(wall,)), damping=0.5), controller(arm)
    plant.reset(HOME)
    target = T.homogeneous.copy()
    target[2, 3] -= 0.10
    c.set_target(target, seed=HOME)
    record = simulate(plant, c, 2.0)
    assert record.tip[-1, 2] == pytest.approx(T.translation[2] - 0.05, abs=2e-3)
    # The error that is left, 0.05 m, is held by the wall; ports on the elbow and the turn take a part.
    assert record.contact[-1, 2] == pytest.approx(60.0 * np.tanh(1000.0 * 0.05 / 60.0), rel=0.35)
    assert np.abs(record.contact[-1, :2]).max() < 30.0


@pytest.mark.parametrize("name", ["iiwa14", "gen3", "human_arm"])
def test_a_payload_weighs_where_it_is_held(name):
    arm, rng = arms.load(name), arms.generator(name, 9)
    for centre in ((0.0, 0.0, 0.0), (0.1, 0.2, 0.3)):
        bare, laden = (Plant(arm, World(payload=load)) for load in (None, Payload(2.0, centre)))
        for _ in range(5):
            q = rng.uniform(-2.0, 2.0, 7)
            T = arm.forward_kinematics(q)
            held = T.act(np.array(centre))
            for plant in (bare, laden):
                plant.reset(q)
            place = laden.data.xipos[laden.model.body("payload").id]
            np.testing.assert_allclose((place - laden.p_root_base) @ laden.R_root_base, held, atol=1e-9)
            # By Pinocchio's Jacobian, moved from the tip to the ball.
            J = arm.jacobian(q)
            gravity = laden.R_root_base.T @ arm.model.gravity.linear
            weight = -2.0 * (J[:3] + np.cross(J[3:].T, held - T.translation).T).T @ gravity
            np.testing.assert_allclose(laden.bias - bare.bias, weight, atol=1e-9)


@pytest.mark.slow
def test_a_peg_stops_the_forearm_and_a_payload_lowers_the_hand():
    arm = arms.load("iiwa14")
    record = {}
    for name, world in {
        "free": World(),
        "peg": World(pegs=(Peg([0.3, 0.25, 0.0], [0.3, 0.25, 1.2]),)),
        "payload": World(payload=Payload(2.0)),
    }.items():
        plant, c = Plant(arm, world, damping=2.0), controller(arm)
        plant.reset(HOME)
        c.set_posture([0.9, *HOME[1:]] if name != "payload" else HOME)
        record[name] = simulate(plant, c, 1.5)
    assert record["free"].q[-1, 0] > 0.85
    assert record["peg"].q[:, 0].max() < 0.85
    assert np.linalg.norm(record["peg"].contact, axis=1).max() > 5.0
    sagged = record["payload"].tip[0, 2] - record["payload"].tip[-1, 2]
    assert 0.002 < sagged < 0.1


def placed(arm, q):
    """Where the shapes of the moving links are, (n, 4, 4), base frame."""
    frames = arm.joint_frames(q)
    return [frames[body.joint] @ form.T for body in arm.bodies if body.joint for form in body.forms]


@pytest.mark.parametrize("name", ["iiwa14", "gen3", "human_arm"])
def test_the_arm_meets_the_world_with_the_shapes_of_its_file(name):
    arm, rng = arms.load(name), arms.generator(name, 4)
    T = np.eye(4)
    T[:3, :3] = pin.rpy.rpyToMatrix(0.3, -0.7, 1.1)
    T[:3, 3] = 0.4, -0.2, 0.9
    arm = arm.with_base(T)
    plant = Plant(arm, World(pegs=(Peg([3.0, 0.0, 0.0], [3.0, 0.0, 1.0]),)))
    assert plant.touches_by == "shapes"
    links = np.flatnonzero(plant.model.geom_contype == 2)
    for _ in range(5):
        q = rng.uniform(-2.0, 2.0, 7)
        plant.reset(q)
        wanted = np.array([pose[:3, 3] for pose in placed(arm, q)])
        there = (plant.data.geom_xpos[links] - plant.p_root_base) @ plant.R_root_base
        assert there == pytest.approx(wanted, abs=1e-9)


def test_a_mesh_meets_the_world_as_its_hull(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    trimesh.creation.annulus(0.05, 0.09, 0.3).export(tmp_path / "ring.stl")
    text = (Path(__file__).parents[1] / "robots" / "iiwa14" / "iiwa14.urdf").read_text()
    text = re.sub(r"<collision>.*?</collision>", "", text, flags=re.S)
    link = '<link name="iiwa_link_7">'
    assert link in text
    shape = '<collision><geometry><mesh filename="ring.stl"/></geometry></collision>'
    bare = re.sub(r"<visual>.*?</visual>", "", text.replace(link, link + shape), flags=re.S)
    (tmp_path / "robot.urdf").write_text(bare)
    arm = srs_ik.load(tmp_path / "robot.urdf", tip="iiwa_link_ee")
    plant = Plant(arm, World(boxes=(Box(np.eye(4), [0.1, 0.1, 0.1]),)))
    assert (plant.touches_by, plant.model.nmesh) == ("shapes", 1)
    corners = plant.model.mesh_vert @ np.eye(3)
    assert np.linalg.norm(corners, axis=1).max() == pytest.approx(np.hypot(0.09, 0.15), rel=1e-3)


def test_a_box_stops_the_elbow_that_the_tip_ball_alone_would_let_through():
    arm = arms.load("iiwa14")
    at, there = (arm.joint_frames(q)[4][:3, 3] for q in (HOME, [0.8, *HOME[1:]]))
    pose = np.eye(4)
    pose[:3, 3] = 0.2 * at + 0.8 * there
    turned = {}
    for name, world in {
        "free": World(),
        "shapes": World(boxes=(Box(pose, [0.05, 0.05, 0.4]),)),
        "bars": World(boxes=(Box(pose, [0.05, 0.05, 0.4]),), shapes=False),
    }.items():
        plant, c = Plant(arm, world, damping=2.0), controller(arm)
        plant.reset(HOME)
        c.set_posture([0.8, *HOME[1:]])
        record = simulate(plant, c, 1.0)
        turned[name] = record.q[-1, 0]
        assert (np.linalg.norm(record.contact, axis=1).max() > 5.0) == (name != "free")
    # The links of the file are thicker than the bars.
    assert turned["shapes"] < turned["bars"] - 0.05 < turned["free"] - 0.1


def test_a_whole_wall_meets_the_arm_and_another_one_the_tip_alone():
    arm = arms.load("iiwa14")
    elbow = arm.joint_frames(HOME)[4][:3, 3]
    for whole in (False, True):
        # Behind it stands the elbow, 50 mm deep; the tip is in front.
        wall = Wall(elbow + 0.05 * np.eye(3)[0], [1.0, 0.0, 0.0], whole)
        plant = Plant(arm, World(walls=(wall,)))
        plant.reset(HOME)
        plant.step(plant.bias)
        assert (plant.data.ncon > 0) == whole
        if whole:
            assert plant.contact_force()[0] > 1.0


def test_what_is_drawn_of_a_world_is_where_it_is():
    pytest.importorskip("trimesh")
    pose = np.eye(4)
    pose[:3, 3] = 0.5, 0.1, 0.2
    world = World(
        walls=(Wall([0.3, 0.0, 0.1], [0.0, 2.0, 0.0]),),
        pegs=(Peg([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], 0.03),),
        boxes=(Box(pose, [0.1, 0.2, 0.3]),),
    )
    wall, *peg, box = meshes(world)
    # Its face is at the point, and the rest behind it.
    assert wall.bounds[1] == pytest.approx([0.7, 0.0, 0.5])
    assert wall.bounds[0, 1] < 0.0
    bounds = np.array([piece.bounds for piece in peg])
    assert bounds[:, 0].min(axis=0) == pytest.approx([-0.03, -0.03, -0.03], abs=1e-3)
    assert bounds[:, 1].max(axis=0) == pytest.approx([0.03, 0.03, 1.03], abs=1e-3)
    assert box.bounds == pytest.approx(np.array([[0.45, 0.0, 0.05], [0.55, 0.2, 0.35]]))


def obstacle(image):
    """Share of the pixels in the colour of obstacles."""
    r, g, b = np.moveaxis(image.astype(float), -1, 0)
    return float(((g > 1.3 * r) & (g > 1.15 * b) & (g > 60)).mean())


@pytest.mark.browser
@pytest.mark.slow
def test_a_replay_plays_in_a_browser_without_server_and_network(tmp_path):
    arm = arms.load("iiwa14")
    pose = np.eye(4)
    pose[:3, 3] = 0.45, 0.35, 0.3
    pages = {}
    for name, boxes in (("box", (Box(pose, [0.1, 0.1, 0.6]),)), ("bare", ())):
        plant, c = Plant(arm, World(boxes=boxes)), controller(arm)
        plant.reset(HOME)
        c.set_posture(HOME + 0.3)
        record = simulate(plant, c, 1.0, every=4)
        pages[name] = record.replay(tmp_path / f"{name}.html", target=arm.forward_kinematics(HOME + 0.3))
    green = {}
    with chromium() as browser:
        for name, path in pages.items():
            page = browser.new_page(viewport=SIZE)
            page.context.set_offline(True)
            page.set_default_timeout(PATIENCE)
            page.goto(path.as_uri())
            until(page, lambda page=page: orange(pixels(page)) > 0.001)
            seen = [pixels(page)]
            until(page, lambda page=page, seen=seen: seen.append(pixels(page)) or changed(seen[0], seen[-1]) > 0.01)
            green[name] = obstacle(seen[-1])
            page.close()
    assert green["box"] > green["bare"] + 0.003
