"""Cards: what is read from a robot.toml, and what is said about a damaged one."""

import dataclasses
import os
from pathlib import Path

import numpy as np
import pytest

from srs_ik.errors import InvalidRobot
from srs_ik.robot import zoo
from srs_ik.robot.card import CARD_FILE, Placement, RobotCard, Source, read_card

CARD = """
name = "toy"
description = "A toy arm"
urdf = "toy.urdf"
side = "left"

[frames]
base = "base"
tip = "tip"

[arm_angle]
reference = [0, 0.6, -0.8]

[hand]
grasp = [1.0, 0.0, 0.0]
pronosupination = [0, 0, 1]

[sources.lengths]
figures = "all lengths"
title = "A book"
year = 1999
url = "https://example.org"
page = "page 7"
note = "rounded"
"""


@pytest.fixture
def toy(tmp_path: Path):
    """Writes a card, changed by one replacement, and returns its path."""
    folder = tmp_path / "toy"
    folder.mkdir()
    (folder / "toy.urdf").write_text("<robot/>")

    def write(old: str = "", new: str = "") -> Path:
        assert old in CARD
        path = folder / CARD_FILE
        path.write_text(CARD.replace(old, new, 1), encoding="utf-8")
        return path

    return write


def test_a_card_is_read_as_it_is_written(toy):
    path = toy()
    assert read_card(path) == RobotCard(
        name="toy",
        description="A toy arm",
        places=(str(path.parent / "toy.urdf"),),
        base="base",
        tip="tip",
        side="left",
        reference=(0.0, 0.6, -0.8),
        grasp=(1.0, 0.0, 0.0),
        pronosupination=(0.0, 0.0, 1.0),
        sources={"lengths": Source("all lengths", "A book", 1999, "https://example.org", "page 7", "rounded")},
    )


def test_name_description_and_frames_are_enough(tmp_path):
    path = tmp_path / CARD_FILE
    path.write_text('name = "my arm"\nurdf = ["../a.urdf", "package://p/b.urdf"]\n[frames]\nbase = "b"\ntip = "t"\n')
    card = read_card(path)
    places = (str(tmp_path / "../a.urdf"), "package://p/b.urdf")
    assert card == RobotCard(name="my arm", places=places, base="b", tip="t")
    assert (card.side, card.reference, card.grasp, card.limits, card.tool) == ("either", None, None, {}, None)


def test_limits_tool_mount_and_xacro_arguments(toy):
    more = """
[limits]
j1 = { lower = -1, upper = inf }
[tool]
xyz = [0, 0, 0.1]
[mount]
rpy = [0, 1.5, 0]
name = "table"
[xacro]
dof = "7"
[hand]"""
    card = read_card(toy("[hand]", more))
    assert card.limits == {"j1": {"lower": -1, "upper": np.inf}}
    assert card.tool == Placement((0.0, 0.0, 0.1), (0.0, 0.0, 0.0))
    assert card.mount == Placement((0.0, 0.0, 0.0), (0.0, 1.5, 0.0), "table")
    assert card.xacro == {"dof": "7"}


def test_a_relative_path_works(toy, monkeypatch: pytest.MonkeyPatch):
    path = toy()
    monkeypatch.chdir(path.parent)
    assert read_card(CARD_FILE) == read_card(path)


def test_a_source_needs_only_figures_and_title(toy):
    path = toy('year = 1999\nurl = "https://example.org"\npage = "page 7"\nnote = "rounded"\n', "")
    assert read_card(path).sources["lengths"] == Source("all lengths", "A book")


