"""`srs-ik ellipsoids` prints what the functions give, in the axes asked for."""

import sys

import numpy as np
import pytest
from command_line import Q, answer, run

import srs_ik
from srs_ik.errors import install_command

ANGLES = [float(q) for q in Q]


@pytest.mark.parametrize("part", ["linear", "angular", "full"])
@pytest.mark.parametrize("limits", [False, True])
@pytest.mark.parametrize("axes", ["base", "tip"])
def test_json_holds_the_ellipsoids(part, limits, axes):
    arm = srs_ik.load("iiwa14")
    words = ["--part", part, "--axes", axes, *(["--limits"] if limits else [])]
    found = answer("ellipsoids", "iiwa14", "--q", *Q, *words)
    J, R = arm.jacobian(ANGLES), np.eye(3)
    if axes == "tip":
        R = arm.forward_kinematics(ANGLES).rotation
    for kind, build, weight in (
        ("velocity", srs_ik.velocity_ellipsoid, arm.velocity_limit),
        ("force", srs_ik.force_ellipsoid, arm.effort_limit),
    ):
        expected = build(J, weight if limits else None, part)
        assert found[kind]["radii"] == pytest.approx(expected.radii)
        assert found[kind]["unit"] == expected.unit
        # Turned back into base axes, row by row.
        turned = np.array(found[kind]["axes"]).reshape(len(expected.radii), -1, 3) @ R.T
        assert np.allclose(turned.reshape(len(expected.radii), -1), expected.axes.T, rtol=0.0, atol=1e-12)
    assert found["manipulability"] == pytest.approx(srs_ik.manipulability(J, part))
    assert found["isotropy"] == pytest.approx(srs_ik.analysis.isotropy(J, part))
    assert found["limits"] is limits


def test_the_tables_show_the_figures_of_the_json():
    words = ["ellipsoids", "iiwa14", "--q", *Q, "--along", "0", "1", "2"]
    found, text = answer(*words), run(*words).stdout
    for kind in ("velocity", "force"):
        for radius, axis in zip(found[kind]["radii"], found[kind]["axes"], strict=True):
            (row,) = (line.split() for line in text.splitlines() if line.strip().startswith(f"{radius:.6g} "))
            assert [float(word) for word in row[1:]] == pytest.approx(axis, abs=1e-6)
        assert f"along (0 1 2): {found[kind]['along']:.6g} {found[kind]['unit']}" in text
    assert f"manipulability {found['manipulability']:.6g} m^3, isotropy {found['isotropy']:.6g}" in text


def test_manipulability_is_said_to_be_without_limits():
    """Beside semi-axes within limits, whose product is another figure."""
    plain, weighed = (run("ellipsoids", "gen3", "--q", *Q, *more).stdout for more in ([], ["--limits"]))
    (line,) = (line for line in plain.splitlines() if line.startswith("manipulability"))
    assert f"of joint velocities of 1 rad/s, without limits: {line}" in weighed.splitlines()


def test_a_singular_posture_is_called_flat_and_unbounded():
    zero = ["ellipsoids", "iiwa14", "--q", *"0000000"]
    text = run(*zero).stdout
    assert text.count("flat") == text.count("unbounded") == 2
    assert "rank 1" in text
    assert "manipulability 0 m^3" in text
    found = answer(*zero, "--along", "0", "0", "1")
    assert found["velocity"]["singular"] == [False, True, True]
    assert found["force"]["radii"][1:] == [None, None]
    assert found["velocity"]["along"] == 0.0
    assert found["force"]["along"] is None


def test_degrees_are_read():
    one = answer("ellipsoids", "iiwa14", "--q", *Q)
    other = answer("ellipsoids", "iiwa14", "--q", *(str(np.rad2deg(q)) for q in ANGLES), "--degrees")
    assert one["velocity"]["radii"] == pytest.approx(other["velocity"]["radii"])


