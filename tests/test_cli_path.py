"""`srs-ik path` and `srs-ik solve --objective` print what the arm answers; wrong input is one line."""

import csv

import numpy as np
import pytest
from command_line import POSE, answer, run

import srs_ik

Q = [0.2, 0.6, 0.1, -1.2, 0.2, 0.8, 0.1]


def line_of_poses(count, far=0.2):
    T = srs_ik.load("iiwa14").forward_kinematics(Q).homogeneous
    poses = np.repeat(T[None], count, axis=0)
    poses[:, 1, 3] += np.linspace(0.0, far, count)
    return poses


def write(path, poses, kind="rpy"):
    import pinocchio as pin

    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        names = ["roll", "pitch", "yaw"] if kind != "quaternion" else ["qw", "qx", "qy", "qz"]
        writer.writerow([*names, "x", "y", "z", "remark"])
        for T in poses:
            if kind == "quaternion":
                x, y, z, w = pin.Quaternion(T[:3, :3].copy()).coeffs()
                turn = [w, x, y, z]
            else:
                turn = pin.rpy.matrixToRpy(T[:3, :3]) * (180.0 / np.pi if kind == "degrees" else 1.0)
            writer.writerow([*(repr(float(v)) for v in (*turn, *T[:3, 3])), "a, b"])
    return str(path)


@pytest.mark.parametrize("kind", ["rpy", "quaternion", "degrees"])
def test_the_path_of_a_file_is_that_of_the_arm(tmp_path, kind):
    poses = line_of_poses(30)
    seed = np.rad2deg(Q) if kind == "degrees" else Q
    words = ["--seed", *map(str, seed), *(["--degrees"] if kind == "degrees" else [])]
    out = tmp_path / "joints.csv"
    got = answer("path", "iiwa14", write(tmp_path / "poses.csv", poses, kind), *words, "--dt", "0.1", "--out", str(out))
    arm = srs_ik.load("iiwa14")
    expected = arm.solve_path(poses, seed=Q, dt=0.1)
    assert expected
    np.testing.assert_allclose(got["q"], expected.q, atol=1e-7)
    assert got["status"] == ["OK"] * 30
    assert got["breaks"] == []
    assert got["largest_step"] == pytest.approx(expected.largest_step, abs=1e-7)
    rows = list(csv.reader(out.open()))
    assert rows[0] == ["t", *arm.joint_names]
    written = np.array(rows[1:], float)
    np.testing.assert_array_equal(written[:, 1:], got["q"])
    np.testing.assert_allclose(written[:, 0], 0.1 * np.arange(30))


def test_the_table_names_every_joint_and_its_largest_step(tmp_path):
    poses = line_of_poses(20)
    result = run("path", "iiwa14", write(tmp_path / "poses.csv", poses))
    assert result.exit_code == 0, result.stderr
    path = srs_ik.load("iiwa14").solve_path(poses)
    rows = {line.split()[0]: line.split() for line in result.stdout.splitlines() if len(line.split()) == 5}
    for k, name in enumerate(srs_ik.load("iiwa14").joint_names):
        assert float(rows[name][4]) == pytest.approx(np.rad2deg(np.abs(path.steps[:, k]).max()), abs=1e-3)
    assert "0 breaks" in result.stdout


def test_a_broken_path_is_exit_status_1_with_the_line_of_the_file(tmp_path):
    out = tmp_path / "joints.csv"
    file = write(tmp_path / "poses.csv", line_of_poses(40, far=1.5))
    result = run("path", "iiwa14", file, "--out", str(out))
    first = srs_ik.load("iiwa14").solve_path(line_of_poses(40, far=1.5)).breaks[0]
    assert result.exit_code == 1
    assert result.stderr.count("\n") == 1
    assert f"poses.csv, line {first.sample + 2}: Pose {first.sample} is not reached" in result.stderr
    assert not out.exists()
    broken = answer("path", "iiwa14", file, exit_code=1)
    assert broken["breaks"][0]["sample"] == first.sample
    assert broken["breaks"][0]["line"] == first.sample + 2
    assert broken["status"][first.sample] == "UNREACHABLE"


