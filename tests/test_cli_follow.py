"""`srs-ik follow` prints and writes what a tracker answers; wrong input is one line."""

import csv
import json

import numpy as np
import pytest
from command_line import answer, run

import srs_ik

Q = [0.2, 0.6, 0.1, -1.2, 0.2, 0.8, 0.1]


def targets(path, count=60, lost=(20, 21)):
    """A slow motion along y in a file, some of it lost."""
    import pinocchio as pin

    T = srs_ik.load("iiwa14").forward_kinematics(Q).homogeneous
    poses = []
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["x", "y", "z", "roll", "pitch", "yaw"])
        for k in range(count):
            T[1, 3] += 2e-6 * min(k, count - k)
            poses.append(None if k in lost else T.copy())
            figures = (*T[:3, 3], *pin.rpy.matrixToRpy(T[:3, :3]))
            writer.writerow(["nan"] * 6 if k in lost else [repr(float(x)) for x in figures])
    return str(path), poses


def quaternion(T):
    """x, y, z, w of a pose's rotation."""
    import pinocchio as pin

    return pin.Quaternion(T[:3, :3]).coeffs()


def test_the_steps_of_a_file_are_those_of_a_tracker(tmp_path):
    file, poses = targets(tmp_path / "poses.csv")
    out = tmp_path / "joints.csv"
    words = ("--dt", "0.002", "--q", *map(str, Q), "--out", str(out))
    got = answer("follow", "iiwa14", file, *words)
    arm = srs_ik.load("iiwa14")
    tracker = arm.tracker(Q, 0.002)
    steps = [tracker.update(T) for T in poses]
    np.testing.assert_allclose(got["q"], [step.q for step in steps], atol=1e-7)
    assert got["status"] == [str(step.status) for step in steps]
    assert got["status"][20] == "HELD"
    assert (np.array(got["largest_acceleration"]) <= np.array(got["acceleration_limit"])).all()
    rows = list(csv.reader(out.open()))
    assert rows[0][:8] == ["t", *arm.joint_names]
    np.testing.assert_array_equal(np.array([row[1:8] for row in rows[1:]], float), got["q"])


def test_accelerations_may_be_without_a_limit(tmp_path):
    file, poses = targets(tmp_path / "poses.csv")
    got = answer("follow", "iiwa14", file, "--dt", "0.002", "--q", *map(str, Q), "--acceleration", "inf")
    assert got["acceleration_limit"] == [None] * 7
    tracker = srs_ik.load("iiwa14").tracker(Q, 0.002, acceleration=np.inf)
    np.testing.assert_allclose(got["q"], [tracker.update(T).q for T in poses], atol=1e-7)


def test_jitter_is_taken_from_poses_unless_they_are_wanted_as_they_are(tmp_path):
    _, poses = targets(tmp_path / "poses.csv", 300)
    rng = np.random.default_rng(0)
    file = tmp_path / "shaken.csv"
    with file.open("w", newline="") as out:
        writer = csv.writer(out)
        writer.writerow(["x", "y", "z", "qx", "qy", "qz", "qw"])
        for k, T in enumerate([*poses, *poses[-1:] * 300]):
            # None in the end: the tip is on the last target then.
            noise = rng.normal(0.0, 2e-4 * (k < 300), 3)
            writer.writerow(["nan"] * 7 if T is None else [*(T[:3, 3] + noise), *quaternion(T)])
    words = ("follow", "iiwa14", str(file), "--dt", "0.002", "--q", *map(str, Q))
    got = [answer(*words, *more) for more in ((), ("--smoothing", "0"))]
    shakes = [np.abs(np.diff(steps["q"], n=2, axis=0)[100:298]).mean() for steps in got]
    assert shakes[0] < 0.3 * shakes[1]


