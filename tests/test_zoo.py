"""The cards of the built-in robots, and what is said about a damaged one."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from srs_ik import zoo
from srs_ik.errors import InvalidRobot

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
        path = folder / zoo.CARD_FILE
        path.write_text(CARD.replace(old, new, 1), encoding="utf-8")
        return path

    return write


def test_the_three_robots_are_there():
    assert zoo.robots() == ["gen3", "human_arm", "iiwa14"]


@pytest.mark.parametrize("name", zoo.robots())
def test_a_card_names_its_robot_and_its_file(name: str):
    card = zoo.card(name)
    assert card.name == name
    assert card.urdf.is_absolute()
    assert card.urdf.is_file()
    for direction in (card.reference, card.grasp, card.pronosupination):
        assert np.linalg.norm(direction) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("name", zoo.robots())
def test_lengths_limits_and_masses_have_their_source(name: str):
    card = zoo.card(name)
    groups = " ".join(card.sources)
    for group in ("lengths", "limits" if card.side == "either" else "ranges", "masses", "shapes"):
        assert group in groups
    for source in card.sources.values():
        assert source.figures
        assert source.title
        assert source.url.startswith("https://") or source.url == ""
    assert any(source.url for source in card.sources.values())


def test_conventions_of_the_arm_angle_and_of_the_hand():
    iiwa, gen3, human = (zoo.card(name) for name in ("iiwa14", "gen3", "human_arm"))
    assert iiwa.reference == gen3.reference == (0.0, 0.0, 1.0)
    assert human.reference == (0.0, 0.0, -1.0)
    assert (iiwa.side, gen3.side, human.side) == ("either", "either", "left")
    assert (human.grasp, human.pronosupination) == ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    assert (gen3.grasp, gen3.pronosupination) == ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0))


def test_a_card_is_read_as_it_is_written(toy):
    path = toy()
    assert zoo.read_card(path) == zoo.RobotCard(
        name="toy",
        description="A toy arm",
        urdf=path.parent / "toy.urdf",
        base="base",
        tip="tip",
        side="left",
        reference=(0.0, 0.6, -0.8),
        grasp=(1.0, 0.0, 0.0),
        pronosupination=(0.0, 0.0, 1.0),
        sources={"lengths": zoo.Source("all lengths", "A book", 1999, "https://example.org", "page 7", "rounded")},
    )


def test_a_relative_path_works(toy, monkeypatch: pytest.MonkeyPatch):
    path = toy()
    monkeypatch.chdir(path.parent)
    assert zoo.read_card(zoo.CARD_FILE) == zoo.read_card(path)


def test_a_source_needs_only_figures_and_title(toy):
    path = toy('year = 1999\nurl = "https://example.org"\npage = "page 7"\nnote = "rounded"\n', "")
    assert zoo.read_card(path).sources["lengths"] == zoo.Source("all lengths", "A book")


def test_a_card_cannot_be_changed():
    card = zoo.card("iiwa14")
    with pytest.raises(dataclasses.FrozenInstanceError):
        card.tip = "other"  # type: ignore[misc]
    with pytest.raises(TypeError):
        card.sources["lengths"] = zoo.Source("a", "b")  # type: ignore[index]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('side = "left"', 'side = "left"\nsidde = 1', ["unknown key 'sidde'", "did you mean 'side'", "known are"]),
        ('tip = "tip"', 'tip = "tip"\ntop = "x"', ["unknown key 'top' in [frames]", "did you mean 'tip'"]),
        ('page = "page 7"', "pages = 7", ["unknown key 'pages' in [sources.lengths]"]),
        ('name = "toy"', "", ["the key 'name' is missing"]),
        ('base = "base"', "", ["the key 'base' in [frames] is missing"]),
        ('title = "A book"', "", ["the key 'title' in [sources.lengths] is missing"]),
        ('name = "toy"', 'name = "boy"', ["'boy'", "that of its folder, 'toy'"]),
        ('description = "A toy arm"', "description = 3", ["'description' must be a text", "not 3"]),
        ('description = "A toy arm"', 'description = " "', ["'description' must be a text that is not empty"]),
        ('urdf = "toy.urdf"', 'urdf = "gone.urdf"', ["URDF file 'gone.urdf' is not there"]),
        ('urdf = "toy.urdf"', 'urdf = "../toy/toy.urdf"', ["'urdf' must be a plain file name"]),
        ('side = "left"', 'side = "middle"', ["'side' must be one of left, right, either, not 'middle'"]),
        ("[0, 0.6, -0.8]", "[0, 0.6]", ["'reference' in [arm_angle] must be three numbers, not [0, 0.6]"]),
        ("[0, 0.6, -0.8]", "[0, 0.6, -0.9]", ["'reference' in [arm_angle] must be a unit vector"]),
        ("[0, 0.6, -0.8]", "[nan, 0.6, -0.8]", ["'reference' in [arm_angle] must be a unit vector"]),
        ("[0, 0.6, -0.8]", '"up"', ["'reference' in [arm_angle] must be three numbers, not 'up'"]),
        ("grasp = [1.0, 0.0, 0.0]", "grasp = [true, 0, 0]", ["'grasp' in [hand] must be three numbers"]),
        ("grasp = [1.0, 0.0, 0.0]", "grasp = [0, 0, 1]", ["'grasp' and 'pronosupination' in [hand]", "perpendicular"]),
        ("year = 1999", 'year = "1999"', ["'year' in [sources.lengths] must be a whole number, not '1999'"]),
        ("year = 1999", "year = true", ["'year' in [sources.lengths] must be a whole number, not True"]),
        ("[hand]\ngrasp = [1.0, 0.0, 0.0]\npronosupination = [0, 0, 1]", "", ["the key 'hand' is missing"]),
        ('side = "left"', 'side = "left', ["is not valid TOML"]),
        (CARD, "hand = 1" + CARD.split("[hand]")[0] + "[sources.a]\n", ["'hand' must be a table, not 1"]),
        (CARD, "sources = {}" + CARD.split("[sources")[0], ["'sources' must be a table with at least one group"]),
    ],
)
def test_a_damaged_card_is_refused_in_one_sentence(toy, old: str, new: str, words: list[str]):
    path = toy(old, new)
    with pytest.raises(InvalidRobot) as caught:
        zoo.read_card(path)
    message = str(caught.value)
    assert message.startswith(str(path))
    assert "\n" not in message
    assert caught.value.source == str(path)
    for word in words:
        assert word in message


def test_a_missing_card(tmp_path: Path):
    with pytest.raises(InvalidRobot, match=r"cannot read .*robot\.toml: No such file or directory"):
        zoo.read_card(tmp_path / "robot.toml")


def test_a_card_that_is_no_text(toy):
    path = toy()
    path.write_bytes(b"name = \xff")
    with pytest.raises(InvalidRobot, match="is not valid TOML"):
        zoo.read_card(path)


@pytest.mark.parametrize("name", ["iwa14", "../robots/iiwa14", "", "IIWA14"])
def test_an_unknown_robot_is_told_the_known_ones(name: str):
    with pytest.raises(InvalidRobot) as caught:
        zoo.card(name)
    assert f"there is no built-in robot {name!r}" in str(caught.value)
    assert "there are gen3, human_arm, iiwa14" in str(caught.value)
    assert caught.value.source == name


def test_a_misspelt_robot_is_recognised():
    with pytest.raises(InvalidRobot, match=r"did you mean 'iiwa14'\?"):
        zoo.card("iwa14")


def test_an_installation_without_robots_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(zoo, "__file__", str(tmp_path / "srs_ik" / "zoo.py"))
    with pytest.raises(InvalidRobot, match="folder of built-in robots is missing"):
        zoo.robots()


def test_the_folder_inside_the_package_comes_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    for folder, name in ((tmp_path / "robots", "outer"), (tmp_path / "srs_ik" / "robots", "inner")):
        (folder / name).mkdir(parents=True)
        (folder / name / zoo.CARD_FILE).write_text("")
    monkeypatch.setattr(zoo, "__file__", str(tmp_path / "srs_ik" / "zoo.py"))
    assert zoo.robots() == ["inner"]
