"""Paths of an arm whose joints have many turns: strips of all of them are kept, however many postures these are."""

import runpy
import sys
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"


@pytest.fixture(scope="module")
def arm():
    made = runpy.run_path(str(BENCHMARKS / "subjects.py"), run_name="subjects")
    return next(islice(made["random_arms"](np.random.default_rng([98000, 6]), 0.0, 0.0), 37, None))


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "number"), [("limits", 98003), ("cross", 98003), ("limits", 98001)])
def test_a_known_motion_in_many_turns_is_never_better(arm, kind, number, monkeypatch):
    monkeypatch.setattr(sys, "path", [str(BENCHMARKS), *sys.path])
    told = runpy.run_path(str(BENCHMARKS / "path_truth.py"), run_name="path_truth")
    known = told["known_motion"](arm, told["generator"](arm, kind, number), kind, 200)
    path = arm.solve_path(told["poses_of"](arm, known), seed=known[0])
    assert path, path.breaks
    assert path.value <= (np.diff(known, axis=0) ** 2).sum() * (1.0 + 1e-6)
