"""What the experiments have in common: the arm's lengths, random directions and targets, and how an outcome looks."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from srs_ik.arm import Arm
    from srs_ik.solve.posture import Side

Progress = Callable[[float], None]
"""Is told the share of an experiment that is done, from 0 to 1."""

SEED = 0
"""Of every random draw, if no other is given."""

BOTH: tuple[Side, Side] = ("left", "right")

EXTENSION = 0.5 / 0.79
"""Target of the first experiment as a share of the reach: 0.5 m on the paper's limb of 0.37 + 0.32 + 0.10 m."""


class Outcome(NamedTuple):
    """What an experiment found."""

    figures: dict[str, Any]  # numbers, by name; arrays where a figure draws them
    draw: Callable[[], Figure]  # makes the picture; needs Matplotlib
    seed: int = SEED  # of what was drawn at random


def reach(arm: Arm) -> float:
    """Upper arm, forearm and hand together, metres: the paper's maximum reach."""
    return arm.limb.upper_arm + arm.limb.forearm + arm.limb.hand


def unit(vectors: Array) -> Array:
    """Vectors (..., 3) at length 1."""
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def directions(rng: np.random.Generator, count: int) -> Array:
    """(count, 3) unit vectors, uniform on the sphere."""
    return unit(rng.normal(size=(count, 3)))


def task_directions(rng: np.random.Generator, count: int) -> tuple[Array, Array]:
    """Random velocity directions (count, 3), and force directions (count, 3) across them."""
    v = directions(rng, count)
    return v, unit(np.cross(v, directions(rng, count)))


def ball(rng: np.random.Generator, count: int, radius: float) -> Array:
    """(count, 3) points, uniform in a ball about the origin, metres."""
    return directions(rng, count) * (radius * rng.uniform(size=(count, 1)) ** (1.0 / 3.0))