def test_a_path_starts_where_the_robot_stands(tmp_path):
    poses = line_of_poses(20)
    arm, file = srs_ik.load("iiwa14"), write(tmp_path / "poses.csv", poses)
    stands = arm.solve_all(poses[0])[1].q
    got = answer("path", "iiwa14", file, "--start", *map(str, stands))
    np.testing.assert_allclose(got["q"][0], stands, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(got["q"], arm.solve_path(poses, known={0: stands}).q, rtol=0.0, atol=1e-6)
    missed = run("path", "iiwa14", file, "--start", *map(str, stands + 0.1))
    assert (missed.exit_code, missed.stderr.count("\n")) == (2, 1)
    off = arm.verify(poses[0], stands + 0.1)
    by = f"it misses it by {1e3 * off.position:.3g} mm and {off.orientation:.3g} rad; --seed begins near it"
    assert missed.stderr == f"srs-ik: --start is not at the first pose, {file}, line 2: {by}\n"


@pytest.mark.parametrize(
    ("word", "unit"), [("0.3", []), ("0.3,1,1,1,1,1,0.2", []), ("17.188733853924695", ["--degrees"])]
)
def test_a_path_keeps_velocities_that_are_given(tmp_path, word, unit):
    poses = line_of_poses(20)
    words = ["--objective", "time", "--acceleration", "400" if unit else "8", *unit, "--velocity", word]
    file = write(tmp_path / "poses.csv", poses)
    limit = np.array([float(each) for each in word.split(",")]) * np.ones(7) * (np.pi / 180.0 if unit else 1.0)
    pushes = np.full(7, np.deg2rad(400.0) if unit else 8.0)
    arm = srs_ik.load("iiwa14").with_limits(velocity=limit)
    got = answer("path", "iiwa14", file, *words)
    expected = arm.solve_path(poses, objective="time", acceleration_limit=pushes)
    if not unit:  # the angles of the poses are radians
        np.testing.assert_allclose(got["times"], expected.times, rtol=1e-6)
    steps, spent = np.abs(np.diff(got["q"], axis=0)), np.diff(got["times"])[:, None]
    assert (steps <= limit * spent + 1e-9).all()
    assert (steps > 0.9 * limit * spent).any()


@pytest.mark.parametrize("word", ["8", "8,8,9,9,10,10,11"])
def test_limits_of_acceleration_give_the_times_at_which_poses_are_passed(tmp_path, word):
    poses = line_of_poses(20)
    out = tmp_path / "joints.csv"
    words = ["--seed", *map(str, Q), "--objective", "time", "--acceleration", word, "--out", str(out)]
    file = write(tmp_path / "poses.csv", poses)
    got = answer("path", "iiwa14", file, *words)
    limit = np.array([float(each) for each in word.split(",")]) * np.ones(7)
    expected = srs_ik.load("iiwa14").solve_path(poses, seed=Q, objective="time", acceleration_limit=limit)
    np.testing.assert_allclose(got["times"], expected.times, atol=1e-6)
    assert got["value"] == got["times"][-1]
    rows = list(csv.reader(out.open()))
    assert rows[0][0] == "t"
    np.testing.assert_array_equal(np.array(rows[1:], float)[:, 0], got["times"])
    assert f"{got['times'][-1]:.4g} s from rest to rest" in run("path", "iiwa14", file, *words).stdout


def test_a_motion_is_written_with_velocities(tmp_path):
    poses, out = line_of_poses(20), tmp_path / "motion.csv"
    file = write(tmp_path / "poses.csv", poses)
    words = ["--seed", *map(str, Q), "--objective", "time", "--acceleration", "8"]
    told = run("path", "iiwa14", file, *words, "--out", str(out), "--period", "0.004")
    assert told.exit_code == 0
    assert "times the path's own times, to keep the limits" in told.stderr
    header, *rows = csv.reader(out.open())
    figures = np.array(rows, float)
    arm = srs_ik.load("iiwa14")
    assert header == ["t", *arm.joint_names, *(f"{name}_velocity" for name in arm.joint_names)]
    assert np.diff(figures[:, 0]) == pytest.approx(0.004)
    assert np.abs(np.diff(figures[:, 8:], axis=0)).max() <= 8.0 * 0.004 * (1.0 + 1e-6)
    assert run("fk", "iiwa14", "--file", str(out)).exit_code == 0
    assert "goes with --dt or --acceleration" in run("path", "iiwa14", file, "--out", str(out), "--period", "1").stderr
    least = ["--objective", "time", "--out", str(out), "--period", "0.004"]
    assert "goes with --dt or --acceleration" in run("path", "iiwa14", file, *least).stderr
    adapter = tmp_path / "robot.toml"
    assert run("inspect", "iiwa14", "--write", str(adapter)).exit_code == 0
    assert "acceleration = inf" in adapter.read_text()
    limits = "".join(f"{name} = {{ acceleration = 8 }}\n" for name in arm.joint_names)
    adapter.write_text(f"{adapter.read_text()}\n[limits]\n{limits}")
    assert run("path", str(adapter), file, "--seed", *map(str, Q), *least).exit_code == 0
    np.testing.assert_allclose(np.array(list(csv.reader(out.open()))[1:], float), figures, atol=1e-12)
    assert "--period is of the motion in --out" in run("path", "iiwa14", file, *words, "--period", "1").stderr


@pytest.mark.slow
def test_the_picture_of_the_strips_is_drawn(tmp_path):
    picture = tmp_path / "strips.png"
    poses = line_of_poses(12)
    got = answer(
        "path", "iiwa14", write(tmp_path / "poses.csv", poses), "--objective", "largest_step", "--plot", str(picture)
    )
    assert picture.read_bytes().startswith(b"\x89PNG")
    expected = srs_ik.load("iiwa14").solve_path(poses, objective="largest_step")
    np.testing.assert_allclose(got["largest_step"], expected.largest_step, atol=1e-7)
    wrong = run("path", "iiwa14", write(tmp_path / "poses.csv", poses), "--plot", "strips.sheet")
    assert wrong.exit_code == 2
    assert "--plot" in wrong.stderr


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("", "is empty"),
        ("x,y,z,roll,pitch,yaw\n", "no poses"),
        ("x,y,z\n1,2,3\n", "line 1: the header must name the columns x, y, z, roll, pitch, yaw (or qx, qy, qz, qw)"),
        ("x,y,roll,pitch,yaw\n", "it lacks z"),
        ("x,y,z,qx,qy,qz\n", "it lacks qw"),
        ("x,y,z,roll,pitch,yaw,qw\n", "either"),
        ("x,x,y,z,roll,pitch,yaw\n", "two columns 'x'"),
        ("0.3,0.2,0,0,0,0\n", "line 1: the header must name the columns x, y, z"),
        ("x,y,z,roll,pitch,yaw\n.5,.1,.6,0,1.5,0\n\n.5,.1,up,0,1.5,0\n", "line 4: z must be a finite number, not 'up'"),
        ("x,y,z,roll,pitch,yaw\n.5,.1,.6,0,nan,0\n", "line 2: pitch must be a finite number, not 'nan'"),
        ("x,y,z,roll,pitch,yaw\n.5,.1,.6\n", "line 2: there is no roll; the line ends after 3 columns"),
        (
            "x,y,z,roll,pitch,yaw\n0,5,0,1,0,6,0,1,5,0,0\n",
            "line 2: there are 11 columns and names for 6",
        ),
        ("x,y,z,roll,pitch,yaw\n1_0,.1,.6,0,0,0\n", "line 2: x must be a finite number, not '1_0'"),
        ("x;y;z;roll;pitch;yaw\n.5;.1;.6;0;0;0\n", "line 1: columns are separated by commas, not by semicolons"),
        ("x\ty\tz\troll\tpitch\tyaw\n", "line 1: columns are separated by commas, not by tabs"),
        ("x,y,z,qx,qy,qz,qw\n.5,.1,.6,0,0,0,2\n", "line 2: a quaternion is a rotation only if its length is 1, not 2"),
    ],
)
def test_a_wrong_file_is_one_line_with_its_place(tmp_path, text, named):
    file = tmp_path / "poses.csv"
    file.write_text(text)
    result = run("path", "iiwa14", str(file))
    assert result.exit_code == 2, result.exception
    assert result.stdout == ""
    assert result.stderr.count("\n") == 1
    assert named in result.stderr
    assert "poses.csv" in result.stderr