def test_the_noise_of_poses_is_told(tmp_path):
    _, poses = targets(tmp_path / "poses.csv", 300, ())
    rng = np.random.default_rng(5)
    file = tmp_path / "shaken.csv"
    with file.open("w", newline="") as out:
        writer = csv.writer(out)
        writer.writerow(["x", "y", "z", "qx", "qy", "qz", "qw"])
        writer.writerows([*(T[:3, 3] + rng.normal(0.0, 2e-4, 3)), *quaternion(T)] for T in poses)
    words = ("follow", "iiwa14", str(file), "--dt", "0.002", "--q", *map(str, Q))
    done = run(*words, "--json")
    got = json.loads(done.stdout)
    assert got["noise"][0] == pytest.approx(2e-4, rel=0.5)
    assert 0.005 < got["smoothed"] < 0.05
    assert f"smoothed by {1e3 * got['smoothed']:.3g} ms" in run(*words).stdout
    assert json.loads(run(*words, "--smoothing", "0", "--json").stdout)["smoothed"] == 0.0


def test_the_table_shows_limits_and_statuses(tmp_path):
    file, _ = targets(tmp_path / "poses.csv")
    done = run("follow", "iiwa14", file, "--dt", "0.002", "--elbow", "limit_margin", "--smoothing", "0.01")
    assert "largest velocity" in done.stdout
    assert "HELD" in done.stdout


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--dt", "0"), "dt must be a positive"),
        (("--dt", "1e-300"), "dt is the time between two updates, 1e-06 s at least"),
        (("--dt", "fast"), "--dt takes a number"),
        (("--dt", "0.01", "--elbow", "best"), "not 'best'"),
        (("--dt", "0.01", "--velocity", "-1"), "velocity must be a positive"),
    ],
)
def test_wrong_input_is_one_line(tmp_path, words, said):
    file, _ = targets(tmp_path / "poses.csv", 3, ())
    done = run("follow", "iiwa14", file, *words)
    assert done.exit_code == 2
    assert said in done.stderr
    assert done.stderr.count("\n") == 1


def test_a_file_of_lost_targets_has_no_posture_to_begin_with(tmp_path):
    file, _ = targets(tmp_path / "poses.csv", 3, (0, 1, 2))
    done = run("follow", "iiwa14", file, "--dt", "0.01")
    assert done.exit_code == 2
    assert "no posture to begin with" in done.stderr


@pytest.mark.parametrize(("step", "said"), [(0.02, True), (0.002, False)])
def test_times_of_the_file_that_are_not_those_of_dt_are_told(tmp_path, step, said):
    file, _ = targets(tmp_path / "poses.csv", lost=())
    header, *rows = (tmp_path / "poses.csv").read_text().splitlines()
    lines = [f"time,{header}", *(f"{k * step:.4f},{row}" for k, row in enumerate(rows))]
    (tmp_path / "poses.csv").write_text("\n".join(lines))
    done = run("follow", "iiwa14", file, "--dt", "0.002", "--q", *map(str, Q))
    assert done.exit_code == 0
    assert ("has times 0.02 s apart, and --dt says 0.002 s" in done.stderr) == said


def test_comments_are_left_out_and_name_columns_above_figures(tmp_path):
    plain, _ = targets(tmp_path / "plain.csv", lost=())
    header, *rows = (tmp_path / "plain.csv").read_text().splitlines()
    words = ("--dt", "0.002", "--q", *map(str, Q))
    wanted = answer("follow", "iiwa14", plain, *words)["q"]
    for head in (["# of a camera", header], ["# of a camera", f"# {header}"]):
        (tmp_path / "other.csv").write_text("\n".join([*head, *rows[:30], "# and on", *rows[30:]]))
        assert answer("follow", "iiwa14", str(tmp_path / "other.csv"), *words)["q"] == wanted
    np.savetxt(tmp_path / "numpy.csv", np.array([row.split(",") for row in rows], float), header=header, delimiter=",")
    assert np.allclose(answer("follow", "iiwa14", str(tmp_path / "numpy.csv"), *words)["q"], wanted, atol=1e-9)


def test_figures_without_names_are_refused(tmp_path):
    (tmp_path / "poses.csv").write_text("0.5,0.1,0.6,0,1.57,0\n")
    done = run("follow", "iiwa14", str(tmp_path / "poses.csv"), "--dt", "0.002")
    assert done.exit_code == 2
    assert "the header must name the columns x, y, z" in done.stderr


