"""The snippets of the README and the start page run word for word, in the order in which a reader meets them."""

import contextlib
import io
import re
from pathlib import Path

import numpy as np
import pytest

import srs_ik
from srs_ik import errors

ROOT = Path(__file__).resolve().parents[1]


def snippets(path: str) -> list[str]:
    return re.findall(r"```python\n(.+?)```", (ROOT / path).read_text(), re.DOTALL)


@pytest.mark.parametrize("path", ["README.md", "docs/index.md"])
def test_snippets_run_and_solve(path, monkeypatch):
    monkeypatch.chdir(ROOT)
    assert snippets(path)
    names: dict = {}
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        for snippet in snippets(path):
            exec(compile(snippet, path, "exec"), names)
    assert printed.getvalue()
    assert names["solution"]
    reached = names["arm"].forward_kinematics(names["solution"].q)
    assert np.allclose(reached.homogeneous, names["pose"].homogeneous, rtol=0.0, atol=1e-11)


def test_snippets_of_the_ellipsoids_run_and_draw(monkeypatch, tmp_path):
    pytest.importorskip("matplotlib")
    pytest.importorskip("pycapacity")
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    with contextlib.redirect_stdout(io.StringIO()):
        for snippet in snippets("docs/ellipsoids.md"):
            exec(compile(snippet, "docs/ellipsoids.md", "exec"), names)
    assert names["velocity"].rank == names["strong"].rank == 3
    assert {path.name for path in tmp_path.iterdir()} == {"ellipsoids.png", "arm_angle.png", "intervals.png"}


def test_the_first_snippet_is_complete_by_line_30():
    lines = (ROOT / "README.md").read_text().splitlines()
    opening = lines.index("```python")
    assert lines.index("```", opening) < 30


def test_the_documentation_has_every_public_name():
    page = (ROOT / "docs" / "api.md").read_text()
    documented = set(re.findall(r"^::: srs_ik\.[\w.]+\.(\w+)$", page, re.MULTILINE))
    if "::: srs_ik.errors\n" in page:
        documented |= {name for name, value in vars(errors).items() if isinstance(value, type)}
    assert [name for name in srs_ik.__all__ if name not in documented] == []
