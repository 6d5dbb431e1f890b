"""What comes with the package for the bodies of the built-in arms, and the word to whoever waits for others."""

import subprocess
import sys
import time

import numpy as np
import pytest
from built_in_bodies import ARMS

import srs_ik
from srs_ik.collision.links import store
from srs_ik.system import waiting

ASKED = """
import sys
import numpy as np
import srs_ik
from srs_ik.collision.links import store

found = []
store.keep = lambda key, rows: found.append(key)
on_a_base = srs_ik.pose_from_xyz_rpy([0.1, 0.2, 0.3], [0.4, 0.5, 0.6])
for name in sys.argv[1:]:
    arm = srs_ik.load(name)
    pose = arm.forward_kinematics(0.5 * (np.clip(arm.lower, -3, 3) + np.clip(arm.upper, -3, 3)) + 0.3)
    for each in (arm, arm.with_base(on_a_base)):
        each.solve(pose, scene=srs_ik.Scene(exact=True))
        each.pairs
print(len(found))
"""


def test_nothing_is_looked_for_of_the_built_in_arms(monkeypatch):
    monkeypatch.setenv("SRS_IK_CACHE", "")
    asked = subprocess.run([sys.executable, "-c", ASKED, *ARMS], capture_output=True, text=True, check=True)
    assert asked.stdout.split() == ["0"], "run python tests/built_in_bodies.py"


@pytest.mark.parametrize("name", ["human_arm"])
def test_what_comes_with_the_package_is_what_is_found(name, monkeypatch):
    monkeypatch.setenv("SRS_IK_CACHE", "")
    known = srs_ik.load(name)
    monkeypatch.setattr(store, "_built_in", dict)
    monkeypatch.setattr(store, "_memory", {})
    found = srs_ik.load(name)
    assert store._memory == {}
    for own, body in zip(found.bodies, known.bodies, strict=True):
        np.testing.assert_allclose(own.spheres, body.spheres, atol=1e-9)
    assert store._memory != {}
    assert found.pairs == known.pairs


class Terminal(list):
    def isatty(self):
        return True

    def write(self, text):
        self.append(text)

    def flush(self):
        pass


@pytest.mark.parametrize(("patience", "said"), [(0.0, 1), (60.0, 0)])
def test_who_waits_at_a_terminal_is_told_why(monkeypatch, patience, said):
    terminal = Terminal()
    monkeypatch.setenv("SRS_IK_CACHE", "")
    monkeypatch.setattr(waiting, "PATIENCE", patience)
    monkeypatch.setattr(sys, "stderr", terminal)
    arm = srs_ik.load("human_arm").with_object("ball", np.eye(4), radius=0.0371)
    assert arm.bodies
    assert "".join(terminal).count("srs_ik: human_arm: spheres that cover its links") == said


class Notebook(Terminal):
    """As `ipykernel.iostream.OutStream`."""

    __module__ = "ipykernel.iostream"

    def isatty(self):
        return False


def test_who_waits_in_a_notebook_is_told_and_so_is_a_log(monkeypatch, caplog):
    cell = Notebook()
    monkeypatch.setattr(sys, "stderr", cell)
    caplog.set_level("INFO", "srs_ik")
    for patience in (0.0, 60.0):
        monkeypatch.setattr(waiting, "PATIENCE", patience)
        with waiting.said_if_long("spheres are found once"):
            for _ in range(200):
                if patience or "".join(cell).endswith("\n"):
                    break
                time.sleep(0.01)
    assert "".join(cell) == "srs_ik: spheres are found once\n"
    assert [(each.name, each.levelname, each.message) for each in caplog.records] == [
        ("srs_ik", "INFO", "spheres are found once")
    ]


def test_nothing_is_said_where_no_terminal_is(capsys, monkeypatch):
    monkeypatch.setattr(waiting, "PATIENCE", 0.0)
    assert srs_ik.load("human_arm").bodies
    assert capsys.readouterr().err == ""