@pytest.mark.parametrize(
    "words",
    [
        ("path", "iiwa14", "FILE", "--out", "LINK"),
        ("solve", "iiwa14", "--file", "FILE", "--out", "FILE"),
        ("follow", "iiwa14", "FILE", "--dt", "0.01", "--out", "FILE"),
        ("place", "iiwa14", "FILE", "--grid", "0", "1", "2", "0", "1", "2", "--out", "FILE"),
        ("place", "iiwa14", "OTHER", "--candidates", "FILE", "--out", "FILE"),
    ],
)
def test_poses_are_not_written_over(tmp_path, words):
    file = write(tmp_path / "poses.csv", line_of_poses(3))
    other = write(tmp_path / "other.csv", line_of_poses(2))
    (tmp_path / "link.csv").symlink_to(file)
    before = (tmp_path / "poses.csv").read_bytes()
    names = {"FILE": file, "OTHER": other, "LINK": str(tmp_path / "link.csv")}
    result = run(*(names.get(word, word) for word in words))
    assert result.exit_code == 2, result.exception
    assert "give the answers a file of their own" in result.stderr
    assert (tmp_path / "poses.csv").read_bytes() == before


@pytest.mark.slow
def test_empty_cells_behind_a_line_are_nothing(tmp_path):
    file = tmp_path / "poses.csv"
    file.write_text("x,y,z,roll,pitch,yaw\n.5,.1,.6,0,1.5,0,,\n")
    assert run("path", "iiwa14", str(file)).exit_code == 0


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["--dt", "1_0"], "--dt takes a number, not '1_0'"),
        (["--dt", "0"], "--dt takes a positive number"),
        (["--longest-step", "-1"], "--longest-step"),
        (["--velocity", "0"], "--velocity takes a positive number"),
        (["--velocity", "1,2"], "--velocity takes one number, or 7"),
        (["--velocity", "1"], "--velocity goes with --dt, or with --objective time"),
        (["--start", "1", "2"], "--start takes 7 numbers, not 2"),
        (["--seed", "1", "2"], "--seed takes 7 numbers, not 2"),
        (["--acceleration", "5"], "--acceleration goes with --objective time"),
        (["--objective", "time", "--acceleration", "5,6"], "--acceleration takes one number, or 7"),
        (["--objective", "time", "--acceleration", "fast"], "--acceleration takes a number, not 'fast'"),
        (["--objective", "time", "--acceleration", "0"], "--acceleration takes a positive number"),
        (["--out", "no/such/folder/q.csv"], "no/such/folder"),
        (["--tip", "nose"], "nose"),
    ],
)
def test_wrong_options_are_one_line(tmp_path, words, named):
    result = run("path", "iiwa14", write(tmp_path / "poses.csv", line_of_poses(3)), *words)
    assert result.exit_code == 2, result.exception
    assert result.stderr.count("\n") == 1
    assert named in result.stderr