def test_polytopes_tell_the_largest_pure_force_along_a_direction():
    """In tip axes the direction is one of the tip's."""
    pytest.importorskip("pycapacity")
    arm = srs_ik.load("iiwa14")
    words = ["ellipsoids", "iiwa14", "--q", *Q, "--polytopes", "--along", "0", "0", "2"]
    up = srs_ik.force_polytope(arm, ANGLES).radius_along([0, 0, 1])
    assert answer(*words)["force_polytope"]["along"] == pytest.approx(up)
    shown = run(*words).stdout
    assert f"alone along (0 0 2): {up:.6g} N" in shown
    forward = arm.forward_kinematics(ANGLES).rotation[:, 2]
    along = srs_ik.velocity_polytope(arm, ANGLES).radius_along(forward)
    assert answer(*words, "--axes", "tip")["velocity_polytope"]["along"] == pytest.approx(along)
    assert answer(*words[:-4])["force_polytope"]["along"] is None


def test_polytopes_are_printed_in_the_same_axes():
    pytest.importorskip("pycapacity")
    arm = srs_ik.load("iiwa14")
    words = ["ellipsoids", "iiwa14", "--q", *Q, "--polytopes", "--axes", "tip"]
    found, text = answer(*words), run(*words).stdout
    R = arm.forward_kinematics(ANGLES).rotation
    for kind, expected in (
        ("velocity", srs_ik.velocity_polytope(arm, ANGLES)),
        ("force", srs_ik.force_polytope(arm, ANGLES)),
    ):
        body = found[f"{kind}_polytope"]
        assert np.allclose(np.array(body["vertices"]) @ R.T, expected.vertices)
        assert body["faces"] == expected.faces.tolist()
        assert body["rank"] == 3
        least, largest = np.array(body["vertices"]).min(axis=0), np.array(body["vertices"]).max(axis=0)
        for name, low, high in zip("xyz", least, largest, strict=True):
            rows = [line.split() for line in text.splitlines() if line.startswith(f"{name} ")]
            assert [name, f"{low:.6g}", f"{high:.6g}"] in rows
    weightless = answer(*words, "--no-gravity")["force_polytope"]["vertices"]
    assert np.allclose(
        np.array(weightless) @ R.T, srs_ik.force_polytope(arm, ANGLES, gravity=False).vertices, rtol=0.0, atol=1e-9
    )
    flat = run("ellipsoids", "iiwa14", "--q", *"0000000", "--polytopes").stdout
    assert flat.count("flat across (") == flat.count("unbounded along (") == 2


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["iiwa14"], "--q Q1 .. Q7"),
        (["iiwa14", "--q", "1", "2"], "--q takes 7 numbers, not 2"),
        (["iiwa14", "--q", *Q, "--part", "all"], "all"),
        (["iiwa14", "--q", *Q, "--axes", "world"], "world"),
        (["iiwa14", "--q", *Q, "--along", "0", "0", "0"], "--along is a direction"),
        (["iiwa14", "--q", *Q, "--part", "full", "--polytopes"], "--part linear or angular"),
        (["human_arm", "--q", *Q, "--limits"], "gives no velocity limit for shoulder_yaw"),
        (["human_arm", "--q", *Q, "--polytopes"], "gives no velocity limit for shoulder_yaw"),
        (["iiwa41", "--q", *Q], "iiwa41"),
    ],
)
def test_wrong_input_is_one_line_and_exit_status_2(words, named):
    result = run("ellipsoids", *words)
    assert result.exit_code == 2, result.exception
    assert result.stdout == ""
    assert result.stderr.count("\n") == 1
    assert named in result.stderr


def test_without_pycapacity_the_pip_command_is_given(monkeypatch):
    monkeypatch.setitem(sys.modules, "pycapacity", None)
    result = run("ellipsoids", "iiwa14", "--q", *Q, "--polytopes")
    assert result.exit_code == 2
    assert result.stderr == f"srs-ik: a polytope needs an optional part of srs_ik: {install_command('polytopes')}\n"
