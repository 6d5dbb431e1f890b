"""How all tests run: profiles of Hypothesis, and the marks that follow from what a test needs."""

import os
import random
import runpy
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import arms
import numpy as np
import pinocchio as pin
import pytest
from hypothesis import HealthCheck, settings
from robot_files import REAL

from srs_ik.kernels import jit

# The same examples in every run: a failure is one of the code. HYPOTHESIS_PROFILE=thorough looks for new ones.
_COMMON = {
    "deadline": None,  # the first example may compile
    "database": None,
    "suppress_health_check": [HealthCheck.too_slow, HealthCheck.filter_too_much],
}
settings.register_profile("fast", max_examples=25, derandomize=True, **_COMMON)
settings.register_profile("ci", max_examples=60, derandomize=True, **_COMMON)
settings.register_profile("thorough", max_examples=1000, derandomize=False, print_blob=True, **_COMMON)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "fast"))

SLOW = {
    "test_adapter",
    "test_bench",
    "test_benchmarks",
    "test_cli_preview",
    "test_control_experiments",
    "test_copies",
    "test_examples",
    "test_experiments",
    "test_following_preview",
    "test_fuzz",
    "test_map_engine",
    "test_kernels_disk",
    "test_kernels_eight",
    "test_kernels_jit",
    "test_named_robots",
    "test_path",
    "test_preview_browser",
    "test_preview_server",
    "test_printed",
    "test_snippets",
    "test_waiting",
    "test_what_holds",
}
"""Modules whose tests start processes, compile in them, or search for long."""

NUMBA = {
    "test_crossing",
    "test_curves",
    "test_kernels_algebra",
    "test_kernels_bounded",
    "test_kernels_eight",
    "test_kernels_newton",
    "test_kernels_noise",
    "test_kernels_trend",
    "test_lanes",
}
"""Modules that have Numba compile kernels one by one."""

BENCHMARKS = Path(__file__).resolve().parents[1] / "benchmarks"

_REAL = {*REAL, *arms.REAL}


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    met = set()
    for item in items:
        parameters = item.callspec.params.values() if hasattr(item, "callspec") else ()
        if any(isinstance(value, str) and value in _REAL for value in parameters):
            item.add_marker(pytest.mark.files)
        if "browser" in item.fixturenames or item.path.stem in ("test_following_preview", "test_preview_browser"):
            item.add_marker(pytest.mark.browser)
        if item.path.stem in SLOW or "installed" in item.fixturenames:
            item.add_marker(pytest.mark.slow)
        test = item.path, getattr(item, "originalname", item.name)
        if test not in met and not item.get_closest_marker("slow"):
            item.add_marker(pytest.mark.fast)
        met.add(test)
        if item.path.stem in NUMBA:
            item.add_marker(pytest.mark.numba)
        if jit.AHEAD and not jit.BY_NUMBA and item.get_closest_marker("numba"):
            item.add_marker(pytest.mark.skip(reason="kernels are compiled ahead: SRS_IK_JIT=inner pytest -m numba"))
        if jit.AHEAD and item.get_closest_marker("jit"):
            item.add_marker(pytest.mark.skip(reason="entries are compiled ahead: SRS_IK_JIT=1 pytest -m jit"))


@pytest.fixture(scope="module")
def bench() -> Iterator[dict[str, Any]]:
    """What `benchmarks/known.py` asks of known postures and of intervals."""
    sys.path.insert(0, str(BENCHMARKS))
    yield runpy.run_path(str(BENCHMARKS / "known.py"), run_name="known")
    sys.path.remove(str(BENCHMARKS))


@pytest.fixture(autouse=True)
def _same_random_numbers() -> None:
    """A test draws the same numbers alone, in the whole suite and on each of its processes."""
    pin.seed(0)
    random.seed(0)
    np.random.seed(0)  # noqa: NPY002