@pytest.mark.parametrize(
    "words", [("path",), ("follow", "--dt", "0.1"), ("fk", "--file"), ("solve", "--file")], ids=lambda words: words[0]
)
@pytest.mark.parametrize(("out", "named"), [("none/q.csv", "there is no folder"), ("", "it is a folder")])
def test_that_answers_have_no_place_is_said_before_the_work(tmp_path, words, out, named):
    file, out = write(tmp_path / "poses.csv", line_of_poses(3)), str(tmp_path / out)
    result = run(words[0], str(tmp_path / "none.urdf"), *words[1:], file, "--out", out)
    assert result.exit_code == 2, result.exception
    assert result.stderr.count("\n") == 1
    assert out in result.stderr
    assert named in result.stderr


def test_missing_and_binary_files_are_one_line(tmp_path):
    binary = tmp_path / "poses.csv"
    binary.write_bytes(b"\xff\xfe\x00\x01")
    for file, named in ((tmp_path / "none.csv", "No such file"), (binary, "no text file"), (tmp_path, "directory")):
        result = run("path", "iiwa14", str(file))
        assert result.exit_code == 2
        assert result.stderr.count("\n") == 1
        assert named in result.stderr


# solve --objective ------------------------------------------------------------------------------------------------

OBJECTIVES = {
    "manipulability": ([], {}),
    "force_velocity_ratio": (
        ["--force", "0", "0", "1", "--velocity", "1", "0", "0"],
        {"force": [0, 0, 1], "velocity": [1, 0, 0]},
    ),
    "force_then_velocity": (
        ["--force", "0", "0", "1", "--velocity", "1", "0", "0", "--tolerance", "0.2"],
        {"force": [0, 0, 1], "velocity": [1, 0, 0], "tolerance": 0.2},
    ),
    "twist": (["--twist", *"100010"], {"twist": [1, 0, 0, 0, 1, 0]}),
    "wrench": (["--wrench", *"001000"], {"wrench": [0, 0, 1, 0, 0, 0]}),
    "reference_posture": (["--reference", *map(str, Q)], {"reference": Q}),
}


@pytest.mark.parametrize("name", OBJECTIVES)
def test_solve_gives_the_optimum_of_the_arm(name):
    words, parameters = OBJECTIVES[name]
    got = answer("solve", "iiwa14", *POSE, "--objective", name, *words)
    best = srs_ik.load("iiwa14").optimise(np.array(got["T_base_tip"]), name, **parameters)
    assert got["objective"] == name
    assert got["q"] == best.q.tolist()
    assert got["value"] == best.value
    assert got["second_value"] == best.second_value
    assert got["interval"] == {"lower": best.interval.lower, "upper": best.interval.upper}
    text = run("solve", "iiwa14", *POSE, "--objective", name, *words).stdout
    assert f"{best.value:.9g}" in next(line for line in text.splitlines() if line.startswith(name))


