"""What is kept on disk of bodies: whatever stands there, and without a folder at all, questions are answered."""

import subprocess
import sys

import numpy as np
import pytest

import srs_ik
from srs_ik.collision.links import store

HOMELESS = """
import os, pwd

def nobody(user):
    raise KeyError(user)

os.environ.pop("HOME", None)
pwd.getpwuid = nobody

import numpy as np
import srs_ik
srs_ik.Scene().add_triangles("wedge", np.eye(4), 0.1 * np.eye(4, 3), [[0, 1, 2], [0, 1, 3], [1, 2, 3], [0, 2, 3]])
"""


def wedge():
    """Triangles whose covering spheres are looked for on disk."""
    srs_ik.Scene().add_triangles("wedge", np.eye(4), 0.1 * np.eye(4, 3), [[0, 1, 2], [0, 1, 3], [1, 2, 3], [0, 2, 3]])


def test_a_user_without_a_home_is_answered(monkeypatch):
    for name in ("SRS_IK_CACHE", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    subprocess.run([sys.executable, "-c", HOMELESS], check=True)


def test_a_relative_cache_home_is_no_folder(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("SRS_IK_CACHE", raising=False)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("XDG_CACHE_HOME", "cache")
    monkeypatch.setattr(store, "_memory", {})
    wedge()
    assert [each.name for each in tmp_path.iterdir()] == ["home"]


@pytest.mark.parametrize("rows", [10**12, 10**7])
def test_a_file_that_asks_for_gigabytes_is_as_good_as_none(rows, monkeypatch, tmp_path):
    monkeypatch.setenv("SRS_IK_CACHE", str(tmp_path))
    monkeypatch.setattr(store, "_memory", {})
    wedge()
    (kept,) = tmp_path.iterdir()
    with open(kept, "wb") as file:
        np.lib.format.write_array_header_1_0(file, {"descr": "<f8", "fortran_order": False, "shape": (rows, 4)})
        # A file of holes, where that is no larger than a disk.
        file.truncate(min(32 * rows + 1000, 2**30))
    key = kept.name.rpartition("-")[0]
    monkeypatch.setattr(store, "_memory", {})
    assert store.load(key) is None
    wedge()
    assert len(store.load(key)) > 0
