"""The benchmark runs to its end; what it measures is not judged here."""

import json
import runpy
import sys
from pathlib import Path

import pytest

import srs_ik
from srs_ik.robot import zoo

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def quick() -> dict:
    return runpy.run_path(str(ROOT / "benchmarks" / "quick.py"), run_name="quick")


def test_quick_prints_a_table_and_writes_the_same_figures(quick, tmp_path, capsys):
    path = tmp_path / "quick.json"
    quick["main"](["--poses", "3", "--no-start", "--json", str(path), "--markdown", str(tmp_path / "quick.md")])
    text = capsys.readouterr().out
    assert (tmp_path / "quick.md").read_text() == text
    calls = json.loads(path.read_text())["calls"]
    assert {call["robot"] for call in calls if call["package"].startswith("srs-ik ")} == {"iiwa14", "gen3"}
    # Pinocchio is always there.
    assert {call["robot"] for call in calls if call["package"].startswith("pin ")} == {"iiwa14", "gen3"}
    for call in calls:
        assert 0.0 < call["median_us"] <= call["p99_us"]
        assert f"| {call['robot']} | {call['package']} | {call['call']} | {call['median_us']:.2f} |" in text
        assert call["error"] is None or call["error"] < 1e-5


def test_quick_refuses_to_measure_nothing(quick, capsys):
    with pytest.raises(SystemExit) as left:
        quick["main"](["--poses", "0"])
    assert left.value.code == 2
    assert "--poses" in capsys.readouterr().err


def test_the_gate_tells_slow_from_fast(monkeypatch, capsys):
    gate = runpy.run_path(str(ROOT / "benchmarks" / "gate.py"), run_name="gate")
    monkeypatch.setitem(gate["main"].__globals__, "ROUNDS", 1)
    for bound, status in ((1e9, 0), (0.0, 1)):
        monkeypatch.setitem(gate["main"].__globals__, "BOUNDS", dict.fromkeys(gate["BOUNDS"], bound))
        assert gate["main"]() == status
    assert len(capsys.readouterr().out.splitlines()) == 2 * len(gate["BOUNDS"])


def test_ellipsoids_prints_times_and_differences(capsys):
    pytest.importorskip("pycapacity")
    bench = runpy.run_path(str(ROOT / "benchmarks" / "ellipsoids.py"), run_name="ellipsoids")
    bench["main"](["--postures", "2"])
    rows = [line.split(" | ") for line in capsys.readouterr().out.splitlines() if line.startswith("| ")]
    times = [row for row in rows if len(row) == 2][1:]
    assert len(times) == 7
    assert all(int(row[1].rstrip(" |")) > 0 for row in times)
    random, singular = (row for row in rows if len(row) == 5 and row[0] != "| postures")
    for row in (random, singular):
        assert max(float(row[1]), float(row[3])) < 1e-9
    with pytest.raises(SystemExit):
        bench["main"](["--postures", "0"])


def test_the_benchmark_of_tasks_prints_a_table(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["task.py", "--tasks", "2", "--batch", "40"])
    runpy.run_path(str(ROOT / "benchmarks" / "task.py"), run_name="__main__")
    lines = capsys.readouterr().out.splitlines()
    rows = [line.split("|") for line in lines[2:]]
    assert {row[1].strip() for row in rows} == {"human_arm", "iiwa14", "gen3"}
    assert all(float(row[3]) > 0.0 and float(row[4]) > 0.0 for row in rows)


def test_the_benchmark_of_the_redundancy_prints_what_does_not_hold(monkeypatch, capsys):
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    bench = runpy.run_path(str(ROOT / "benchmarks" / "redundancy.py"), run_name="redundancy")
    bench["main"](["--scale", "0.01", "--parts", "intervals"])
    rows = [line.split("|") for line in capsys.readouterr().out.splitlines() if line.startswith("| `")]
    assert {row[1].strip(" `") for row in rows} >= {"iiwa14", "human_arm"}
    for row in rows:
        assert int(row[2]) > 0
        assert int(row[4]) > 0
        assert int(row[5]) == 0
    with pytest.raises(SystemExit):
        bench["main"](["--scale", "0"])