def test_an_objective_out_of_reach_is_exit_status_1():
    far = answer("solve", "iiwa14", "--xyz", "2", "0", "0", *POSE[4:], "--objective", "manipulability", exit_code=1)
    assert far["status"] == "UNREACHABLE"
    assert far["interval"] is None


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["--objective", "manipulation"], "did you mean 'manipulability'"),
        (["--objective", "twist"], "needs --twist, 6"),
        (["--objective", "twist", "--force", "0", "0", "1"], "takes no parameter 'force'"),
        (["--objective", "twist", "--twist", "0", "0", "1"], "--twist takes 6 numbers, not 3"),
        (["--objective", "manipulability", "--seed", *"1234567"], "--objective goes with none"),
        (["--objective", "manipulability", "--all"], "--objective goes with none"),
        (["--force", "0", "0", "1"], "--force is a parameter of an objective"),
        (["--objective", "force_then_velocity", "--tolerance", "much"], "--tolerance takes a number, not 'much'"),
    ],
)
def test_a_wrong_objective_is_one_line(words, named):
    result = run("solve", "iiwa14", *POSE, *words)
    assert result.exit_code == 2, result.exception
    assert result.stdout == ""
    assert result.stderr.count("\n") == 1
    assert named in result.stderr


@pytest.mark.slow
def test_velocity_limits_that_are_passed_are_told(tmp_path):
    poses = line_of_poses(30)
    file = write(tmp_path / "poses.csv", poses)
    result = run("path", "iiwa14", file, "--dt", "0.001")
    assert result.exit_code == 0
    arm = srs_ik.load("iiwa14")
    path = arm.solve_path(poses, dt=0.001)
    share = np.abs(path.steps) / (0.001 * arm.velocity_limit)
    step, joint = np.unravel_index(share.argmax(), share.shape)
    assert result.stderr.count("\n") == 1
    assert f"line {step + 3}: no path was found that keeps the velocity limits" in result.stderr
    assert f"joint {arm.joint_names[joint]} takes {share.max():.4g} times" in result.stderr
    np.testing.assert_allclose(answer("path", "iiwa14", file, "--dt", "0.001")["velocity_use"], share.max(axis=1))
    assert run("path", "iiwa14", file, "--dt", "0.5").stderr == ""
    assert answer("path", "iiwa14", file)["velocity_use"] is None


def test_times_by_accelerations_are_told_where_dt_is_given_too(tmp_path):
    file = write(tmp_path / "poses.csv", line_of_poses(10))
    words = ["--dt", "0.1", "--objective", "time", "--acceleration", "5"]
    told = run("path", "iiwa14", file, *words, "--out", str(tmp_path / "joints.csv"))
    assert told.exit_code == 0
    assert told.stderr.count("\n") == 1
    assert "--acceleration, not --dt" in told.stderr
    assert run("path", "iiwa14", file, *words).stderr == ""


def test_times_of_a_file_that_are_not_the_period_are_told(tmp_path):
    file = tmp_path / "poses.csv"
    rows = (f"{0.1 * k:.1f},{0.5 + 0.01 * k},0.1,0.5,0,1.57,0" for k in range(5))
    file.write_text("\n".join(["t,x,y,z,roll,pitch,yaw", *rows]) + "\n")
    told = run("path", "iiwa14", str(file), "--dt", "0.2")
    assert told.exit_code == 0
    assert told.stderr == f"srs-ik: {file} has times 0.1 s apart, and --dt says 0.2 s, which counts\n"
    assert run("path", "iiwa14", str(file), "--dt", "0.1").stderr == ""
    assert run("path", "iiwa14", str(file)).stderr == ""


def test_a_first_line_that_names_no_columns_is_told(tmp_path):
    file = tmp_path / "poses.csv"
    file.write_text("made by me\nx,y,z,roll,pitch,yaw\n0.5,0.1,0.6,0,1.57,0\n")
    said = run("path", "iiwa14", str(file))
    assert said.exit_code == 2
    assert "line 1: columns are to be named here, such as x, y, z, roll, pitch, yaw, not 'made by me'" in said.stderr
    assert "comments begin with #" in said.stderr
    file.write_text(f"# {file.read_text()}")
    assert run("path", "iiwa14", str(file)).exit_code == 0
