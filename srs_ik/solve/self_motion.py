"""Self-motion: the postures that an arm can go through while its tip stands still, for drawing and for sampling."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from srs_ik.errors import InvalidConfiguration
from srs_ik.inputs.poses import PoseLike, as_branch, as_rigid_matrix
from srs_ik.kernels.layout.answer import ROW
from srs_ik.solve.intervals import intervals
from srs_ik.solve.pose import solve
from srs_ik.solve.solution import BatchSolution, Interval

if TYPE_CHECKING:
    from srs_ik.solve.packed import PackedArm

Array = NDArray[np.float64]

_INSIDE = 1e-9
"""Samples stay this far inside the ends of an interval, rad; on an end, rounding may put a joint past its limit. An
interval without room for that has one posture."""


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
        raise InvalidConfiguration(f"count must be an integer from 2 to {MOST_POSTURES}, not {count!r:.40}")
    T = as_rigid_matrix(pose)
    wide = [i for i in intervals(arm, T, respect_limits) if wanted in (-1, i.branch)]
    return [through(arm, T, interval, int(count), respect_limits) for interval in wide]


def through(arm: PackedArm, T: Array, interval: Interval, count: int, respect_limits: bool) -> SelfMotion:
    """The self-motion through one interval of a pose (4, 4)."""
    rows = np.empty((count, ROW))
    if interval.width <= 2.0 * _INSIDE:
        rows[:] = solve(arm, T, 0.5 * (interval.lower + interval.upper), None, interval.branch, respect_limits)._row
        return SelfMotion(rows, arm.joint_names, interval)
    before = None
    for row, psi in zip(rows, np.linspace(interval.lower + _INSIDE, interval.upper - _INSIDE, count), strict=True):
        found = solve(arm, T, float(psi), before, interval.branch, respect_limits)
        row[:] = found._row
        before = found.q if found else before
    return SelfMotion(rows, arm.joint_names, interval)
