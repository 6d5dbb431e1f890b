"""The experiments on torque control in their short form, planners, and the command."""

import json
import re

import arms
import numpy as np
import pytest
from command_line import run

from srs_ik.control.planners import between, harmonic, minimum_jerk, passive_motion
from srs_ik.errors import install_command

pytest.importorskip("mujoco", "3.14")

from srs_ik.paper.experiments import files
from srs_ik.paper.experiments.control import CONTROL
from srs_ik.paper.experiments.control.setting import sparc, speed_peaks, straightness


@pytest.fixture(scope="module")
def outcomes():
    """Each experiment once, and the shares of which it told."""
    found = {}

    def get(name):
        if name not in found:
            shares = []
            found[name] = CONTROL[name](arms.load("iiwa14"), shares.append, short=True), shares
        return found[name]

    return get


@pytest.mark.parametrize("name", CONTROL)
def test_every_experiment_runs_tells_its_progress_and_leaves_its_files(outcomes, name, tmp_path):
    pytest.importorskip("matplotlib")
    outcome, shares = outcomes(name)
    assert shares == sorted(shares)
    assert shares[-1] == pytest.approx(1.0)
    written = files.write(tmp_path, name, arms.load("iiwa14"), outcome)
    assert sorted(path.name for path in written) == sorted(f"{name}.{e}" for e in ("png", "svg", "json"))
    answer = json.loads((tmp_path / f"{name}.json").read_text())
    assert answer["figures"]
    assert "NaN" not in (tmp_path / f"{name}.json").read_text()


@pytest.mark.parametrize("name", CONTROL)
def test_axes_have_units(outcomes, name):
    pytest.importorskip("matplotlib")
    figure = outcomes(name)[0].draw()
    labels = [axes.get_xlabel() for axes in figure.axes] + [axes.get_ylabel() for axes in figure.axes]
    written = [label for label in labels if label]
    assert written
    assert all(re.search(r"\(.*(m|s|rad|deg|1|N|Hz|kg|%).*\)", label) for label in written), written


def test_the_plant_is_the_arm_in_every_robot(outcomes):
    for name, found in outcomes("control-model")[0].figures.items():
        assert found["M"] < 1e-9, name
        assert found["h"] < 1e-9, name


def test_the_law_on_one_axis_is_what_the_equations_say(outcomes):
    figures = outcomes("control-law")[0].figures
    assert figures["free_response_error_m"] < 1e-9
    assert figures["peak_over_mean_speed"] == pytest.approx(np.pi / 2.0, rel=1e-4)
    rule = figures["rule"]
    assert rule["at_rest_within"] == rule["cases_within"] > 0
    assert rule["largest_way_m"] < 2.0


def test_nothing_is_injected_where_the_law_is_passive(outcomes):
    shares = outcomes("control-passivity")[0].figures["injected_share_of_U0"]
    assert shares["tanh, law A, 4 kHz"]["worst"] < 0.01
    assert shares["published, law A, 4 kHz"]["worst"] > 0.05


# Planners and measures


def test_minimum_jerk_and_harmonic_are_their_closed_forms():
    s = np.linspace(0.0, 1.0, 100_001)
    for way, peak in ((minimum_jerk(s), 1.875), (harmonic(s), np.pi / 2.0)):
        speed = np.gradient(way, s)
        assert way[[0, -1]] == pytest.approx([0.0, 1.0], abs=1e-12)
        assert speed.max() / speed.mean() == pytest.approx(peak, rel=1e-3)
    acceleration = np.gradient(np.gradient(minimum_jerk(s), s), s)
    assert abs(acceleration[5]) < 0.1


def test_poses_between_two_poses():
    arm = arms.load("iiwa14")
    A, B = (arm.forward_kinematics(q).homogeneous for q in arms.configurations("iiwa14", 2, 8))
    poses = between(A, B, [0.0, 0.5, 1.0])
    assert poses[0] == pytest.approx(A, abs=1e-12)
    assert poses[2] == pytest.approx(B, abs=1e-12)
    assert poses[1, :3, 3] == pytest.approx(0.5 * (A + B)[:3, 3])
    half = A[:3, :3].T @ poses[1, :3, :3]
    assert half @ half == pytest.approx(A[:3, :3].T @ B[:3, :3], abs=1e-12)


def test_passive_motion_brings_the_tip_to_its_target_without_inverse_kinematics():
    arm = arms.load("iiwa14")
    start = np.array([0.0, 0.6, 0.0, -1.4, 0.0, 0.8, 0.0])
    end = start + 0.2
    T = arm.forward_kinematics(end)
    path = passive_motion(arm, start, T, 400)
    error = arm.verify(T, path[-1])
    before = arm.verify(T, start)
    assert path[0] == pytest.approx(start)
    assert error.position < 0.05 * before.position
    assert np.abs(np.diff(path, axis=0)).max() < 0.05


def test_measures_of_a_movement():
    t = np.linspace(0.0, 1.0, 1001)
    one, two = np.sin(np.pi * t) ** 2, np.sin(2.0 * np.pi * t) ** 2
    assert speed_peaks(one, 1e-3) == 1
    assert speed_peaks(two, 1e-3) == 2
    assert -1.7 < sparc(one, 1e-3) < -1.3
    assert sparc(two, 1e-3) < sparc(one, 1e-3) - 0.3
    path = np.stack([t, 0.1 * np.sin(np.pi * t), 0.0 * t], axis=1)
    assert straightness(path, path[0], path[-1]) == pytest.approx(0.1)


# The command


def test_the_command_runs_the_experiments_on_its_own_arm(tmp_path, monkeypatch):
    pytest.importorskip("matplotlib")
    monkeypatch.setattr("srs_ik.paper.experiments.control.CONTROL", {"control-law": CONTROL["control-law"]})
    found = run("reproduce", "control", "--short", "--out", str(tmp_path))
    assert found.exit_code == 0, found.stderr
    assert found.stdout.split() == [str(tmp_path / f"control-law.{e}") for e in ("png", "svg", "json")]
    assert json.loads((tmp_path / "control-law.json").read_text())["robot"] == "iiwa14"


def test_the_command_refuses_what_it_cannot_do(tmp_path, monkeypatch):
    pytest.importorskip("matplotlib")
    short = run("reproduce", "walking", "--short", "--out", str(tmp_path))
    assert (short.exit_code, short.stderr.count("\n")) == (2, 1)
    assert "--short" in short.stderr
    bare = run("reproduce", "control", "--short", "--out", str(tmp_path), "--robot", str(arms.file_of("made_near")))
    assert (bare.exit_code, bare.stderr.count("\n")) == (2, 1)
    assert "no inertias" in bare.stderr
    monkeypatch.setitem(__import__("sys").modules, "mujoco", None)
    missing = run("reproduce", "control", "--out", str(tmp_path / "new"))
    assert missing.exit_code == 2
    assert install_command("sim") in missing.stderr
    assert not (tmp_path / "new").exists()
