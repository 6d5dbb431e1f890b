"""`srs-ik intervals`: the table, the JSON and the picture show what `Arm.intervals` finds."""

import json
import math
import sys

import numpy as np
import pytest
from typer.testing import CliRunner

import srs_ik
from srs_ik.cli.app import app
from srs_ik.errors import install_command
from srs_ik.plots.intervals import bars
from srs_ik.solve.intervals import Interval

POSE = ["--xyz", "0.5", "0.1", "0.6", "--rpy", "0", "1.5707963", "0"]
# Within reach, but joint 6 would have to pass its limit: the hand points back at the arm.
BLOCKED = ["--xyz", "0.5", "0.1", "0.6", "--rpy", "0", "3.14159265", "0"]


def run(*words: str):
    return CliRunner().invoke(app, ["intervals", *words])


def test_json_holds_the_intervals_of_the_arm():
    result = run("iiwa14", *POSE, "--json")
    assert result.exit_code == 0, result.stderr
    answer = json.loads(result.stdout)
    expected = srs_ik.load("iiwa14").intervals(np.array(answer["T_base_tip"]))
    assert len(expected) > 8
    assert [Interval(**interval) for interval in answer["intervals"]] == expected


def test_the_table_shows_the_intervals_of_the_json():
    expected = json.loads(run("gen3", "--q", *"1234567", "--no-limits", "--json").stdout)["intervals"]
    text = run("gen3", "--q", *"1234567", "--no-limits").stdout
    rows = [line.split() for line in text.splitlines() if line.strip()[:1].isdigit() and len(line.split()) == 6]
    assert len(rows) == len(expected)
    for row, interval in zip(rows, expected, strict=True):
        assert int(row[0]) == interval["branch"]
        assert float(row[4]) == pytest.approx(interval["lower"], abs=1e-9)
        assert float(row[2]) == pytest.approx(math.degrees(interval["upper"]), abs=1e-4)
    assert f"{len(expected)} intervals in 8 branches" in text


def test_every_interval_holds_arm_angles_that_solve():
    answer = json.loads(run("iiwa14", *POSE, "--json").stdout)
    arm, pose = srs_ik.load("iiwa14"), np.array(answer["T_base_tip"])
    for interval in answer["intervals"]:
        middle = 0.5 * (interval["lower"] + interval["upper"])
        assert arm.solve(pose, arm_angle=middle, branch=interval["branch"])


@pytest.mark.slow
def test_no_interval_is_exit_status_1_with_one_line(tmp_path):
    picture = tmp_path / "none.png"
    result = run("iiwa14", *BLOCKED, "--plot", str(picture))
    assert result.exit_code == 1
    assert result.stdout == ""
    assert result.stderr.count("\n") == 1
    assert "no posture inside the joint limits" in result.stderr
    assert not picture.exists()
    assert run("iiwa14", *BLOCKED, "--no-limits").exit_code == 0
    answer = run("iiwa14", *BLOCKED, "--json")
    assert answer.exit_code == 1
    assert json.loads(answer.stdout)["intervals"] == []


def test_degrees_are_read():
    one = run("iiwa14", *POSE[:5], "0", "90", "0", "--degrees", "--json")
    other = run("iiwa14", *POSE[:5], "0", str(math.pi / 2), "0", "--json")
    assert json.loads(one.stdout) == json.loads(other.stdout)


def test_the_picture_is_written_and_shows_something(tmp_path):
    image = pytest.importorskip("matplotlib.image")
    path = tmp_path / "bars.png"
    assert run("iiwa14", *POSE, "--plot", str(path)).exit_code == 0
    pixels = image.imread(path)[..., :3]
    blue = (pixels[..., 2] - pixels[..., 0] > 0.3).mean()
    feasible = sum(interval.width for interval in srs_ik.load("iiwa14").intervals(pose_of(POSE))) / (16.0 * math.pi)
    # Axes and gaps between the bars take a part of the picture; the bars fill the rest to the feasible share.
    assert 0.5 * feasible < blue < feasible


def pose_of(words: list[str]) -> np.ndarray:
    return np.array(json.loads(run("iiwa14", *words, "--json").stdout)["T_base_tip"])


def test_bars_that_pass_half_a_turn_are_cut():
    pieces = bars([Interval(2, 3.0, 3.5), Interval(5, -math.pi, math.pi), Interval(2, -1.0, 1.0)])
    assert [len(p) for p in pieces] == [0, 0, 3, 0, 0, 1, 0, 0]
    (start, width), (second, rest), _ = pieces[2]
    assert start == pytest.approx(math.degrees(3.0))
    assert start + width == pytest.approx(180.0)
    assert second == -180.0
    assert width + rest == pytest.approx(math.degrees(0.5))
    assert pieces[5] == [(-180.0, 360.0)]


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["iiwa14"], "--xyz"),
        (["iiwa14", *POSE, "--q", *"1234567"], "--q"),
        (["iiwa14", "--q", "1", "2"], "--q takes 7 numbers, not 2"),
        (["iiwa41", *POSE], "iiwa41"),
        (["iiwa14", *POSE, "--tip", "nose"], "nose"),
        (["iiwa14", *POSE, "--plot", "bars.colour"], "bars.colour"),
        (["iiwa14", *POSE, "--plot", "no/such/folder/bars.png"], "no/such/folder"),
    ],
)
def test_wrong_input_is_one_line_and_exit_status_2(words, named):
    if "--plot" in words:
        pytest.importorskip("matplotlib")
    result = run(*words)
    assert result.exit_code == 2, result.exception
    assert result.stdout == ""
    assert result.stderr.count("\n") == 1
    assert named in result.stderr


def test_without_matplotlib_the_pip_command_is_given(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "matplotlib.backend_bases", None)
    result = run("iiwa14", *POSE, "--plot", str(tmp_path / "bars.png"))
    assert result.exit_code == 2
    assert result.stdout == ""
    assert result.stderr == f"srs-ik: --plot needs an optional part of srs_ik: {install_command('plot')}\n"
