"""The URDFs of the built-in robots, against the upstream files and the formulas that they stand for."""

import xml.etree.ElementTree as ElementTree

import numpy as np
import pinocchio
import pytest
import yourdfpy
from robot_files import SHARED

from srs_ik.robot import zoo

UPSTREAM = SHARED
ROBOTS = zoo.robots()


def model_of(name: str) -> pinocchio.Model:
    return pinocchio.buildModelFromUrdf(str(zoo.card(name).urdf))


def pose(model: pinocchio.Model, q: np.ndarray, frame: str) -> np.ndarray:
    """Pose of a frame, 4x4; q as one angle a joint, in the order of the model."""
    assert model.existFrame(frame), frame
    data = model.createData()
    pinocchio.framesForwardKinematics(model, data, pinocchio.integrate(model, pinocchio.neutral(model), q))
    return data.oMf[model.getFrameId(frame)].homogeneous


def upstream_model(file: str) -> pinocchio.Model:
    path = UPSTREAM / file
    if not path.is_file():
        pytest.skip(f"upstream file {file} is not in {UPSTREAM.name}/")
    return pinocchio.buildModelFromUrdf(str(path))


@pytest.mark.parametrize(
    ("name", "file", "frames"),
    [
        (
            "iiwa14",
            "iiwa14_drake_models.urdf",
            ["iiwa_link_ee", "iiwa_link_ee_kuka", *(f"iiwa_link_{i}" for i in range(8))],
        ),
        (
            "gen3",
            "kinova_gen3_7dof.urdf",
            [
                "end_effector_link",
                "base_link",
                "shoulder_link",
                "half_arm_1_link",
                "half_arm_2_link",
                "forearm_link",
                "spherical_wrist_1_link",
                "spherical_wrist_2_link",
                "bracelet_link",
            ],
        ),
    ],
)
class TestAgainstUpstream:
    def test_every_link_lies_where_upstream_has_it(self, name: str, file: str, frames: list[str]):
        ours, theirs = model_of(name), upstream_model(file)
        assert zoo.card(name).tip == frames[0]
        rng = np.random.default_rng(14)
        for q in rng.uniform(-np.pi, np.pi, (1000, 7)):
            difference = pose(ours, q, frames[0]) - pose(theirs, q, frames[0])
            assert np.abs(difference).max() < 1e-9
        for frame in frames:
            np.testing.assert_allclose(pose(ours, q, frame), pose(theirs, q, frame), rtol=0, atol=1e-9)

    def test_names_limits_and_masses_are_those_of_upstream(self, name: str, file: str, frames: list[str]):
        ours, theirs = model_of(name), upstream_model(file)
        assert list(ours.names) == list(theirs.names)
        assert [joint.shortname() for joint in ours.joints] == [joint.shortname() for joint in theirs.joints]
        for ours_limit, theirs_limit in (
            (ours.lowerPositionLimit, theirs.lowerPositionLimit),
            (ours.upperPositionLimit, theirs.upperPositionLimit),
            (ours.velocityLimit, theirs.velocityLimit),
            (ours.effortLimit, theirs.effortLimit),
        ):
            np.testing.assert_allclose(ours_limit, theirs_limit, rtol=0, atol=1e-9)
        for ours_inertia, theirs_inertia in zip(ours.inertias[1:], theirs.inertias[1:], strict=True):
            assert ours_inertia.isApprox(theirs_inertia, 1e-9)


def test_iiwa14_has_the_published_lengths_and_axes():
    model = model_of("iiwa14")
    zero = np.zeros(7)
    heights = [pose(model, zero, f"iiwa_link_{i}")[2, 3] for i in (2, 4, 6)]
    np.testing.assert_allclose(heights, [0.360, 0.780, 1.180], rtol=0, atol=1e-12)
    flange = pose(model, zero, "iiwa_link_ee")
    np.testing.assert_allclose(flange[:3, 3], [0, 0, 1.306], rtol=0, atol=1e-12)
    axes = [pose(model, zero, f"iiwa_link_{i}")[:3, 2] for i in range(1, 8)]
    signs = [[0, 0, 1], [0, 1, 0], [0, 0, 1], [0, -1, 0], [0, 0, 1], [0, 1, 0], [0, 0, 1]]
    np.testing.assert_allclose(axes, signs, rtol=0, atol=1e-12)
    np.testing.assert_allclose(np.degrees(model.upperPositionLimit), [170, 120, 170, 120, 170, 120, 175], atol=1e-9)
    np.testing.assert_allclose(model.lowerPositionLimit, -model.upperPositionLimit)
    np.testing.assert_allclose(np.degrees(model.velocityLimit), [85, 85, 100, 75, 130, 135, 135], atol=1e-9)
    np.testing.assert_allclose(model.effortLimit, [320, 320, 176, 176, 110, 40, 40])


