"""Self-motion: the postures that an arm can go through while its tip stands still, for drawing and for sampling."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from srs_ik.errors import InvalidConfiguration, quoted
from srs_ik.inputs.angles import as_branch
from srs_ik.inputs.poses import PoseLike, as_rigid_matrix
from srs_ik.kernels.entries import pose as entries
from srs_ik.kernels.layout.answer import ROW
from srs_ik.solve.intervals import Interval, intervals
from srs_ik.solve.solutions import BatchSolution
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.solve.packed import PackedArm

MOST_POSTURES = 1_000_000
"""Postures an interval that fit into memory, and into some seconds: 100 MB."""


class SelfMotion(BatchSolution):
    """The postures of one interval of arm angles, evenly spaced in arm angle, as arrays over them.

    Each is in the turns nearest to the one before, so that the rows of `q` draw a curve.

    Attributes:
        interval: the `Interval` that they go through, from `interval.lower` to `interval.upper`.
    """

    def __init__(self, rows: Array, joint_names: Sequence[str], interval: Interval) -> None:
        super().__init__(rows, joint_names)
        self.interval = interval

    def __repr__(self) -> str:
        i = self.interval
        return f"SelfMotion({self.solved} postures in branch {i.branch}, {i.lower:.6g} to {i.upper:.6g} rad)"


def self_motion(
    arm: PackedArm, pose: PoseLike, branch: int | None, count: int, respect_limits: bool
) -> list[SelfMotion]:
    """See `Arm.self_motion`."""
    wanted = as_branch(branch)
    if isinstance(count, bool) or not isinstance(count, int | np.integer) or not 2 <= count <= MOST_POSTURES:
        raise InvalidConfiguration(f"count must be an integer from 2 to {MOST_POSTURES}, not {quoted(count)}")
    T = as_rigid_matrix(pose)
    wide = [i for i in intervals(arm, T, respect_limits) if wanted in (-1, i.branch)]
    return through(arm, T, wide, int(count), respect_limits)


def through(arm: PackedArm, T: Array, wide: Sequence[Interval], count: int, respect_limits: bool) -> list[SelfMotion]:
    """The self-motions through some intervals of a pose (4, 4)."""
    if not wide:
        return []
    found = np.array([(i.branch, i.lower, i.upper) for i in wide], float)
    rows = np.empty((len(wide) * count, ROW))
    entries.self_motion(arm.family, T, found, respect_limits, rows)
    of_each = rows.reshape(len(wide), count, ROW)
    return [SelfMotion(own, arm.joint_names, interval) for own, interval in zip(of_each, wide, strict=True)]
