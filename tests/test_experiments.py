"""The paper's experiments: their figures, recomputed by the paper's own equations or by Pinocchio alone."""

import json
import re
import sys

import arms
import numpy as np
import paper_posture as paper
import pytest
from command_line import run

from srs_ik import Posture, Task, loading
from srs_ik.errors import install_command
from srs_ik.paper.experiments import EXPERIMENTS, files
from srs_ik.paper.experiments.arm_sphere import arm_sphere
from srs_ik.paper.experiments.c_grasp import GRASPS, c_grasp
from srs_ik.paper.experiments.ik_accuracy import five_errors, ik_accuracy, reached_tasks
from srs_ik.paper.experiments.lr_arms import lr_arms
from srs_ik.paper.experiments.measure import angle_between, posture_figures, printed_angle_between
from srs_ik.paper.experiments.setting import SEED, ball, directions, task_directions
from srs_ik.paper.experiments.walking import SNAPSHOTS, walking
from srs_ik.system.arrays import plain

FIVE = ("elbow_m", "wrist_m", "hand_m", "grasp_rad", "pronosupination_rad")


def quiet(share: float) -> None:
    """Progress that nobody looks at."""


@pytest.fixture
def limb():
    return arms.load("human_arm")


# Left and right arms, and the sphere


@pytest.mark.parametrize("name", ["grasp", "no_grasp"])
def test_both_arms_lie_as_the_papers_equations_have_it(limb, name):
    figures = lr_arms(limb, quiet, 40).figures
    v, f = task_directions(np.random.default_rng(SEED), 40)
    assert figures["target_m"] == pytest.approx([0.5, 0.0, 0.0])
    g = np.array([1.0, 0.0, 0.0]) if name == "grasp" else None
    aligned = []
    for v_i, f_i in zip(v, f, strict=True):
        x_e, x_w = paper.geometric_posture(np.array([0.5, 0.0, 0.0]), v_i, f_i, g)
        axis = paper.unit(np.cross(x_e, x_w))
        aligned.append(abs(axis @ paper.unit(np.cross(v_i, f_i))))
    for side in ("left", "right"):
        found = figures[name][side]
        assert (found["reached"], found["not_finite"], found["elbow_on_the_other_side"]) == (40, 0, 0)
        assert found["alignment_of_elbow_axis_and_n"]["mean"] == pytest.approx(np.mean(aligned), abs=1e-12)
        assert found["alignment_gained_by_a_sweep"]["worst"] < 1e-12
    assert figures[name]["two_elbows_opposite_m"] < 1e-15


def test_a_wrong_posture_is_seen_as_one(limb):
    x_d, (v, f) = np.array([0.4, 0.1, 0.2]), task_directions(np.random.default_rng(SEED), 5)
    right = limb.posture(Task(x_d, v, f), "left")
    rows = right._rows.copy()
    line = right.hand[0] / np.linalg.norm(right.hand[0])
    rows[:, :3] = 2.0 * (right.elbow @ line)[:, None] * line - right.elbow + [0.0, 0.0, 1e-3]
    rows[0, 3] = np.nan
    target = np.broadcast_to(x_d, (5, 3))
    found = posture_figures(
        limb, Posture(rows, limb.limb.shoulder, "left"), target + np.array([0, 0, 1e-4]), "left", False
    )
    assert found["not_finite"] == 1
    assert found["elbow_on_the_other_side"] == 5
    assert found["upper_arm_error_m"]["worst"] > 1e-5
    assert found["alignment_gained_by_a_sweep"]["worst"] > 1e-7
    assert found["target_error_m"]["worst"] == pytest.approx(1e-4)


def test_the_sphere_counts_what_is_within_reach(limb):
    figures = arm_sphere(limb, quiet, 60).figures
    rng = np.random.default_rng(SEED)
    x_d = ball(rng, 60, 1.2 * 0.79)
    task_directions(rng, 60)
    wrist = np.linalg.norm(x_d - paper.HAND * directions(rng, 60), axis=1)
    held = int(np.sum((wrist < paper.ARM + paper.FOREARM) & (wrist > paper.ARM - paper.FOREARM)))
    free = int(np.sum(np.linalg.norm(x_d, axis=1) < paper.ARM + paper.FOREARM + paper.HAND))
    assert 0 < held < free < 60
    for side in ("left", "right"):
        assert figures["grasp"][side]["reached"] == figures["joint_angles"][side]["solved"] == held
        assert figures["no_grasp"][side]["reached"] == free
        for name in ("grasp", "no_grasp"):
            found = figures[name][side]
            assert found["reached"] + found["stretched"] + found["folded"] == 60
            assert found["not_finite"] == found["elbow_on_the_other_side"] == 0
            assert max(found["upper_arm_error_m"]["worst"], found["forearm_error_m"]["worst"]) < 1e-12


