"""Every robot with a name, on its file where that is at hand: 200 poses each, by Pinocchio on the untouched file."""

import tempfile
from importlib import metadata
from pathlib import Path

import numpy as np
import pytest
from oracles import Forward, random_angles
from robot_files import example_urdf, shared_urdf

import srs_ik
from srs_ik.errors import InvalidRobot
from srs_ik.robot import zoo
from srs_ik.robot.description import xacro
from srs_ik.robot.places import locate
from srs_ik.robot.sources import catalogue

ELSEWHERE = {
    "human_left": ("example", "human"),
    "human_right": ("example", "human"),
    "icub_left": ("example", "icub"),
    "icub_right": ("example", "icub"),
    "romeo_left": ("example", "romeo"),
    "romeo_right": ("example", "romeo"),
    "med7": ("shared", "med7_lbr_stack"),
    "j2s7s300": ("shared", "kinova_j2s7s300"),
    "rm75": ("shared", "realman_rm75"),
    "sia10": ("shared", "motoman_sia10f"),
    "openarm_left": ("shared", "openarm_v10_bimanual"),
    "openarm_right": ("shared", "openarm_v10_bimanual"),
    "h1_2_left": ("shared", "unitree_h1_2_handless"),
    "h1_2_right": ("shared", "unitree_h1_2_handless"),
    "iiwa7": ("installed", "differentiable-robot-model"),
    "med14": ("clone", "lbr_fri_ros2_stack"),
    "sia20": ("clone", "motoman"),
    "sia30": ("clone", "motoman"),
}
"""The file that each description comes from, or a copy of it: where tests look for one, without fetching any."""

KINDS = {"gen3": "near", "j2s7s300": "near", "h1_2_left": "near", "h1_2_right": "near"}


def file_of(name: str):
    if name not in ELSEWHERE:
        return zoo.card(name).urdf
    kind, file = ELSEWHERE[name]
    if kind == "installed":
        return installed_file(file, "kuka_iiwa/urdf/iiwa7.urdf")
    if kind == "clone":
        return cloned_file(zoo.card(name).places[0], file)
    return example_urdf(file) if kind == "example" else shared_urdf(file)


def installed_file(package: str, wanted: str) -> Path:
    """A file of an installed package; this one needs `pip install --no-deps`."""
    try:
        files = metadata.files(package) or ()
    except metadata.PackageNotFoundError:
        files = ()
    for file in files:
        if str(file).endswith(wanted):
            return Path(str(file.locate()))
    pytest.skip(f"{package} is not installed")


def cloned_file(place: str, repository: str) -> Path:
    """URDF of a xacro file in a clone on ROS_PACKAGE_PATH, made by the package xacro."""
    pytest.importorskip("xacro")
    try:
        path = locate([place], repository).path
    except InvalidRobot:
        pytest.skip(f"no clone of {repository} is on ROS_PACKAGE_PATH")
    expanded = Path(tempfile.mkdtemp()) / f"{path.stem}.urdf"
    expanded.write_text(xacro.expand(path, path.name, {}))
    return expanded


@pytest.mark.parametrize("name", srs_ik.robots())
def test_200_poses_of_every_named_robot(name):
    path, card = file_of(name), zoo.card(name)
    arm = srs_ik.load(name, urdf=path)
    assert (arm.name, arm.base, arm.tip) == (name, card.base, card.tip)
    assert arm.limb.kind == KINDS.get(name, "exact")
    forward = Forward(path, card.base, card.tip, arm.joint_names)
    rng = np.random.default_rng(20)
    for _ in range(200):
        pose = forward(random_angles(rng, arm.lower, arm.upper))
        solution = arm.solve(pose)
        assert solution, solution.message
        assert (arm.lower <= solution.q).all()
        assert (solution.q <= arm.upper).all()
        np.testing.assert_allclose(forward(solution.q), pose, rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", srs_ik.robots())
def test_the_hand_reaches_away_from_the_wrist(name):
    arm = srs_ik.load(name, urdf=file_of(name))
    if arm.limb.hand > 1e-3:
        out = arm.limb.T_base_tip_zero[:3, 3] - arm.limb.wrist
        cosine = arm.limb.T_base_tip_zero[:3, :3] @ arm.hand.grasp @ out / arm.limb.hand
        assert cosine > 0.99
    side = zoo.card(name).side
    assert side == next((side for side in ("left", "right") if name.endswith(side)), side)


@pytest.mark.parametrize("name", zoo.adapters())
def test_an_adapter_says_where_its_description_is_from(name):
    card = zoo.card(name)
    assert name in ELSEWHERE
    assert card.description
    source = card.sources["description"]
    assert source.url.startswith("https://github.com/")
    (entry,) = [entry for entry in catalogue() if entry.name == name]
    assert entry.origin == source.url
    if entry.install:
        assert entry.install.startswith("pip install ") or "ROS_PACKAGE_PATH" in entry.install
    folder = next(path for path in zoo._folder().iterdir() if path.name == name)
    assert [path.name for path in folder.iterdir()] == ["robot.toml"]


def test_a_description_that_is_not_here_is_told_with_where_it_comes_from(monkeypatch):
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    with pytest.raises(
        InvalidRobot, match=r"lbr_description.*ROS_PACKAGE_PATH; 'med7' comes from https://github.com/.*urdf="
    ):
        srs_ik.load("med7")


def test_a_clone_that_lacks_the_file_is_named_with_what_to_do(monkeypatch, tmp_path):
    (tmp_path / "lbr_description").mkdir()
    (tmp_path / "lbr_description" / "package.xml").write_text("<package><name>lbr_description</name></package>")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    with pytest.raises(InvalidRobot, match=r"lbr_description has no file 'urdf/med7/med7.xacro': .*ROS_PACKAGE_PATH"):
        srs_ik.load("med7")


def test_names_of_robot_descriptions_exist_there():
    pytest.importorskip("robot_descriptions")
    from importlib.util import find_spec

    for name in zoo.adapters():
        for place in zoo.card(name).places:
            scheme, _, module = place.partition("://")
            if scheme == "robot_descriptions":
                assert find_spec(f"robot_descriptions.{module}"), place
