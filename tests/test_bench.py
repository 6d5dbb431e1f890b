"""`srs_ik.bench` and `srs-ik bench`: what is measured is right; how long it takes is not judged here."""

import json
import subprocess
import sys

import arms
import numpy as np
import pytest
from command_line import run

from srs_ik.bench import growth
from srs_ik.bench.own import BATCH, batches, single_calls
from srs_ik.bench.report import Report, machine
from srs_ik.bench.timing import measure, time_calls
from srs_ik.bench.work import SEED_SPREAD, Work

HEAVY = ("meshcat", "typer", "scipy.optimize", "trimesh", "matplotlib", "rich", "yourdfpy")
"""Modules that whoever imports the package and solves does not wait for; the last two are those of loading."""


def modules_after(program):
    program += "; import sys; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True)
    return set(done.stdout.split())


def test_import_brings_nothing_heavy():
    loaded = modules_after("import srs_ik")
    assert loaded.isdisjoint(HEAVY)
    assert loaded.isdisjoint({"numpy", "numba", "pinocchio"})


def test_load_and_solve_bring_nothing_heavy():
    program = "import srs_ik; a = srs_ik.load('iiwa14'); T = a.forward_kinematics([0.1] * 7); assert a.solve(T)"
    loaded = modules_after(program + "; a.solve_batch([T, T]); a.intervals_batch([T, T])")
    assert loaded.isdisjoint(HEAVY[:5])
    assert "pinocchio" in loaded


def test_times_leave_out_the_first_calls():
    seen = []
    times, answers = time_calls(lambda x: seen.append(x) or x, [(1,), (2,)])
    assert seen == [1, 2, 1, 2]
    assert answers == [1, 2]
    assert (times > 0.0).all()


@pytest.mark.parametrize("name", ["iiwa14", "gen3"])
def test_work_is_what_it_says(name):
    arm = arms.load(name)
    work = Work.of(arm, 20)
    assert (np.abs(work.seeds - work.q) <= SEED_SPREAD).all()
    for values in (work.q, work.seeds):
        assert (values >= arm.lower).all()
        assert (values <= arm.upper).all()
    for q, pose, angle in zip(work.q, work.poses, work.arm_angles, strict=True):
        assert np.abs(arms.forward(name)(q).homogeneous - pose).max() < 1e-12
        assert arm.arm_angle(q) == angle


def test_answers_are_judged():
    arm = arms.load("iiwa14")
    work = Work.of(arm, 4)
    outside, moved = work.q[1] + [9.0, 0, 0, 0, 0, 0, 0], work.q[2] + [0, 0, 0, 0, 0, 0, 1e-3]
    answers = dict(enumerate([[work.q[0]], [outside, work.q[1]], [moved], []]))
    numbered = [(pose, i) for i, pose in enumerate(work.poses)]
    near = work.q, work.q
    row = measure(arm, "srs-ik", "made up", lambda pose, i: answers[i], numbered[2:], list, (work.q[2:], work.q[2:]))
    assert (row.answered, row.poses, row.inside, row.farther, row.found) == (1, 2, 1, 1, 1)
    assert row.error == pytest.approx(1e-3)
    row = measure(arm, "srs-ik", "made up", lambda pose, i: answers[i], numbered[:2], list)
    assert (row.answered, row.inside, row.farther, row.found) == (2, 2, None, 3)
    row = measure(arm, "srs-ik", "made up", lambda pose, i: answers[i], numbered, None)
    assert (row.answered, row.error, row.inside, row.found) == (3, None, None, 4)
    row = measure(arm, "srs-ik", "made up", lambda pose, i: [work.q[i]], numbered, list, near)
    assert (row.farther, row.error < 1e-14) == (0, True)


def test_every_posture_is_found_and_the_report_shows_every_figure():
    arm = arms.load("iiwa14")
    work = Work.of(arm, 6)
    report = Report(machine(), 0.25, list(single_calls(arm, work)), list(batches(arm, work)))
    report.growth = [growth.Growth("iiwa14", 10, 2, 1.5), growth.Growth("iiwa14", 10**6, 2, 1.25, 104.0, 105.0)]
    report.start = {"import_s": 0.125, "first_answer_cold_s": 9.5, "first_answer_warm_s": 0.75}
    text = report.markdown()
    for row in report.calls:
        assert (row.answered, row.poses) == (6, 6)
        assert row.error is None or row.error < 1e-11
        assert row.farther in (None, 0)
        assert f"| {row.call} | {row.median_us:.2f} | {row.p99_us:.2f} | 6 of 6 |" in text
    for row in report.batches:
        assert 0 < row.poses <= BATCH
        assert row.poses % 6 == 0
        assert f"| {row.call} | {row.poses:,} | {row.one_thread_us:.3f} | {row.two_threads_us:.3f} |" in text
    for line in ("| iiwa14 | 10 | 2 | 1.500 |  |  |", "| iiwa14 | 1,000,000 | 2 | 1.250 | 104 | 105 |", "| 9.50 |"):
        assert line in text
    assert json.loads(json.dumps(report.as_dict()))["floor_us"] == 0.25


def test_growth_measures_each_size_in_its_own_process(monkeypatch):
    rows = list(growth.growth("iiwa14", 10))
    assert [(row.poses, row.threads) for row in rows] == [(1, 1), (1, 2), (10, 1), (10, 2)]
    assert all(row.us > 0.0 and row.memory_mb is None for row in rows)
    monkeypatch.setattr(growth, "LONG", 20_000)
    figures = growth.one_size("iiwa14", 20_000, 2)
    assert figures["us"] > 0.0
    if sys.platform == "linux":
        assert figures["answers_mb"] == pytest.approx(20_000 * 104e-6)
        assert figures["memory_mb"] < 2.0 * figures["answers_mb"] + 10.0


def test_the_command_prints_tables_or_json(tmp_path):
    path = tmp_path / "bench.json"
    done = run("bench", "human_arm", "--poses", "2", "--out", str(path))
    assert done.exit_code == 0
    assert "solve_batch, seeds" in done.stdout
    figures = json.loads(path.read_text())
    assert {row["robot"] for row in figures["calls"]} == {"human_arm"}
    done = run("bench", "human_arm", "--poses", "2", "--json")
    assert json.loads(done.stdout).keys() == figures.keys()


@pytest.mark.parametrize("words", [["--poses", "0"], ["--poses", "x"], ["--growth", "-1"], ["no_such_robot"]])
def test_wrong_input_is_one_line(words):
    done = run("bench", *words)
    assert done.exit_code == 2
    assert len(done.stderr.splitlines()) == 1