# Accuracy


def test_the_five_errors_are_those_of_the_papers_forward_kinematics(limb):
    figures = ik_accuracy(limb, quiet, 50).figures
    x_d, v, f = reached_tasks(limb, 50)
    task = Task(x_d, v, f, v, f)
    for side in ("left", "right"):
        assert figures[side]["solved"] == 50
        assert max(figures[side][name]["worst"] for name in FIVE) < 1e-12
        q = limb.solve_task(task, side, respect_limits=False).q
        for i in range(50):
            x_e, x_w = paper.geometric_posture(x_d[i], v[i], f[i], v[i], side == "left")
            e, w, h, R = paper.forward(q[i])
            off = [
                np.linalg.norm(a - b) for a, b in ((x_e, e), (x_w, w), (x_d[i], h), (v[i], R[:, 0]), (f[i], R[:, 2]))
            ]
            assert max(off) < 1e-11


@pytest.mark.parametrize("name", ["iiwa14", "gen3"])
def test_errors_of_other_arms_are_those_of_pinocchio_on_their_files(name):
    arm = arms.load(name)
    x_d, v, f = reached_tasks(arm, 20)
    task = Task(x_d, v, f, v, f)
    errors, solved = five_errors(arm, task, "left")
    assert solved >= 19
    assert max(errors[key].max() for key in FIVE) < 1e-10
    solution = arm.solve_task(task, "left", respect_limits=False)
    tips = [arms.forward(name)(q) for q, ok in zip(solution.q, solution.ok, strict=True) if ok]
    hand = [np.linalg.norm(T.translation - x) for T, x in zip(tips, x_d[solution.ok], strict=True)]
    assert max(hand) < 1e-10


def test_moved_joints_are_seen_as_errors(limb):
    x_d, v, f = reached_tasks(limb, 3)
    task = Task(x_d, v, f, v, f)

    class Skewed:
        def __getattr__(self, name):
            return getattr(limb, name)

        def solve_task(self, *words, **options):
            solution = limb.solve_task(*words, **options)
            solution.q[...] += 1e-6
            return solution

    errors, _ = five_errors(Skewed(), task, "left")
    assert all(values.min() > 1e-8 for name, values in errors.items() if not name.startswith("printed"))


def test_the_printed_angle_loses_half_of_the_digits():
    a = np.array([[1.0, 0.0, 0.0]])
    b = np.array([[np.cos(1e-9), np.sin(1e-9), 0.0]])
    assert angle_between(a, b) == pytest.approx([1e-9], rel=1e-12)
    assert printed_angle_between(a, b) == [0.0]


# Grasps


def planar_c(x_e, x_w, x_d, v, f):
    """C of three parallel joints at the shoulder, elbow and wrist."""
    turns = np.array([np.cross([0.0, 0.0, 1.0], x_d - p) for p in (np.zeros(3), x_e, x_w)])
    return np.sum((turns @ f) ** 2) / np.sum((turns @ v) ** 2)


@pytest.mark.parametrize("grasp", GRASPS)
def test_c_in_the_plane_is_that_of_three_parallel_joints(limb, grasp):
    extensions, count = np.array([0.3, 0.62, 0.9]), 12
    figures = c_grasp(limb, quiet, extensions, count).figures
    compared = 0
    for side in ("left", "right"):
        for d, row in zip(extensions * 0.79, figures["C"][grasp][side], strict=True):
            for theta, found in zip(np.arange(count) * 2.0 * np.pi / count, row, strict=True):
                v = np.array([np.cos(theta), np.sin(theta), 0.0])
                f = np.array([-np.sin(theta), np.cos(theta), 0.0])
                g = {"N": None, "F": -f, "V": v}[grasp]
                x_d = np.array([d, 0.0, 0.0])
                reached = g is None or np.linalg.norm(x_d - paper.HAND * g) < paper.ARM + paper.FOREARM
                assert np.isfinite(found) == reached
                if reached:
                    points = paper.geometric_posture(x_d, v, f, g, side == "left")
                    assert found == pytest.approx(planar_c(*points, x_d, v, f), rel=1e-9)
                    compared += 1
    assert compared >= 48
    by = figures["by_extension"][grasp]["left"]
    assert [row["reached"] for row in by] == np.isfinite(figures["C"][grasp]["left"]).sum(axis=1).tolist()


