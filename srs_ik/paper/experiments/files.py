"""What an experiment leaves behind: its picture and its figures, in files that appear whole or not at all."""

from __future__ import annotations

import io
import json
import platform
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from srs_ik.kernels.native import at_work
from srs_ik.paper.experiments.setting import Outcome
from srs_ik.system.arrays import plain
from srs_ik.system.writing import write_whole

if TYPE_CHECKING:
    from srs_ik.arm import Arm

_PACKAGES = {"numpy": "numpy", "pinocchio": "pin", "matplotlib": "matplotlib"}


def write(folder: Path, name: str, arm: Arm, outcome: Outcome) -> list[Path]:
    """Write NAME.png, NAME.svg and NAME.json into a folder that exists, and return their paths.

    Raises:
        MissingExtra: Matplotlib is not installed.
        OSError: a file cannot be written; what was there before is still there.
    """
    import matplotlib

    figure = outcome.draw()
    contents: dict[str, bytes] = {}
    # Neither a date nor random names: the same picture is the same file.
    with matplotlib.rc_context({"svg.hashsalt": name}):
        for ending, metadata in (("png", {"Software": None}), ("svg", {"Date": None, "Creator": None})):
            buffer = io.BytesIO()
            figure.savefig(buffer, format=ending, metadata=metadata)
            contents[ending] = buffer.getvalue()
    contents["json"] = (json.dumps(plain(report(name, arm, outcome)), indent=1, allow_nan=False) + "\n").encode()
    return [write_whole(folder / f"{name}.{ending}", content) for ending, content in contents.items()]


def report(name: str, arm: Arm, outcome: Outcome) -> dict[str, Any]:
    """An experiment's figures, with what they belong to."""
    from srs_ik import __version__

    limb = arm.limb
    return {
        "experiment": name,
        "robot": arm.name,
        "base": arm.base,
        "tip": arm.tip,
        "limb": {"kind": limb.kind, "wrist": limb.wrist_kind},
        "lengths_m": {"upper_arm": limb.upper_arm, "forearm": limb.forearm, "hand": limb.hand},
        "seed": outcome.seed,
        "versions": {
            "srs_ik": __version__,
            "python": platform.python_version(),
            **{name: version(package) for name, package in _PACKAGES.items()},
            "kernels": at_work(),
        },
        "figures": outcome.figures,
    }
