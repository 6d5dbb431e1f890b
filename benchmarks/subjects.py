"""Arms that long runs go through, and what their command lines share: how many, which random numbers, which robot."""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Iterator
from itertools import count
from pathlib import Path

import numpy as np

import srs_ik

FOLDER = Path(__file__).resolve().parents[2] / "shared" / "urdf"
"""Where robot files of makers are looked for that a name stands for, as the tests do."""

FILES = {
    "iiwa14_experimental": "iiwa14_kuka_experimental.urdf:base_link:tool0",
    "iiwa14_drake": "iiwa14_drake_models.urdf:iiwa_link_0:iiwa_link_7",
    "j2s7s300": "kinova_j2s7s300.urdf:j2s7s300_link_base:j2s7s300_link_7",
    "med7": "med7_lbr_stack.urdf:lbr_link_0:lbr_link_ee",
    "sia10f": "motoman_sia10f.urdf:base_link:link_tool0",
    "sia5d": "motoman_sia5d.urdf:base_link:tool0",
    "openarm_left": "openarm_v10_bimanual.urdf:openarm_left_link0:openarm_left_hand",
    "rm75": "realman_rm75.urdf:base_link:Link7",
    "h1_2_left": "unitree_h1_2_handless.urdf:torso_link:left_wrist_yaw_link",
}

MADE = {
    "random": (0.0, 0.0),
    "random_near": (2e-4, 0.0),
    "random_oblique": (0.0, 0.2),
    "random_leaning": (0.0, 1e-6),
    "random_rounded": (1e-8, 0.0),
}
"""Arms that are made: by how much, m, their joints miss their places, and by how much their axes lean, rad."""

CASES_EACH = 10
"""Cases of each made arm."""


def parser(description: str, cases: str) -> argparse.ArgumentParser:
    """A command line with --count, --seed and --robot.

    Args:
        description: first line of its help.
        cases: what is counted.
    """
    made = argparse.ArgumentParser(description=description)
    made.add_argument("--count", type=_positive, default=1000, help=f"{cases} (1000)")
    made.add_argument("--seed", type=int, default=0, help="of the random numbers: other seeds, other cases (0)")
    known = ", ".join([*MADE, *FILES])
    made.add_argument("--robot", default="iiwa14", help=f"name of a built-in robot, FILE:BASE:TIP, or {known} (iiwa14)")
    return made


def arms_of(robot: str, cases: int, seed: int) -> Iterator[tuple[srs_ik.Arm, int]]:
    """Arms, and how many cases each is to have, so that there are as many as are wanted."""
    if robot not in MADE:
        yield load(robot), cases
        return
    miss, lean = MADE[robot]
    left = cases
    for arm in random_arms(np.random.default_rng([seed, len(robot)]), miss, lean):
        yield arm, min(left, CASES_EACH)
        left -= CASES_EACH
        if left <= 0:
            return


def load(robot: str) -> srs_ik.Arm:
    """A built-in robot, one of `FILES`, or FILE:BASE:TIP."""
    text = FILES.get(robot, robot)
    if ":" not in text:
        return srs_ik.load(text)
    file, base, tip = text.rsplit(":", 2)
    return srs_ik.load(FOLDER / file if robot in FILES else file, base=base, tip=tip)


def random_arms(rng: np.random.Generator, miss: float, lean: float) -> Iterator[srs_ik.Arm]:
    """S-R-S arms of random lengths and limits, as a chain of seven joints in one URDF.

    Args:
        rng: random numbers.
        miss: each joint stands up to so far beside its place, m.
        lean: axes are turned by up to so much in each direction, rad; else neighbours are perpendicular.
    """
    for number in count():
        lengths = rng.uniform(0.1, 0.5, 3)
        axes = np.eye(3)[[2, 1, 2, 1, 2, 1, 2]] + lean * rng.uniform(-1.0, 1.0, (7, 3))
        # The way along z to each joint from the one before; joint 5 may stand at either end of a forearm that it turns.
        at_wrist = number % 2 == 0 or lean > 0.0
        ways = (0.0, 0.0, 0.0, lengths[0], lengths[1] * at_wrist, lengths[1] * (not at_wrist), 0.0)
        beside = miss * rng.uniform(-1.0, 1.0, (7, 2))
        links = "".join(f'<link name="link_{i}"/>' for i in range(9))
        joints = "".join(
            f'<joint name="joint_{i + 1}" type="revolute"><parent link="link_{i}"/><child link="link_{i + 1}"/>'
            f'<origin xyz="{beside[i, 0]} {beside[i, 1]} {ways[i]}"/><axis xyz="{" ".join(map(str, axes[i]))}"/>'
            f'<limit lower="{-rng.uniform(1.5, 6.5)}" upper="{rng.uniform(1.5, 6.5)}" effort="1" velocity="1"/></joint>'
            for i in range(7)
        )
        tip = (
            '<joint name="tip" type="fixed"><parent link="link_7"/><child link="link_8"/>'
            f'<origin xyz="0.02 0 {lengths[2]}" rpy="0.1 0.2 0.3"/></joint>'
        )
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / f"random_{number}.urdf"
            file.write_text(f'<robot name="random_{number}">{links}{joints}{tip}</robot>')
            yield srs_ik.load(file, base="link_0", tip="link_8")


def say(text: str) -> None:
    """What is found on the way, on standard error: standard output is one line."""
    print(text, file=sys.stderr, flush=True)


def finish(robot: str, seed: int, figures: str, failed: int) -> None:
    """Print the one line of a run, and leave with 1 if anything has failed."""
    print(f"{robot}, seed {seed}: {figures}", flush=True)
    sys.exit(1 if failed else 0)


def _positive(text: str) -> int:
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"it has to be 1 or more, not {number}")
    return number