def test_degrees_are_those_of_velocities_too(tmp_path):
    file, _ = targets(tmp_path / "poses.csv", lost=())
    turned = ["--degrees", "--q", *(str(np.rad2deg(x)) for x in Q), "--velocity", "30", "--acceleration", "90"]
    found = answer("follow", "iiwa14", degrees_of(tmp_path, file), "--dt", "0.002", *turned)
    assert found["velocity_limit"] == pytest.approx([np.deg2rad(30.0)] * 7)
    assert found["acceleration_limit"] == pytest.approx([np.deg2rad(90.0)] * 7)


def degrees_of(folder, file):
    """The file with its angles in degrees."""
    with open(file, newline="") as given, (folder / "degrees.csv").open("w", newline="") as turned:
        rows = csv.reader(given)
        csv.writer(turned).writerow(next(rows))
        csv.writer(turned).writerows([*row[:3], *(float(x) * 180.0 / np.pi for x in row[3:])] for row in rows)
    return str(folder / "degrees.csv")


@pytest.mark.parametrize("cell", ["nan", ""])
@pytest.mark.parametrize("timed", [True, False])
def test_lost_targets_of_a_log_are_nan_or_empty(tmp_path, cell, timed):
    """As pandas writes them; a line that has nothing else is a period all the same."""
    file, poses = targets(tmp_path / "poses.csv")
    header, *lines = (tmp_path / "poses.csv").read_text().splitlines()
    lines = [line.replace("nan", cell) for line in lines]
    if timed:
        header, lines = f"t,{header}", [f"{0.01 * k},{line}" for k, line in enumerate(lines)]
    (tmp_path / "poses.csv").write_text("\n".join([header, *lines, "", ""]))
    out = tmp_path / "out.csv"
    words = ["follow", "iiwa14", file, "--dt", "0.01", "--q", *map(str, Q), "--out", str(out)]
    assert run(*words).exit_code == 0
    tracker = srs_ik.load("iiwa14").tracker(Q, 0.01)
    statuses = [str(tracker.update(T).status) for T in poses]
    assert [row["status"] for row in csv.DictReader(out.open())] == statuses
    assert statuses.count("HELD") == 2


def test_a_target_that_is_lost_in_part_is_refused(tmp_path):
    file = tmp_path / "poses.csv"
    file.write_text("x,y,z,roll,pitch,yaw\n0.5,,0.6,0,nan,0\n")
    said = run("follow", "iiwa14", str(file), "--dt", "0.01")
    assert said.exit_code == 2
    assert "line 2: there is no y, pitch; where a target was lost, all of its columns are empty, or nan" in said.stderr


def test_with_a_scene_the_arm_stops_before_it(tmp_path):
    """The bodies are named where the last target is behind a plate."""
    T = srs_ik.load("iiwa14").forward_kinematics(Q).homogeneous
    x, y, z = T[:3, 3].tolist()
    plate = {"name": "plate", "box": [0.4, 0.4, 0.04], "xyz": [x, y, z - 0.25]}
    (tmp_path / "scene.json").write_text(json.dumps({"objects": [plate]}))
    rows = [[x, y, z - 1e-3 * k, *quaternion(T).tolist()] for k in range(300)]
    with (tmp_path / "poses.csv").open("w", newline="") as file:
        csv.writer(file).writerows([["x", "y", "z", "qx", "qy", "qz", "qw"], *rows])
    words = ("follow", "iiwa14", str(tmp_path / "poses.csv"), "--dt", "0.004", "--q", *map(str, Q))
    assert answer(*words)["status"][-1] == "OK"
    scene = ("--scene", str(tmp_path / "scene.json"), "--margin", "0.01")
    got = answer(*words, *scene, exit_code=1)
    assert got["status"][-1] == "HELD"
    around = srs_ik.Scene.from_file(tmp_path / "scene.json")
    arm = srs_ik.load("iiwa14")
    assert all(arm.collision(q, around, 0.01) is None for q in got["q"])
    told = run(*words, *scene)
    assert "would come too close to plate, and the arm stops before" in told.stderr.replace("\n", " ")
