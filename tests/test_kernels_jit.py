"""Compiled kernels on disk: a change in any file of theirs is noticed, and nothing else is compiled anew."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from srs_ik.kernels import jit, sources
from srs_ik.kernels.disk import KernelCache
from srs_ik.kernels.entries import pose as entries

FOLDER = Path(jit.__file__).parent

INNER = """
from {package}.jit import kernel

@kernel
def figure(x):
    return x + {constant}
"""
OUTER = """
from {package}.inner import figure
from {package}.jit import entry

@entry
def answer(x):
    return figure(x)
"""
RUN = "from {package}.outer import answer; print(answer(1.0), sum(answer.stats.cache_hits.values()))"


ENTRIES = sorted(path.name for path in (FOLDER / "entries").glob("*.py") if path.name != "table.py")


def digests_of(folder: Path) -> dict[str, str]:
    """What a copy of the folder says of each file of entries; what they import stays what it was."""
    sources.digest.cache_clear()
    sources._of_content.cache_clear()
    return {name: sources.digest(folder / "entries" / name, folder) for name in ENTRIES}


def needed_by(file: Path) -> set[Path]:
    """Kernel files that a file needs, by Python's own import in a process of its own."""
    name = ".".join(file.relative_to(FOLDER.parent.parent).with_suffix("").parts)
    program = (
        f"import sys, {name}\n"
        "print(*(m.__file__ for n, m in sys.modules.items() if n.startswith('srs_ik.kernels')), sep='\\n')"
    )
    # Some are read where Numba compiles alone.
    environment = {**os.environ, "SRS_IK_JIT": "1"}
    command = [sys.executable, "-c", program]
    printed = subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout
    return {Path(line) for line in printed.split() if Path(line).name != "__init__.py"}


@pytest.fixture
def copied(tmp_path):
    folder = tmp_path / "kernels"
    shutil.copytree(FOLDER, folder, ignore=shutil.ignore_patterns("__pycache__"))
    return folder


def test_an_unchanged_copy_has_the_same_digests(copied):
    assert digests_of(copied) == {name: jit.source_digest(FOLDER / "entries" / name) for name in ENTRIES}


def test_a_change_in_any_needed_file_changes_the_digests_of_what_needs_it_and_no_others(copied):
    needed = {name: needed_by(FOLDER / "entries" / name) for name in ENTRIES if name != "__init__.py"}
    assert all(FOLDER / "entries" / name in files for name, files in needed.items())
    before = digests_of(copied)
    for file in FOLDER.rglob("*.py"):
        if file.name in ("__init__.py", "disk.py", "sources.py"):
            continue
        path = copied / file.relative_to(FOLDER)
        content = path.read_text()
        path.write_text(content + "\n# changed\n")
        now = digests_of(copied)
        path.write_text(content)
        for name, files in needed.items():
            assert (now[name] != before[name]) == (file in files), (name, file)


def test_files_that_are_no_source_do_not_count(copied):
    before = digests_of(copied)
    (copied / "notes.txt").write_text("nothing")
    (copied / "__pycache__").mkdir()
    (copied / "__pycache__" / "vectors.cpython-311.pyc").write_bytes(b"x")
    assert digests_of(copied) == before


@pytest.mark.jit
def test_entry_points_are_cached_under_the_digest():
    entry_points = [f for f in vars(entries).values() if isinstance(getattr(f, "_cache", None), KernelCache)]
    assert entries.solve in entry_points
    for function in entry_points:
        assert function._cache._stamp() == jit.source_digest(Path(entries.__file__))


def test_a_changed_callee_is_noticed_and_an_unchanged_one_is_not_compiled_again(tmp_path):
    """Numba itself watches only the file of the cached function."""
    package = "small_kernels"
    folder = tmp_path / package
    folder.mkdir()
    (folder / "__init__.py").write_text("")
    shutil.copy(FOLDER / "jit.py", folder / "jit.py")
    (folder / "outer.py").write_text(OUTER.format(package=package))
    environment = {
        **os.environ,
        "NUMBA_CACHE_DIR": str(tmp_path / "cache"),
        "PYTHONPATH": f"{tmp_path}{os.pathsep}{FOLDER.parent.parent}",
        "PYTHONDONTWRITEBYTECODE": "1",
        "SRS_IK_JIT": "1",
    }

    def run(constant: float) -> list[str]:
        (folder / "inner.py").write_text(INNER.format(package=package, constant=constant))
        command = [sys.executable, "-c", RUN.format(package=package)]
        return subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout.split()

    assert run(1.0) == ["2.0", "0"]
    assert run(1.0) == ["2.0", "1"]
    assert run(5.0) == ["6.0", "0"]
    assert run(5.0) == ["6.0", "1"]
