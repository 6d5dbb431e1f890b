"""Configurations over time: paths at the rate of a film, and the self-motion of an arm."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from srs_ik.errors import InvalidConfiguration
from srs_ik.inputs.angles import as_branch
from srs_ik.inputs.numbers import as_positive, real_array
from srs_ik.solve.path.trajectory import Trajectory
from srs_ik.solve.self_motion import through
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.arm import Arm
    from srs_ik.solve.intervals import Interval

FPS = 30.0
_MOST_FRAMES = 3000
"""Longer films get fewer frames a second."""

_SWEEP = 0.7
"""Speed of a shown self-motion, rad of the arm angle a second."""


def film(path: Any, dt: float | None) -> tuple[Array, float]:
    """A motion as frames (M, 7) even in time, rad, and how many there are a second.

    A joint path (N, 7) or a `PathSolution` has samples `dt` apart, s, or at the path's own times without `dt`; between
    them frames are on straight lines in joint space. A `Trajectory` is taken as it is.

    Raises:
        InvalidConfiguration: not N x 7 finite angles with N > 0, dt is no positive number, or missing where the path
            has no times of its own, or there beside a trajectory.
    """
    if isinstance(path, Trajectory):
        if dt is not None:
            raise InvalidConfiguration("a trajectory has times of its own: leave dt out")
        count = _frames_in(path.duration)
        if count < 2:
            return path.sample(1.0).q[:1], FPS
        return path.sample(path.duration / (count - 1)).q, (count - 1) / path.duration
    q = joint_path(path)
    times = _times_of(path, len(q)) if dt is None else as_positive(dt, "dt", "seconds") * np.arange(len(q))
    duration = float(times[-1])
    count = _frames_in(duration)
    if count < 2:
        return q[:1], FPS
    even = np.linspace(0.0, duration, count)
    return np.stack([np.interp(even, times, angles) for angles in q.T], axis=1), (count - 1) / duration


def _frames_in(duration: float) -> int:
    return int(min(np.ceil(duration * FPS), _MOST_FRAMES - 1)) + 1


def _times_of(path: Any, count: int) -> Array:
    """(N,) the times at which a path passes its samples, s; one of a single sample has no need of them."""
    times: Array | None = getattr(path, "passes", None)
    if times is None and count > 1:
        raise InvalidConfiguration("nothing says how fast the path is passed: give dt, seconds between two samples")
    return np.zeros(1) if times is None else times


def joint_path(path: Any) -> Array:
    """(N, 7) joint angles of a path.

    Raises:
        InvalidConfiguration: not N x 7 finite angles with N > 0.
    """
    try:
        q = real_array(getattr(path, "q", path))
    except (TypeError, ValueError):
        raise InvalidConfiguration(f"a joint path is an (N, 7) array of angles, not {type(path).__name__}") from None
    if q.ndim != 2 or q.shape[1] != 7 or not len(q):
        raise InvalidConfiguration(f"a joint path is an (N, 7) array of angles, not an array of shape {q.shape}")
    if not np.isfinite(q).all():
        raise InvalidConfiguration("the joint path has entries that are not finite numbers")
    return q


def self_motion(
    arm: Arm, pose: Array, intervals: list[Interval], branch: int | None, respect_limits: bool
) -> tuple[Array, Interval] | None:
    """The arm turned through its widest interval of feasible arm angles, and back, or once around the whole circle.

    Args:
        arm: the arm.
        pose: (4, 4) pose that the tip keeps.
        intervals: those of the pose.
        branch: 0 to 7 to stay in that branch.
        respect_limits: whether the intervals are those inside the joint limits.

    Returns:
        (M, 7) frames at `FPS`, rad, and the interval; None if there is no interval.
    """
    wanted = as_branch(branch)
    candidates = [interval for interval in intervals if wanted in (-1, interval.branch)]
    if not candidates:
        return None
    widest = max(candidates, key=lambda interval: interval.width)
    count = max(2, int(np.ceil(widest.width / _SWEEP * FPS)))
    found = through(arm.packed, pose, [widest], count, respect_limits)[0]
    q = found.q[found.ok]
    if not len(q):
        return None
    around = widest.width >= 2.0 * np.pi - 1e-9
    return (q if around else np.concatenate([q, q[-2:0:-1]])), widest