def test_a_card_cannot_be_changed():
    card = zoo.card("iiwa14")
    with pytest.raises(dataclasses.FrozenInstanceError):
        card.tip = "other"  # type: ignore[misc]
    with pytest.raises(TypeError):
        card.sources["lengths"] = Source("a", "b")  # type: ignore[index]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('side = "left"', 'side = "left"\nsidde = 1', ["unknown key 'sidde'", "did you mean 'side'", "known are"]),
        ('tip = "tip"', 'tip = "tip"\ntop = "x"', ["unknown key 'top' in [frames]", "did you mean 'tip'"]),
        ('page = "page 7"', "pages = 7", ["unknown key 'pages' in [sources.lengths]"]),
        ('name = "toy"', "", ["the key 'name' is missing"]),
        ('base = "base"', "", ["the key 'base' in [frames] is missing"]),
        ('title = "A book"', "", ["the key 'title' in [sources.lengths] is missing"]),
        ('description = "A toy arm"', "description = 3", ["'description' must be a text", "not 3"]),
        ('description = "A toy arm"', 'description = " "', ["'description' must be a text that is not empty"]),
        ('side = "left"', 'side = "middle"', ["'side' must be one of left, right, either, not 'middle'"]),
        ("[0, 0.6, -0.8]", "[0, 0.6]", ["'reference' in [arm_angle] must be three numbers, not [0, 0.6]"]),
        ("[0, 0.6, -0.8]", "[0, 0.6, -0.9]", ["'reference' in [arm_angle] must be a unit vector"]),
        ("[0, 0.6, -0.8]", "[nan, 0.6, -0.8]", ["'reference' in [arm_angle] must be a number, not nan"]),
        ("[0, 0.6, -0.8]", "[inf, 0.6, -0.8]", ["'reference' in [arm_angle] must be finite"]),
        ('urdf = "toy.urdf"', "urdf = []", ["'urdf' must be a path or an address, or a list of them, not []"]),
        ('urdf = "toy.urdf"', "urdf = 3", ["'urdf' must be a path or an address, or a list of them, not 3"]),
        ("[hand]", "[limits.j]\nlow = 1\n[hand]", ["unknown key 'low' in [limits.j]", "did you mean 'lower'"]),
        ("[hand]", "[limits.j]\nlower = 'a'\n[hand]", ["'lower' in [limits.j] must be a number, not 'a'"]),
        ("[hand]", "[limits]\nj = 3\n[hand]", ["'limits.j' must be a table, not 3"]),
        ("[hand]", "[xacro]\ndof = 7\n[hand]", ["'dof' in [xacro] must be a text that is not empty, not 7"]),
        ("[hand]", "[tool]\nxyz = [0, 0]\n[hand]", ["'xyz' in [tool] must be three numbers, not [0, 0]"]),
        ("[hand]", "[mount]\nquat = [0, 0]\n[hand]", ["unknown key 'quat' in [mount]"]),
        ("[hand]", "[mount]\ngravity = 9.81\n[hand]", ["'gravity' in [mount] must be three numbers, not 9.81"]),
        ("[hand]", "[mount]\ngravity = [0, 0, 1e7]\n[hand]", ["'gravity' in [mount] is in m/s^2"]),
        ("[hand]", "[tool]\ngravity = [0, 0, 1]\n[hand]", ["unknown key 'gravity' in [tool]"]),
        (CARD, "sources = 1" + CARD.split("[sources")[0], ["'sources' must be a table, not 1"]),
        ("[0, 0.6, -0.8]", '"up"', ["'reference' in [arm_angle] must be three numbers, not 'up'"]),
        ("grasp = [1.0, 0.0, 0.0]", "grasp = [true, 0, 0]", ["'grasp' in [hand] must be three numbers"]),
        ("grasp = [1.0, 0.0, 0.0]", "grasp = [0, 0, 1]", ["'grasp' and 'pronosupination' in [hand]", "perpendicular"]),
        ("year = 1999", 'year = "1999"', ["'year' in [sources.lengths] must be a whole number, not '1999'"]),
        ("year = 1999", "year = true", ["'year' in [sources.lengths] must be a whole number, not True"]),
        ('side = "left"', 'side = "left', ["is not valid TOML"]),
        (CARD, "hand = 1" + CARD.split("[hand]")[0] + "[sources.a]\n", ["'hand' must be a table, not 1"]),
    ],
)
def test_a_damaged_card_is_refused_in_one_sentence(toy, old: str, new: str, words: list[str]):
    path = toy(old, new)
    with pytest.raises(InvalidRobot) as caught:
        read_card(path)
    message = str(caught.value)
    assert message.startswith(str(path))
    assert "\n" not in message
    assert caught.value.source == str(path)
    for word in words:
        assert word in message


def test_a_missing_card(tmp_path: Path):
    with pytest.raises(InvalidRobot, match=r"cannot read .*robot\.toml: No such file or directory"):
        read_card(tmp_path / "robot.toml")


def test_a_card_that_is_no_text(toy):
    path = toy()
    path.write_bytes(b"name = \xff")
    with pytest.raises(InvalidRobot, match="is not valid TOML"):
        read_card(path)


def test_files_that_are_no_cards(tmp_path: Path):
    path = tmp_path / CARD_FILE
    wrong = {"larger than 64 KiB": "#" * (2**16 + 1), "is not valid TOML": "a = " + "[" * 60_000}
    for says, text in wrong.items():
        path.write_text(text)
        with pytest.raises(InvalidRobot, match=says) as raised:
            read_card(path)
        assert len(str(raised.value).splitlines()) == 1
    path.unlink()
    os.mkfifo(path)
    with pytest.raises(InvalidRobot, match="is not a regular file"):
        read_card(path)
    for name in ("nul\0.toml", "x" * 5000 + ".toml", "."):
        with pytest.raises(InvalidRobot, match=r"cannot read|is not a regular file"):
            read_card(tmp_path / name)


def test_a_mark_of_the_encoding_is_no_part_of_a_card(toy):
    path = toy()
    card = read_card(path)
    path.write_text(path.read_text(encoding="utf-8"), encoding="utf-8-sig")
    assert read_card(path) == card


@pytest.mark.parametrize("place", ["tool", "mount"])
def test_degrees_of_a_place_are_noticed(toy, place):
    path = toy("[sources", f"[{place}]\nrpy = [0, -90, 0]\n[sources")
    said = rf"'rpy' in \[{place}\] is in radians, and -90 rad is more than a turn: are these degrees"
    with pytest.warns(UserWarning, match=said):
        read_card(path)