def test_the_grasps_are_compared_where_all_reach(limb):
    figures = c_grasp(limb, quiet, np.array([0.5, 0.9]), 36).figures
    C = np.stack([figures["C"][grasp]["left"] for grasp in GRASPS])
    common = np.isfinite(C).all(axis=0)
    best = [int(np.sum(C[i][common] == C.min(axis=0)[common])) for i in range(3)]
    compared = figures["tasks_that_all_three_reach"]
    assert compared["tasks"] == common.sum() == sum(best)
    assert list(compared["lowest_C"].values()) == best
    assert max(figures["mirrored_arms"].values()) < 1e-12
    straight = figures["elbow_straight"]
    assert [straight[grasp]["rank_of_Jp"] for grasp in "NFV"] == [2, 2, 3]
    # Hand across the stretched arm: shoulder, elbow and wrist each move it along the arm by its length.
    assert straight["V"]["f_JpJp_f_m2"] == pytest.approx(3 * paper.HAND**2)
    assert straight["V"]["v_JpJp_v_m2"] == pytest.approx((paper.ARM + paper.FOREARM) ** 2 + paper.FOREARM**2)


# Walking


def test_the_leg_is_where_its_joint_angles_put_it(limb):
    found = walking(limb, quiet).figures["snapshots"]
    assert [s["name"] for s in found] == [s.name for s in SNAPSHOTS]
    for s in found:
        knee, ankle, toe, R = paper.forward(np.array(s["q"]))
        for name, point in (("knee", knee), ("ankle", ankle), ("toe", toe)):
            assert np.allclose(point, s[name], atol=1e-7 if s["knee_bend_deg"] < 1.0 else 1e-12)
        assert s["v"] @ s["f"] == pytest.approx(0.0, abs=1e-15)
        assert np.allclose(R[:, 0], s["v"], atol=1e-12)
        assert np.linalg.norm(ankle) == pytest.approx(s["extension"] * 0.69)
        # The knee is before the line from hip to ankle, and nothing leaves the plane.
        assert np.cross(ankle, knee)[1] < 1e-7
        assert max(abs(s[name][1]) for name in ("knee", "ankle", "toe", "foot_velocity_m_s")) < 1e-12
        assert s["grasps"]["V"]["reached"]
    assert [s["knee_bend_deg"] < 1e-3 for s in found] == [False] * 4 + [True] * 2


def test_the_foot_moves_through_all_snapshots(limb):
    found = walking(limb, quiet).figures["snapshots"]
    swing, stance = found[1:4], found[5]
    assert all(s["foot_velocity_m_s"][0] > 0.0 for s in swing)
    assert stance["foot_velocity_m_s"][0] < 0.0
    for s in found:
        u = s["foot_velocity_m_s"] / np.linalg.norm(s["foot_velocity_m_s"])
        assert np.cos(np.deg2rad(s["angle_between_v_and_foot_velocity_deg"])) == pytest.approx(s["v"] @ u)


# Files and the command


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_every_experiment_leaves_its_files(limb, name, tmp_path):
    pytest.importorskip("matplotlib")
    shares = []
    few = () if name in ("c-grasp", "walking") else (12,)
    outcome = EXPERIMENTS[name](limb, shares.append, *few)
    written = files.write(tmp_path, name, limb, outcome)
    assert {path.name for path in tmp_path.iterdir()} == {f"{name}.{ending}" for ending in ("png", "svg", "json")}
    assert sorted(written) == sorted(tmp_path.iterdir())
    assert (tmp_path / f"{name}.png").read_bytes().startswith(b"\x89PNG")
    assert "<svg" in (tmp_path / f"{name}.svg").read_text()
    answer = json.loads((tmp_path / f"{name}.json").read_text())
    assert (answer["experiment"], answer["robot"], answer["seed"]) == (name, "human_arm", SEED)
    assert answer["versions"].keys() >= {"srs_ik", "numpy", "pinocchio"}
    assert answer["figures"]
    assert shares == sorted(shares)
    assert shares[-1] == pytest.approx(1.0)


def test_several_experiments_are_named_at_once(tmp_path):
    pytest.importorskip("matplotlib")
    done = run("reproduce", "walking", "c-grasp", "--out", str(tmp_path))
    assert done.exit_code == 0
    assert {path.stem for path in tmp_path.iterdir()} == {"walking", "c-grasp"}
    assert {"leg_angle_deg", "force_angle_deg"} <= json.loads((tmp_path / "walking.json").read_text())["figures"][
        "snapshots"
    ][0].keys()
    assert run("reproduce", "walking", "control", "--out", str(tmp_path)).exit_code == 2


