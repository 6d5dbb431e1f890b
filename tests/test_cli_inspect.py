"""`srs-ik robots` and `srs-ik inspect`: what is known of a robot without solving anything."""

import json
import re

import arms
import numpy as np
import pytest
from command_line import answer, run
from rich.console import Console
from robot_files import at_hand, joint_xml, robot_file, serial_arm

import srs_ik
from srs_ik.errors import install_command
from srs_ik.robot import places, zoo

TWINS = at_hand("made_twins", "openarm_v10_bimanual")


def test_robots_lists_every_name_that_load_knows():
    listed = json.loads(run("robots", "--json").stdout)
    assert [robot["name"] for robot in listed] == srs_ik.robots()
    text = run("robots").stdout
    assert all(robot["name"] in text and robot["tip"] in text for robot in listed)


@pytest.mark.parametrize("columns", [60, 80, 100, 140])
def test_robots_breaks_no_name_where_the_terminal_is_narrow(columns, monkeypatch):
    def narrow(**options):
        return Console(width=columns, markup=False, emoji=False, highlight=False)

    monkeypatch.setattr("srs_ik.cli.render.console", narrow)
    words = run("robots").stdout.split()
    for robot in json.loads(run("robots", "--json").stdout):
        assert {robot["name"], robot["base"], robot["tip"]} <= set(words)
    assert ("description" in words) == (columns >= 100)


def test_robots_gives_the_command_for_what_is_not_installed(monkeypatch):
    monkeypatch.setattr(places, "_data_files", lambda file: iter(()))
    listed = {robot["name"]: robot for robot in json.loads(run("robots", "--json").stdout)}
    assert listed["iiwa14"]["installed"]
    assert listed["iiwa14"]["install"] is None
    assert not listed["human_left"]["installed"]
    assert listed["human_left"]["install"] == install_command("robots")
    text = " ".join(run("robots").stdout.split())
    # More names where robot_descriptions is not installed either.
    names = re.search(rf"For ([\w, ]+): {re.escape(install_command('robots'))}", text)[1].split(", ")
    assert {"human_left", "human_right", "icub_left", "icub_right", "romeo_left", "romeo_right"} <= set(names)


def test_inspect_gives_the_published_lengths_of_the_iiwa():
    (limb,) = answer("inspect", "iiwa14")["limbs"]
    assert limb["kind"] == "exact"
    assert limb["wrist_kind"] == "XYX"
    assert [limb["upper_arm"], limb["forearm"], limb["hand"]] == pytest.approx([0.42, 0.4, 0.126], abs=1e-12)
    assert limb["elbow_offset"] == pytest.approx(0.0, abs=1e-12)
    assert np.rad2deg(limb["upper"]) == pytest.approx([170, 120, 170, 120, 170, 120, 175], abs=0.01)


def test_inspect_prints_tables_with_millimetres_and_limits_in_both_units():
    text = run("inspect", "iiwa14").stdout
    for expected in ("exact", "420.000", "400.000", "126.000", "(deg)", "(rad)", "iiwa_joint_7", "XYX"):
        assert expected in text


def test_inspect_leaves_out_the_limits_of_continuous_joints():
    (limb,) = answer("inspect", "gen3")["limbs"]
    assert [x is None for x in limb["upper"]] == [True, False] * 3 + [True]
    assert limb["kind"] == "near"
    assert max(limb["misses_mm"]) == pytest.approx(0.5 * 11.7508, abs=1e-3)


def test_inspect_of_a_chosen_arm_says_what_is_locked_on_the_way_to_it(tmp_path):
    trunk = joint_xml("waist", "floor", "l0")
    path = tmp_path / "on_a_waist.urdf"
    path.write_text(f'<robot name="on_a_waist"><link name="floor"/>{serial_arm()}{trunk}</robot>')
    for options in ((), ("--limb", "l7"), ("--tip", "l7")):
        (limb,) = answer("inspect", str(path), *options)["limbs"]
        assert limb["locked"] == ["waist"]


def test_inspect_lists_what_is_locked_behind_the_arm_and_what_else_may_be_the_tip(tmp_path):
    drill = '<link name="bit"/><link name="camera"/>' + joint_xml("spin", "l7", "bit")
    drill += joint_xml("mount", "l7", "camera", "fixed", '<origin xyz="0 0 0.1"/>')
    path = tmp_path / "drill.urdf"
    path.write_text(f'<robot name="drill">{serial_arm()}{drill}</robot>')
    for options, locked, frames in (((), [], ["camera"]), (("--tip", "bit"), ["spin"], ["l7", "camera"])):
        (limb,) = answer("inspect", str(path), *options)["limbs"]
        assert (limb["locked"], limb["frames"]) == (locked, frames)
    assert "for --tip: camera" in run("inspect", str(path)).stdout
    assert srs_ik.load(path, tip="bit", locked={"spin": 0.1}).still_joints == ("spin",)