def test_iiwa14_hand_axes_are_those_of_the_flange():
    card = zoo.card("iiwa14")
    T_base_tip = pose(model_of("iiwa14"), np.zeros(7), card.tip)
    np.testing.assert_allclose(T_base_tip[:3, :3] @ card.grasp, [0, 0, 1], rtol=0, atol=1e-12)
    np.testing.assert_allclose(T_base_tip[:3, :3] @ card.pronosupination, [1, 0, 0], rtol=0, atol=1e-12)


def rotation_z(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def permuted(R: np.ndarray, columns: str) -> np.ndarray:
    """The matrix whose columns are the named ones of R, "-z" for the negative third."""
    return np.column_stack([(-1 if name[0] == "-" else 1) * R[:, "xyz".index(name[-1])] for name in columns.split()])


def human_by_the_formulas(q: np.ndarray) -> np.ndarray:
    """Hand pose of the paper's limb: each joint turns about the z of a frame that permutes the previous one's axes."""
    R = np.eye(3)
    rotations = []
    for columns, angle in zip(("x y z", "x -z y", "-z y x", "z -x -y", "z -y x", "z x y", "x -z y"), q, strict=True):
        R = permuted(R, columns) @ rotation_z(angle)
        rotations.append(R)
    elbow = rotations[2] @ [0, 0, 0.37]
    wrist = elbow + rotations[3] @ [0.32, 0, 0]
    T = np.eye(4)
    T[:3, :3] = R
    T[:3, 3] = wrist + R @ [0.10, 0, 0]
    return T


def test_human_arm_follows_the_formulas():
    model, tip = model_of("human_arm"), zoo.card("human_arm").tip
    rng = np.random.default_rng(7)
    for q in rng.uniform(-np.pi, np.pi, (1000, 7)):
        np.testing.assert_allclose(pose(model, q, tip), human_by_the_formulas(q), rtol=0, atol=1e-12)


def test_human_arm_points_forward_at_zero():
    expected = np.eye(4)
    expected[0, 3] = 0.79
    np.testing.assert_allclose(pose(model_of("human_arm"), np.zeros(7), "hand_tip"), expected, rtol=0, atol=1e-12)


def human_at(**degrees: float) -> np.ndarray:
    model = model_of("human_arm")
    q = np.zeros(7)
    for joint, angle in degrees.items():
        index = model.getJointId(joint) - 1
        assert index < 7, joint
        q[index] = np.radians(angle)
        assert model.lowerPositionLimit[index] <= q[index] <= model.upperPositionLimit[index], joint
    return pose(model, q, "hand_tip")


# x forward, y left, z up; the thumb of this left hand is -y of hand_tip, its back is z.
@pytest.mark.parametrize(
    ("posture", "fingers", "thumb"),
    [
        pytest.param({"shoulder_yaw": 90}, [0, 1, 0], [1, 0, 0], id="yaw points the arm to the left"),
        pytest.param({"shoulder_pitch": 90}, [0, 0, -1], [0, -1, 0], id="pitch lets it hang"),
        pytest.param({"elbow": -90}, [0, -1, 0], [-1, 0, 0], id="the elbow bends inwards"),
        pytest.param(
            {"shoulder_pitch": 90, "shoulder_roll": -90, "elbow": -90},
            [1, 0, 0],
            [0, 0, 1],
            id="forearm forward, thumb up",
        ),
        pytest.param(
            {"shoulder_pitch": 90, "shoulder_roll": -90, "elbow": -90, "forearm_roll": 80},
            [1, 0, 0],
            [0, -np.sin(np.radians(80)), np.cos(np.radians(80))],
            id="pronation turns the thumb inwards",
        ),
        pytest.param(
            {"wrist_flexion": 70}, [np.cos(np.radians(70)), 0, np.sin(np.radians(70))], [0, -1, 0], id="extension"
        ),
        pytest.param({"wrist_deviation": 30}, [np.cos(np.pi / 6), 0.5, 0], [0.5, -np.cos(np.pi / 6), 0], id="ulnar"),
    ],
)
def test_human_arm_moves_as_its_file_says(posture: dict[str, float], fingers: list[float], thumb: list[float]):
    T = human_at(**posture)
    np.testing.assert_allclose(T[:3, 0], fingers, rtol=0, atol=1e-12)
    np.testing.assert_allclose(-T[:3, 1], thumb, rtol=0, atol=1e-12)


def test_human_arm_has_the_cited_ranges_and_torques():
    model = model_of("human_arm")
    np.testing.assert_allclose(np.degrees(model.lowerPositionLimit), [-40, -90, -180, -150, -80, -80, -20], atol=1e-9)
    np.testing.assert_allclose(np.degrees(model.upperPositionLimit), [90, 150, 70, 0, 80, 70, 30], atol=1e-9)
    np.testing.assert_allclose(model.effortLimit, [0, 68.6, 0, 49, 13.1, 7.1, 9.5])
    assert sum(inertia.mass for inertia in model.inertias) == pytest.approx(73.0 * (0.0271 + 0.0162 + 0.0061))


@pytest.mark.parametrize("name", ROBOTS)
def test_files_load_without_a_word(name: str, capfd: pytest.CaptureFixture, caplog: pytest.LogCaptureFixture):
    path = str(zoo.card(name).urdf)
    pinocchio.buildModelFromUrdf(path)
    for kind in (pinocchio.GeometryType.VISUAL, pinocchio.GeometryType.COLLISION):
        pinocchio.buildGeomFromUrdf(pinocchio.buildModelFromUrdf(path), path, kind)
    robot = yourdfpy.URDF.load(path)
    assert robot.validate()
    assert len(robot.actuated_joint_names) == 7
    captured = capfd.readouterr()
    assert captured.out == ""
    assert captured.err == ""
    assert caplog.records == []


@pytest.mark.parametrize("name", ROBOTS)
def test_base_tip_and_chain_are_those_of_the_card(name: str):
    card = zoo.card(name)
    robot = yourdfpy.URDF.load(str(card.urdf))
    assert robot.base_link == card.base
    assert card.tip in robot.link_map
    assert robot.robot.name == name


@pytest.mark.parametrize("name", ROBOTS)
def test_inertias_are_physically_possible(name: str):
    seen = 0
    for link in ElementTree.parse(zoo.card(name).urdf).iter("link"):
        inertial = link.find("inertial")
        if inertial is None:
            continue
        seen += 1
        entries = {key: float(value) for key, value in inertial.find("inertia").attrib.items()}
        tensor = np.array(
            [
                [entries["ixx"], entries["ixy"], entries["ixz"]],
                [entries["ixy"], entries["iyy"], entries["iyz"]],
                [entries["ixz"], entries["iyz"], entries["izz"]],
            ]
        )
        small, middle, large = np.linalg.eigvalsh(tensor)
        assert float(inertial.find("mass").attrib["value"]) > 0
        assert small > 0, link.attrib["name"]
        assert large <= small + middle, link.attrib["name"]
    assert seen >= 3


@pytest.mark.parametrize("name", ROBOTS)
def test_the_whole_arm_is_drawn_from_primitives(name: str):
    root = ElementTree.parse(zoo.card(name).urdf).getroot()
    colours = {material.attrib["name"] for material in root.findall("material")}
    shapes = [next(iter(geometry)).tag for geometry in root.iter("geometry")]
    assert set(shapes) <= {"box", "cylinder", "sphere"}
    assert {
        material.attrib["name"] for visual in root.iter("visual") for material in visual.iter("material")
    } == colours
    for link in root.iter("link"):
        # A frame without a body bears neither mass nor shape; what one can see one can also collide with.
        assert (link.find("visual") is None) == (link.find("collision") is None), link.attrib["name"]


@pytest.mark.parametrize("name", ROBOTS)
def test_no_part_floats(name: str):
    """In random postures the drawn parts hang together as one body: from the base each is reached through overlaps."""
    card = zoo.card(name)
    model = pinocchio.buildModelFromUrdf(str(card.urdf))
    shapes = pinocchio.buildGeomFromUrdf(model, str(card.urdf), pinocchio.GeometryType.VISUAL)
    pairs = [(i, j) for i in range(shapes.ngeoms) for j in range(i)]
    for i, j in pairs:
        shapes.addCollisionPair(pinocchio.CollisionPair(j, i))
    data, shape_data = model.createData(), shapes.createData()
    rng = np.random.default_rng(3)
    for _ in range(3):
        q = pinocchio.integrate(model, pinocchio.neutral(model), rng.uniform(-1.5, 1.5, 7))
        pinocchio.updateGeometryPlacements(model, data, shapes, shape_data, q)
        pinocchio.computeCollisions(shapes, shape_data, False)
        touching = [
            pair for pair, result in zip(pairs, shape_data.collisionResults, strict=True) if result.isCollision()
        ]
        reached, size = {0}, 0
        while len(reached) > size:
            size = len(reached)
            reached |= {k for pair in touching if reached & set(pair) for k in pair}
        assert len(reached) == shapes.ngeoms
