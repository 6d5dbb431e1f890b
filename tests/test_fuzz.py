"""A seeded part of the damage that tests/fuzz.py does in great number, and that it would notice a failure."""

from pathlib import Path

import pytest
from fuzz import Worker, corpus, trial
from mutations import mutated
from robot_files import SHARED

import srs_ik
from srs_ik.robot import zoo

FILES = corpus([SHARED])


@pytest.mark.parametrize("first", range(0, 200, 25))
def test_damaged_files_are_refused_or_solved(first, tmp_path):
    for seed in range(first, first + 25):
        sample = FILES[seed % len(FILES)]
        path = tmp_path / f"damaged{sample.suffix}"
        assert trial(mutated(sample.text, seed), path) in ("refused", "no limb", "solved"), f"seed {seed}"


def test_whole_files_are_solved(tmp_path):
    for sample in corpus([]):
        assert trial(sample.text.encode(), tmp_path / f"whole{sample.suffix}") == "solved"


def test_mutations_depend_on_the_seed_alone():
    text = zoo.card("iiwa14").urdf.read_text()
    assert len({mutated(text, seed) for seed in range(50)}) > 45
    assert all(mutated(text, seed) == mutated(text, seed) for seed in range(50))


def test_a_false_answer_would_be_noticed(monkeypatch, tmp_path):
    verify = srs_ik.Arm.verify
    monkeypatch.setattr(srs_ik.Arm, "verify", lambda arm, pose, q: verify(arm, pose, q + 0.01))
    with pytest.raises(AssertionError, match="says OK and is not"):
        trial(zoo.card("iiwa14").urdf.read_bytes(), tmp_path / "whole.urdf")


def test_the_end_of_the_watched_process_would_be_noticed(tmp_path: Path):
    worker = Worker([], tmp_path / "fuzz.urdf")
    assert worker.ask(1).split(" ", 1)[1] in ("refused", "no limb", "solved")
    worker.process.kill()
    assert worker.line(30.0) == ""
    worker.stop()