@pytest.mark.parametrize("name", ["lr-arms", "arm-sphere", "ik-accuracy"])
def test_tasks_of_an_experiment_are_those_of_a_seed(limb, name, tmp_path):
    drawn = [
        json.dumps(
            plain({k: v for k, v in EXPERIMENTS[name](limb, quiet, 12, seed).figures.items() if "micro" not in k})
        )
        for seed in (SEED, SEED, 1)
    ]
    assert drawn[0] == drawn[1] != drawn[2]
    assert files.report(name, limb, EXPERIMENTS[name](limb, quiet, 12, 7))["seed"] == 7


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_axes_have_units(limb, name):
    pytest.importorskip("matplotlib")
    few = () if name in ("c-grasp", "walking") else (12,)
    labels = [
        getattr(axes, f"get_{direction}label")()
        for axes in EXPERIMENTS[name](limb, quiet, *few).draw().axes
        for direction in "xyz"
        if hasattr(axes, f"get_{direction}label")
    ]
    written = [label for label in labels if label]
    assert len(written) >= 2
    assert all(re.search(r"\((m|rad|deg|1|reaches)\)", label) for label in written)


def test_a_file_that_cannot_be_written_stays_as_it_was(limb, tmp_path, monkeypatch):
    pytest.importorskip("matplotlib")
    (tmp_path / "walking.png").write_text("old")

    def refuse(*paths):
        raise OSError("full")

    monkeypatch.setattr("srs_ik.system.writing._replace", refuse)
    with pytest.raises(OSError, match="full"):
        files.write(tmp_path, "walking", limb, walking(limb, quiet))
    assert [path.name for path in tmp_path.iterdir()] == ["walking.png"]
    assert (tmp_path / "walking.png").read_text() == "old"


def test_the_command_makes_the_folder_and_the_same_files_again(tmp_path):
    pytest.importorskip("matplotlib")
    out = tmp_path / "some" / "where"
    first = run("reproduce", "walking", "--out", str(out))
    assert first.exit_code == 0, first.stderr
    assert first.stdout.split() == [str(out / f"walking.{ending}") for ending in ("png", "svg", "json")]
    before = {path.name: path.read_bytes() for path in out.iterdir()}
    assert run("reproduce", "walking", "--out", str(out)).exit_code == 0
    assert {path.name: path.read_bytes() for path in out.iterdir()} == before


@pytest.mark.parametrize("name", arms.here("med7"))
def test_the_command_takes_another_robot_and_its_hand(name, tmp_path):
    pytest.importorskip("matplotlib")
    _, base, tip = arms.PLACES[name]
    words = ["reproduce", "walking", "--out", str(tmp_path), "--robot", str(arms.file_of(name))]
    words += ["--base", base, "--tip", tip]
    refused = run(*words)
    assert refused.exit_code == 2
    assert "hand" in refused.stderr
    assert list(tmp_path.iterdir()) == []
    assert run(*words, "--hand", "0", "0", "1", "1", "0", "0").exit_code == 0
    answer = json.loads((tmp_path / "walking.json").read_text())
    assert answer["robot"] == loading.load(arms.file_of(name), base=base, tip=tip).name
    assert all(s["position_error_m"] < 1e-9 for s in answer["figures"]["snapshots"])


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["walking"], "--out"),
        (["running", "--out", "{}"], "running"),
        (["walking", "--out", "{}/file"], "no folder"),
        (["walking", "--out", "{}/file/below"], "file"),
        (["walking", "--out", "{}", "--robot", "nobody"], "nobody"),
        (["walking", "--out", "{}", "--hand", "1", "0", "0", "1", "0", "0"], "parallel"),
    ],
)
def test_wrong_words_are_named_in_one_line(words, named, tmp_path):
    (tmp_path / "file").write_text("")
    result = run("reproduce", *(word.format(tmp_path) for word in words))
    assert result.exit_code == 2
    assert result.stdout == ""
    assert result.stderr.startswith("srs-ik: ")
    assert result.stderr.count("\n") == 1
    assert named in result.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_without_matplotlib_the_pip_command_is_given_before_anything_is_done(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.backend_bases", None)
    result = run("reproduce", "all", "--out", str(tmp_path / "new"))
    assert result.exit_code == 2
    assert install_command("plot") in result.stderr
    assert list(tmp_path.iterdir()) == []
