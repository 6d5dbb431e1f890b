"""The README shows a whole example early, and the documentation leaves out no public name."""

import re
import subprocess
import sys
from pathlib import Path

import srs_ik
from srs_ik import errors

ROOT = Path(__file__).resolve().parents[1]


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


def test_rooms_that_the_interface_names_are_there_after_one_import():
    """In a process of its own: here, other tests have imported what they need."""
    page = (ROOT / "docs" / "api.md").read_text()
    rooms = re.findall(r"^::: (srs_ik\.control\.[a-z_]+)$", page, re.MULTILINE)
    assert len(rooms) == 3
    script = "import srs_ik\n" + "\n".join(rooms)
    assert subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False).stderr == ""
