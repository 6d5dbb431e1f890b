"""Tables of the command line in pipes: "-" is standard input, and standard output alone; lines without figures."""

import csv
import io
import subprocess
import sys

import numpy as np
import pytest
from command_line import Q, run
from typer.testing import CliRunner

import srs_ik
from srs_ik.cli.app import app

POSES = "x,y,z,roll,pitch,yaw\n0.5,0.1,0.6,0,1.57,0\n0.5,0.11,0.6,0,1.57,0\n"
WRITERS = {
    "solve": (["solve", "iiwa14", "--file", "-"], 2),
    "fk": (["fk", "iiwa14", "--q", *Q], 1),
    "path": (["path", "iiwa14", "-"], 2),
    "follow": (["follow", "iiwa14", "-", "--dt", "0.1"], 2),
    "place": (["place", "iiwa14", "-", "--grid", "0", "0.1", "2", "0", "0", "1"], 2),
}


@pytest.fixture
def poses(tmp_path):
    path = tmp_path / "poses.csv"
    path.write_text(POSES)
    return path


@pytest.mark.parametrize("name", WRITERS)
def test_a_table_in_a_pipe_is_alone_there(name):
    words, count = WRITERS[name]
    found = CliRunner().invoke(app, [*words, "--out", "-"], input=POSES)
    assert found.exit_code == 0, found.stderr
    assert "\r" not in found.stdout
    header, *rows = csv.reader(io.StringIO(found.stdout))
    assert {len(row) for row in rows} == {len(header)}
    assert len(rows) == count


def test_what_one_command_writes_in_a_pipe_another_reads():
    made = run("fk", "iiwa14", "--q", *Q, "--out", "-").stdout
    joints = CliRunner().invoke(app, ["solve", "iiwa14", "--file", "-", "--seed", *Q, "--out", "-"], input=made).stdout
    (row,) = csv.DictReader(io.StringIO(joints))
    q = [float(row[name]) for name in srs_ik.load("iiwa14").joint_names]
    # Rounding of a pose that is written with all of its digits.
    np.testing.assert_allclose(q, [float(each) for each in Q], atol=1e-12)


def test_standard_output_by_its_name_loses_nothing_in_a_file(poses, tmp_path):
    """Opened anew, the file behind it was written over by the table for people."""
    out = tmp_path / "out.csv"
    words = ["solve", "iiwa14", "--file", str(poses), "--out", "/dev/stdout"]
    with out.open("w") as file:
        command = [sys.executable, "-c", "from srs_ik.cli import main; main()", *words]
        assert subprocess.run(command, stdout=file, timeout=300).returncode == 0
    header, *rows = csv.reader(out.open())
    assert header[0] == "iiwa_joint_1"
    assert [len(row) for row in rows] == [len(header)] * 2


def test_json_and_a_table_are_not_both_on_standard_output(poses):
    found = run("path", "iiwa14", str(poses), "--out", "-", "--json")
    assert (found.exit_code, found.stdout) == (2, "")
    assert found.stderr == "srs-ik: --json and --out - both write on standard output: give one of them\n"


@pytest.mark.parametrize("command", [["solve", "iiwa14", "--file"], ["path", "iiwa14"]])
def test_a_line_of_empty_cells_between_poses_is_refused_and_at_the_end_left_out(command, tmp_path):
    """What pandas writes of a row of NaN: answers would stand beside other poses."""
    path = tmp_path / "poses.csv"
    header, first, second = POSES.splitlines()
    path.write_text("\n".join([header, first, ",,,,,", second]) + "\n")
    found = run(*command, str(path))
    assert found.exit_code == 2
    assert found.stderr == f"srs-ik: {path}, line 3: all cells are empty; take the line out, or give its figures\n"
    path.write_text("\n".join([header, first, "", second, ",,,,,", ",,,,,"]) + "\n")
    assert run(*command, str(path)).exit_code == 0


def test_joint_angles_that_are_not_given_are_refused(tmp_path):
    path = tmp_path / "joints.csv"
    path.write_text("q1,q2,q3,q4,q5,q6,q7\n,,,,,,\n" + ",".join(Q) + "\n")
    found = run("fk", "iiwa14", "--file", str(path))
    assert found.exit_code == 2
    assert "line 2: all cells are empty" in found.stderr
