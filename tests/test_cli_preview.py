"""`srs-ik preview`: a page until Ctrl+C, or a file; wrong input is one line."""

import signal
import socket
import subprocess
import sys
import urllib.request

import pytest
from command_line import POSE, Q, run

from srs_ik.robot import zoo

FAR = ["--xyz", "5", "0", "0", "--rpy", "0", "0", "0"]


def test_a_scene_is_saved(tmp_path):
    path = tmp_path / "scene.html"
    result = run("preview", "iiwa14", *POSE, "--ellipsoids", "--ghosts", "--self-motion", "--save", str(path))
    assert result.exit_code == 0, result.stderr
    assert result.stdout == f"{path}\n"
    assert path.read_text().startswith("<!DOCTYPE html>")
    assert path.stat().st_size > 1_000_000


def test_joint_angles_can_be_given_in_degrees(tmp_path):
    path = tmp_path / "scene.html"
    result = run("preview", "gen3", "--q", "0", "20", "0", "-80", "0", "10", "0", "--degrees", "--save", str(path))
    assert result.exit_code == 0, result.stderr
    assert path.exists()


def test_no_posture_is_exit_status_1_with_one_line(tmp_path):
    path = tmp_path / "scene.html"
    result = run("preview", "iiwa14", *FAR, "--save", str(path))
    assert result.exit_code == 1
    assert result.stderr.startswith("srs-ik: UNREACHABLE: ")
    assert result.stderr.count("\n") == 1
    assert not path.exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--q", *Q[:3]], "--q takes 7 numbers"),
        (["--q", *Q, *POSE], "--q is a posture already"),
        (["--xyz", "1", "2", "3"], "a position alone is no pose"),
        (["--save", "scene.png"], "scene.html"),
        (["--save", "/no/such/folder/scene.html"], "no folder"),
        (["--interactive", "--save", "scene.html"], "goes with none"),
        (["--interactive", "--ghosts"], "goes with none"),
        (["--port", "70000"], "--port"),
        (["--port", "many"], "--port"),
    ],
)
def test_wrong_input_is_exit_status_2_with_one_line(words, said):
    result = run("preview", "iiwa14", *words)
    assert result.exit_code == 2
    assert said in result.stderr
    assert result.stderr.count("\n") == 1


def test_a_port_in_use_is_exit_status_2_with_one_line():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        result = run("preview", "iiwa14", "--port", port)
    assert result.exit_code == 2
    assert f"port {port}" in result.stderr
    assert result.stderr.count("\n") == 1


def test_missing_meshes_are_said_on_standard_error(tmp_path):
    urdf = tmp_path / "arm.urdf"
    text = zoo.card("iiwa14").urdf.read_text()
    urdf.write_text(text.replace('<box size="0.1 0.13 0.085"/>', '<mesh filename="package://gone/base.stl"/>', 1))
    words = [str(urdf), "--base", "iiwa_link_0", "--tip", "iiwa_link_ee", "--save", str(tmp_path / "scene.html")]
    result = run("preview", *words)
    assert result.exit_code == 0, result.stderr
    assert "not drawn: iiwa_link_0: 'package://gone/base.stl' is not found; see --meshes" in result.stderr
    assert result.stderr.count("\n") == 1


@pytest.mark.parametrize("extra", [[], ["--interactive"]], ids=["meshcat", "interactive"])
def test_the_page_is_served_until_ctrl_c(extra):
    if extra:
        pytest.importorskip("viser")
    command = [sys.executable, "-c", "from srs_ik.cli import main; main()", "preview", "iiwa14", *POSE, *extra]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as program:
        line = program.stdout.readline()
        assert line.startswith("iiwa14: http://127.0.0.1:")
        assert line.endswith("(Ctrl+C ends it)\n")
        assert urllib.request.urlopen(line.split()[1], timeout=300).status == 200
        program.send_signal(signal.SIGINT)
        _, err = program.communicate(timeout=300)
    assert program.returncode == 0
    assert err == ""
