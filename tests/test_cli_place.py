"""`srs-ik place` prints what `base_placement` answers; wrong input is one line."""

import csv

import numpy as np
import pytest
from command_line import answer, run

import srs_ik


@pytest.fixture
def poses(tmp_path):
    path = tmp_path / "poses.csv"
    rng = np.random.default_rng(27)
    rows = [[*rng.uniform(-0.3, 0.3, 2), 0.6, *rng.uniform(-1.0, 1.0, 3)] for _ in range(5)]
    with path.open("w", newline="") as file:
        csv.writer(file).writerows([["x", "y", "z", "roll", "pitch", "yaw"], *rows])
    return str(path), np.array([srs_ik.pose_from_xyz_rpy(r[:3], r[3:]).homogeneous for r in rows])


def test_the_best_of_a_grid_is_that_of_the_arm(poses, tmp_path):
    path, T_room_tip = poses
    out = tmp_path / "places.csv"
    words = (
        "place",
        "iiwa14",
        path,
        "--grid",
        "-0.6",
        "0.6",
        "4",
        "-0.6",
        "0.6",
        "3",
        "--height",
        "0.1",
        "--yaws",
        "2",
    )
    said = answer(*words, "--by", "width", "--top", "3", "--out", str(out))
    places = []
    for x in np.linspace(-0.6, 0.6, 4):
        for y in np.linspace(-0.6, 0.6, 3):
            places += [srs_ik.pose_from_xyz_rpy([x, y, 0.1], [0.0, 0.0, yaw]).homogeneous for yaw in (0.0, np.pi)]
    expected = srs_ik.base_placement(srs_ik.load("iiwa14"), T_room_tip, places, by="width")
    assert [each["candidate"] for each in said["best"]] == expected.order[:3].tolist()
    assert said["best"][0]["value"] == pytest.approx(expected.value.max(), rel=1e-9)
    assert said["candidates"] == 24
    assert len(out.read_text().splitlines()) == 25
    assert "reached (%)" in run(*words).stdout


def test_candidates_may_come_from_a_file(poses, tmp_path):
    path, _ = poses
    candidates = tmp_path / "candidates.csv"
    candidates.write_text("x,y,z,roll,pitch,yaw\n-0.5,0,0,0,0,0\n9,9,0,0,0,0\n")
    said = answer("place", "iiwa14", path, "--candidates", str(candidates))
    assert [each["candidate"] for each in said["best"]] == [0, 1]
    assert said["best"][1]["share"] == 0.0


def test_nowhere_is_exit_status_1(poses):
    found = run("place", "iiwa14", poses[0], "--grid", "8", "9", "2", "8", "9", "2")
    assert found.exit_code == 1
    assert "no candidate reaches any of the poses" in found.stderr


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ((), "give the places for the base"),
        (("--grid", "0", "1", "2", "0", "1", "1.5"), "whole numbers"),
        (("--candidates", "nowhere.csv"), "nowhere.csv"),
        (("--grid", "0", "1", "2", "0", "1"), "--grid takes 6 numbers"),
    ],
)
def test_wrong_input_is_one_line(poses, words, said):
    found = run("place", "iiwa14", poses[0], *words)
    assert found.exit_code == 2
    assert said in found.stderr
    assert len(found.stderr.splitlines()) == 1


def test_no_column_is_written_twice(poses, tmp_path):
    out = tmp_path / "places.csv"
    for by in ("share", "width"):
        said = run("place", "iiwa14", poses[0], "--grid", "0", "0.4", "2", "0", "0", "1", "--by", by, "--out", str(out))
        with out.open(newline="") as file:
            header = next(csv.reader(file))
        assert len(set(header)) == len(header)
        assert {"share", by, "x", "qw"} <= set(header)
        words = said.stdout.splitlines()[1].replace("reached (%)", "share").split()
        assert words == header
