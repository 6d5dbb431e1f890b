"""Running `srs-ik` in tests, and what its answers are compared with."""

import json
import os
import subprocess
import sys

import numpy as np
import pinocchio as pin
from typer.testing import CliRunner

from srs_ik.cli.app import app
from srs_ik.robot import zoo

POSE = ["--xyz", "0.5", "0.1", "0.6", "--rpy", "0", "1.5707963", "0"]
Q = ["0.3", "0.7", "-0.4", "-1.1", "0.5", "0.8", "-0.2"]


def run(*words: str):
    return CliRunner().invoke(app, list(words))


def answer(*words: str, exit_code: int = 0) -> dict:
    result = run(*words, "--json")
    assert result.exit_code == exit_code, result.stderr or result.exception
    return json.loads(result.stdout)


def run_apart(words: list[str], **environment: str) -> subprocess.CompletedProcess:
    """Run the installed command in a process of its own."""
    command = [sys.executable, "-c", "from srs_ik.cli import main; main()", *words]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, env={**os.environ, **environment})


def pose_by_pinocchio(robot: str, q: list[float]) -> np.ndarray:
    """Pose of the tip in the base frame, from the untouched file of a built-in robot without continuous joints."""
    card = zoo.card(robot)
    model = pin.buildModelFromUrdf(str(card.urdf))
    assert model.nq == 7
    data = model.createData()
    pin.framesForwardKinematics(model, data, np.array(q))
    base, tip = (data.oMf[model.getFrameId(name)] for name in (card.base, card.tip))
    return (base.inverse() * tip).homogeneous
