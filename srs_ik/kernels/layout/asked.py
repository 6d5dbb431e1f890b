"""What travels from kernel to kernel while a question is answered, by name: flat, and free once it is compiled."""

from __future__ import annotations

from typing import Any, NamedTuple


class Target(NamedTuple):
    """A pose that is asked for."""

    R: Any  # rotation of the tip
    p: Any  # position of the tip
    place: Any  # what all its configurations share, from `triangle.place`


class Goal(NamedTuple):
    """Which of several configurations is best."""

    seeded: Any  # the one nearest to a seed; else the one farthest from the limits
    seed: Any
    respect: Any  # whether the limits count


class Best(NamedTuple):
    """The best configuration so far."""

    q: Any
    cost: Any


class View(NamedTuple):
    """What is known of a pose while the nearest exact limb predicts its configurations."""

    target: Any
    sides: Any  # both sides of the elbow, from `triangle.elbow_side`
    band: Any  # how far each joint of the true chain may be from the exact limb, rad, as `band.band_of` says
    points: Any  # (MAX_POINTS, POINT) work space
    gaps: Any  # (MAX_POINTS, 2) work space


class Setting(NamedTuple):
    """What configurations on curves of one pose are found with."""

    target: Any
    side: Any  # of the elbow, where the closed form gives the configurations
    respect: Any  # whether the limits count
    J: Any  # (6, 7) work space
    A: Any  # (16, 9) work space


class Samples(NamedTuple):
    """A curve that is sampled: rows `first` to `last` - 1, each a parameter and seven joint angles."""

    rows: Any
    first: Any
    last: Any


class Runs(NamedTuple):
    """Where feasible runs are written: their samples, and a row for each run."""

    rows: Any
    runs: Any