def test_inspect_says_where_a_chain_forks_and_which_is_the_longest(tmp_path):
    path = tmp_path / "six.urdf"
    hinge = '<origin xyz="0.03 0.04 0.1"/><axis xyz="1 0 0"/><limit lower="0" upper="1" effort="1" velocity="1"/>'
    six = serial_arm("z y z y z y", "0 0 .3 0 .3 0")
    fingers = "".join(f'<link name="f{k}"/>' + joint_xml(f"f{k}_joint", "l6", f"f{k}", inside=hinge) for k in (1, 2))
    path.write_text(f'<robot name="six">{six}{fingers}</robot>')
    result = run("inspect", str(path))
    assert result.exit_code == 1
    said = " ".join(result.stdout.split())
    assert "it forks after axis 6 (j6), on which 2 joints hang: a hand may begin there" in said
    path.write_text(f'<robot name="six">{six}</robot>')
    result = run("inspect", str(path))
    assert result.exit_code == 1
    assert "no chain of 7 consecutive revolute joints; the longest has 6: j1" in result.stderr


def test_inspect_asks_whether_limits_are_degrees(tmp_path):
    path = tmp_path / "degrees.urdf"
    limits = serial_arm().replace('lower="-2" upper="2"', 'lower="-120" upper="120"')
    path.write_text(f'<robot name="arm">{limits}</robot>')
    for words in ([], ["--base", "l0"]):
        said = " ".join(run("inspect", str(path), *words).stdout.split())
        assert "240 rad apart, more than 16 turns: they look like degrees" in said
        assert "they look like degrees" in answer("inspect", str(path), *words)["limbs"][0]["note"]


def test_inspect_with_a_tip_looks_at_that_chain_alone():
    card = zoo.card("iiwa14")
    (limb,) = answer("inspect", str(card.urdf), "--base", card.base, "--tip", card.tip)["limbs"]
    assert (limb["base"], limb["tip"]) == (card.base, card.tip)


@pytest.mark.parametrize("name", at_hand("made_fr3", "made_xarm7", "made_sawyer", "franka_fr3", "xarm7", "sawyer"))
def test_inspect_tells_by_how_many_millimetres_a_refused_arm_misses(name):
    report = answer("inspect", str(robot_file(name)), exit_code=1)
    assert {limb["kind"] for limb in report["limbs"]} == {"refused"}
    assert all(max(miss for miss in limb["misses_mm"] if miss is not None) > 10.0 for limb in report["limbs"])
    result = run("inspect", str(robot_file(name)))
    assert result.exit_code == 1
    assert "refused" in result.stdout
    assert "(mm)" in result.stdout
    rows = [line.split() for line in result.stdout.splitlines() if line.lstrip()[:1] in list("1234567")]
    assert [row[0] for row in rows] == list("1234567")
    assert [row[2] for row in rows] == ["shoulder"] * 3 + ["-"] + ["wrist"] * 3
    (limb,) = report["limbs"]
    assert [float(row[3]) for row in rows] == pytest.approx([miss or 0.0 for miss in limb["misses_mm"]], abs=6e-4)
    assert f"Up to {limb['allowed_mm']:.1f} mm would be accepted" in result.stdout


@pytest.mark.parametrize("name", TWINS)
def test_inspect_shows_both_arms_of_a_file(name):
    limbs = answer("inspect", str(robot_file(name)))["limbs"]
    accepted = [limb["tip"] for limb in limbs if limb["kind"] != "refused"]
    assert len(accepted) == len(set(accepted)) == 2


@pytest.mark.parametrize("name", TWINS)
def test_inspect_of_an_arm_that_no_word_means_is_wrong_input(name):
    result = run("inspect", str(robot_file(name)), "--limb", "middle")
    assert (result.exit_code, result.stdout) == (2, "")
    assert "has 'middle' in its names; the arms end at " in result.stderr
    assert result.stderr.count("\n") == 1


def test_inspect_says_that_a_file_has_no_chain_of_seven(tmp_path):
    path = tmp_path / "lamp.urdf"
    path.write_text('<robot name="lamp"><link name="foot"/></robot>')
    result = run("inspect", str(path))
    assert result.exit_code == 1
    assert result.stderr.count("\n") == 1
    assert "7" in result.stderr


@pytest.mark.parametrize("name", TWINS)
def test_inspect_of_an_adapter_shows_its_arm_and_no_other(name, tmp_path):
    path, adapter = robot_file(name), tmp_path / "robot.toml"
    assert run("inspect", str(path), "--limb", "right", "--write", str(adapter)).exit_code == 0
    (limb,) = answer("inspect", str(adapter))["limbs"]
    places = {"made_twins": "made_right", "openarm_v10_bimanual": "openarm_right"}
    assert (limb["base"], limb["tip"]) == arms.PLACES[places[name]][1:]