@pytest.mark.parametrize(
    ("name", "figures"),
    [
        ("singular", "4 seeds, 0 farther than a known posture (1e-6 rad), the worst by "),
        ("known", "4 known postures (singular), 0 in no interval, 0 hidden by rounding; "),
        ("closest", "4 far targets, 0 bettered in both errors (1e-4 m and rad), at most by "),
        ("free_axis", "8 questions with a free axis, 0 missed, off by "),
    ],
)
def test_a_long_run_says_one_line(monkeypatch, capsys, name, figures):
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    bench = runpy.run_path(str(ROOT / "benchmarks" / f"{name}.py"), run_name=name)
    for robot in ("iiwa14", "random"):
        with pytest.raises(SystemExit) as left:
            bench["main"](["--count", "4", "--seed", "3", "--robot", robot])
        assert left.value.code == 0
        said = capsys.readouterr()
        assert said.out.startswith(f"{robot}, seed 3: {figures}")
        assert said.out.count("\n") == 1
        assert not said.err
    with pytest.raises(SystemExit) as left:
        bench["main"](["--count", "0"])
    assert left.value.code == 2


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["known", "--poses", "60", "--kind", "cross", "--count", "1"], "seeded: 0 breaks, 0 larger"),
        (["brute", "--angles", "120", "--count", "2"], "0 with more breaks"),
        (["broken", "--angles", "120", "--count", "1"], "0 with more breaks"),
        # Steps just short enough to be continuous.
        (["broken", "--angles", "500", "--count", "1", "--seed", "1", "--robot", "human_left"], "0 with more breaks"),
        (["broken", "--angles", "500", "--count", "1", "--seed", "7", "--robot", "human_left"], "0 with more breaks"),
    ],
)
def test_the_benchmark_of_paths_prints_one_line(monkeypatch, capsys, words, told):
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    bench = runpy.run_path(str(ROOT / "benchmarks" / "path_truth.py"), run_name="path_truth")
    assert bench["main"]([words[0], "--robot", "iiwa14", *words[1:]]) == 0
    (line,) = capsys.readouterr().out.splitlines()
    robot = "human_left" if "human_left" in words else "iiwa14"
    assert line.startswith(f"{robot} {words[0] if words[0] != 'known' else 'cross'}")
    assert told in line


@pytest.fixture(scope="module")
def no_false_ok() -> dict:
    sys.path.append(str(ROOT / "benchmarks"))
    try:
        return runpy.run_path(str(ROOT / "benchmarks" / "no_false_ok.py"), run_name="no_false_ok")
    finally:
        sys.path.pop()


def test_a_thousand_poses_have_no_false_answer(no_false_ok, monkeypatch, capsys):
    monkeypatch.setitem(no_false_ok["main"].__globals__, "CHUNK", 20)
    assert no_false_ok["main"](["--count", "1000"]) == 0
    line = capsys.readouterr().out
    assert line.startswith("1,000 poses, ")
    assert "0 not finite, 0 outside limits, 0 false OK, 0 false errors, 0 missed inside" in line


def test_false_answers_are_counted(no_false_ok, monkeypatch, capsys):
    """An arm that is measured on the file of another one has postures for other poses."""
    measured = no_false_ok["Untouched"](zoo.card("gen3").urdf, srs_ik.load("gen3"))
    lying = no_false_ok["Subject"]("lying", srs_ik.load("iiwa14"), measured)
    monkeypatch.setitem(no_false_ok["main"].__globals__, "CHUNK", 20)
    monkeypatch.setitem(no_false_ok["main"].__globals__, "subjects", lambda files, out: [lying])
    assert no_false_ok["main"](["--count", "400"]) == 1
    out = capsys.readouterr().out
    for kind in ("false OK", "false errors", "missed inside"):
        assert f"{kind}: lying, poses " in out
        assert f" 0 {kind}" not in out
