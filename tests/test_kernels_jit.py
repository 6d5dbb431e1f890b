"""Compiled kernels on disk: a change in any file of theirs is noticed, and nothing else is compiled anew."""

import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from srs_ik.kernels import jit
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


def digest_of(folder: Path) -> str:
    """What a copy of the folder says of itself."""
    spec = importlib.util.spec_from_file_location("copied_jit", folder / "jit.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.source_digest()


@pytest.fixture
def copied(tmp_path):
    folder = tmp_path / "kernels"
    shutil.copytree(FOLDER, folder, ignore=shutil.ignore_patterns("__pycache__"))
    return folder


def test_an_unchanged_copy_has_the_same_digest(copied):
    assert digest_of(copied) == jit.source_digest()


@pytest.mark.parametrize("file", sorted(path.relative_to(FOLDER).as_posix() for path in FOLDER.rglob("*.py")))
def test_a_change_in_any_file_changes_the_digest(copied, file):
    path = copied / file
    path.write_text(path.read_text() + "\n# changed\n")
    assert digest_of(copied) != jit.source_digest()


def test_new_renamed_and_missing_files_change_the_digest(copied):
    seen = {jit.source_digest()}
    (copied / "another.py").write_text("")
    seen.add(digest_of(copied))
    (copied / "another.py").rename(copied / "other.py")
    seen.add(digest_of(copied))
    (copied / "other.py").rename(copied / "limb" / "other.py")
    seen.add(digest_of(copied))
    (copied / "limb" / "other.py").unlink()
    (copied / "algebra" / "vectors.py").unlink()
    seen.add(digest_of(copied))
    assert len(seen) == 5


def test_files_that_are_no_source_do_not_count(copied):
    (copied / "notes.txt").write_text("nothing")
    (copied / "__pycache__").mkdir()
    (copied / "__pycache__" / "vectors.cpython-311.pyc").write_bytes(b"x")
    assert digest_of(copied) == jit.source_digest()


def test_entry_points_are_cached_under_the_digest():
    entry_points = [f for f in vars(entries).values() if isinstance(getattr(f, "_cache", None), KernelCache)]
    assert entries.solve in entry_points
    for function in entry_points:
        assert function._cache._stamp() == jit.source_digest()


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
    }

    def run(constant: float) -> list[str]:
        (folder / "inner.py").write_text(INNER.format(package=package, constant=constant))
        command = [sys.executable, "-c", RUN.format(package=package)]
        return subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout.split()

    assert run(1.0) == ["2.0", "0"]
    assert run(1.0) == ["2.0", "1"]
    assert run(5.0) == ["6.0", "0"]
    assert run(5.0) == ["6.0", "1"]
