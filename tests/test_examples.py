"""The examples run to their end, and what they print is what they promise."""

import base64
import io
import re
import runpy
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
EXAMPLES = sorted(path.name for path in (ROOT / "examples").glob("*.py"))


@pytest.fixture
def run_example(monkeypatch, capsys):
    def run(name: str, *arguments: str) -> str:
        monkeypatch.setattr(sys, "argv", [name, *arguments])
        runpy.run_path(str(ROOT / "examples" / name), run_name="__main__")
        return capsys.readouterr().out

    return run


def test_the_examples_are_there():
    assert {"any_urdf.py", "gen3.py", "human_arm.py", "iiwa14.py"} <= set(EXAMPLES)


@pytest.mark.parametrize("name", EXAMPLES)
def test_example_runs_and_its_errors_by_pinocchio_are_rounding(run_example, name):
    text = run_example(name)
    checked = [
        float(x)
        for line in text.splitlines()
        if "inocchio" in line or "off by" in line
        for x in re.findall(r"([\d.]+e[+-]\d+) (?:m|rad)\b", line)
    ]
    assert checked
    assert max(checked) < 1e-9


@pytest.mark.parametrize("name", EXAMPLES)
def test_example_says_how_it_is_run(name):
    assert f"Run: python examples/{name}" in (ROOT / "examples" / name).read_text()


def test_the_line_of_the_iiwa_is_solved_to_its_end(run_example):
    assert "1000 of 1000 poses solved" in run_example("iiwa14.py")


def test_a_file_can_be_named(run_example):
    text = run_example("any_urdf.py", str(ROOT / "robots" / "human_arm" / "human_arm.urdf"))
    assert "exact S-R-S limb with XYZ wrist" in text


def test_a_file_that_is_not_there_is_named(run_example, capsys):
    with pytest.raises(SystemExit) as left:
        run_example("any_urdf.py", "no/such/file.urdf")
    assert left.value.code == 2
    assert "no/such/file.urdf" in capsys.readouterr().err


def test_a_kernel_runs_the_notebook_and_shows_its_pictures(tmp_path):
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    image = pytest.importorskip("matplotlib.image")
    notebook = nbformat.read(ROOT / "examples" / "tour.ipynb", as_version=nbformat.NO_CONVERT)
    nbformat.validate(notebook)
    assert (notebook.nbformat, notebook.nbformat_minor) == (4, 5)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    # Outputs would be figures that nobody measures again.
    assert not any(cell.outputs or cell.execution_count for cell in cells)
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": tmp_path}}).execute()

    outputs = [output for cell in cells for output in cell.outputs]
    said = "".join(output.text for output in outputs if output.output_type == "stream")
    assert "iiwa14 from" in said
    assert "OK" in said
    assert "continuous: True" in said
    shown = [output.data for output in outputs if output.output_type == "execute_result"]
    pictures = [base64.b64decode(data["image/png"]) for data in shown if "image/png" in data]
    assert len(pictures) == 2
    for picture in pictures:
        height, width, _ = image.imread(io.BytesIO(picture)).shape
        assert width > 700
        assert height > 300
    frames = [data["text/html"] for data in shown if "text/html" in data]
    assert len(frames) == 1
    assert frames[0].startswith("<iframe")
    assert (tmp_path / "tour.html").stat().st_size > 100_000
