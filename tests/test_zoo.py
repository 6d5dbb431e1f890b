"""The robots that have names."""

from pathlib import Path

import numpy as np
import pytest

from srs_ik.errors import InvalidRobot
from srs_ik.robot import zoo
from srs_ik.robot.card import CARD_FILE


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


@pytest.mark.parametrize("name", ["iwa14", "../robots/iiwa14", "", "IIWA14"])
def test_an_unknown_robot_is_told_the_known_ones(name: str):
    with pytest.raises(InvalidRobot) as caught:
        zoo.card(name)
    assert f"there is no robot of the name {name!r}" in str(caught.value)
    assert "there are gen3, " in str(caught.value)
    assert caught.value.source == name


def test_a_misspelt_robot_is_recognised():
    with pytest.raises(InvalidRobot, match=r"did you mean 'iiwa14'"):
        zoo.card("iwa14")


def test_an_installation_without_robots_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(zoo, "__file__", str(tmp_path / "srs_ik" / "robot" / "zoo.py"))
    with pytest.raises(InvalidRobot, match="folder of built-in robots is missing"):
        zoo.robots()


def test_the_folder_inside_the_package_comes_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    for folder, name in ((tmp_path / "robots", "outer"), (tmp_path / "srs_ik" / "robots", "inner")):
        (folder / name).mkdir(parents=True)
        (folder / name / CARD_FILE).write_text("")
    monkeypatch.setattr(zoo, "__file__", str(tmp_path / "srs_ik" / "robot" / "zoo.py"))
    assert zoo.adapters() == ["inner"]


def test_a_name_is_that_of_the_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    folder = tmp_path / "robots" / "toy"
    folder.mkdir(parents=True)
    (folder / CARD_FILE).write_text('name = "boy"\nurdf = "a.urdf"\n[frames]\nbase = "b"\ntip = "t"\n')
    monkeypatch.setattr(zoo, "__file__", str(tmp_path / "srs_ik" / "robot" / "zoo.py"))
    with pytest.raises(InvalidRobot, match="the name 'boy' must be that of its folder, 'toy'"):
        zoo.card("toy")
