"""Jerk limits for a tracker, by Ruckig: from the state that the joints have to where the tracker wants them next."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from srs_ik.errors import MissingExtra
from srs_ik.solve.tracker.braking import MOST_LINES
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.solve.solution import Collision
    from srs_ik.solve.tracker.guard import Guard

SHARE = 1.0 - 1e-3
"""Share of the limits that Ruckig is given: its motions are exact to some 1e-10 rad, which differences magnify."""


State = tuple[list[float], list[float], list[float]]
"""Joint angles, velocities and accelerations."""


class JerkFilter:
    """Joint angles within limits of velocity, acceleration and jerk that follow others as fast as these allow.

    A step is taken only if the joints can come to rest from its end inside the position limits, and free of what stands
    around, and that motion is kept: where no step is good, it is what goes on. So the limits hold whatever is followed.
    """

    def __init__(self, q0: Array, dt: float, limits: tuple[Array, Array], bounds: tuple[Array, Array, Array]) -> None:
        """Begin at rest.

        Args:
            q0: (7,) joint angles, rad.
            dt: seconds between two steps.
            limits: (7,) lower and (7,) upper position limits, rad.
            bounds: (7,) each: rad/s, rad/s^2, rad/s^3.

        Raises:
            MissingExtra: ruckig is not installed.
        """
        self._dt, self._limits, self._bounds = dt, limits, bounds
        self._state: State = (q0.tolist(), [0.0] * 7, [0.0] * 7)
        self._stops_from: State | None = None
        self._resting = 0.0
        self._prepare()

    def _prepare(self) -> None:
        """Make what of Ruckig computes the motions."""
        try:
            import ruckig
        except ImportError:
            raise MissingExtra("jerk", "limits of the jerk") from None
        self._ruckig: Any = ruckig.Ruckig(7, self._dt)
        self._new, self._failure = ruckig.Trajectory, ruckig.RuckigError
        self._good = (ruckig.Result.Working, ruckig.Result.Finished)
        self._input: Any = ruckig.InputParameter(7)
        self._input.max_velocity, self._input.max_acceleration, self._input.max_jerk = (
            (SHARE * bound).tolist() for bound in self._bounds
        )
        self._input.synchronization = ruckig.Synchronization.No
        self._to_goal, self._to_rest = ruckig.ControlInterface.Position, ruckig.ControlInterface.Velocity
        self._rest: Any = None if self._stops_from is None else self._motion(self._stops_from, None, np.zeros(7))

    def __getstate__(self) -> tuple[Any, ...]:
        """What a copy needs: Ruckig's own objects cannot be copied, and are made anew."""
        return self._dt, self._limits, self._bounds, self._state, self._stops_from, self._resting

    def __setstate__(self, state: tuple[Any, ...]) -> None:
        """Go on as the one that was copied."""
        self._dt, self._limits, self._bounds, self._state, self._stops_from, self._resting = state
        self._prepare()

    def step(self, goal: Array, velocity: Array, guard: Guard | None = None) -> tuple[Array, Collision | None]:
        """The joint angles a period on, (7,) rad, towards a goal that moves with a velocity; and who is in the way."""
        said = None
        for motion, after in self._steps(goal, velocity):
            if guard is not None:
                way = np.vstack([self._state[0], self._postures(motion, 0.0)])
                allowed, said = guard.look(way, self._braked)
                if not allowed:
                    continue
            self._state = self._stops_from = after
            self._rest, self._resting = motion, 0.0
            return np.array(after[0]), said
        if self._rest is not None:
            self._resting += self._dt
            self._state = self._rest.at_time(self._resting)[:3]
        return np.clip(self._state[0], *self._limits), said

    def _steps(self, goal: Array, velocity: Array) -> Iterator[tuple[Any, State]]:
        """Motions to rest after a step, inside the position limits, and the state from which each begins."""
        for through in (0.99 * SHARE * velocity, np.zeros(7)):
            motion = self._motion(self._state, goal, through)
            after = motion and motion.at_time(self._dt)[:3]
            rest = after and self._motion(after, None, np.zeros(7))
            if rest and self._inside(rest):
                yield rest, after

    def _braked(self) -> Array:
        """(n, 7) postures of the motion to rest that is kept, from the present one on."""
        return np.array([self._state[0]]) if self._rest is None else self._postures(self._rest, self._resting)

    def _postures(self, motion: Any, begin: float) -> Array:
        """(n, 7) postures of a motion from a time on, about a period apart, to its end."""
        periods = max(math.ceil((motion.duration - begin) / self._dt), 0)
        times = begin + self._dt * np.linspace(0.0, periods, min(periods, MOST_LINES) + 1)
        return np.clip([motion.at_time(time)[0] for time in times.tolist()], *self._limits)

    def _motion(self, state: Any, goal: Array | None, velocity: Array) -> Any:
        """The fastest motion from a state to a goal and a velocity there, or to that velocity alone; None for none."""
        given = self._input
        given.current_position, given.current_velocity, given.current_acceleration = state
        given.control_interface = self._to_rest if goal is None else self._to_goal
        given.target_velocity = velocity.tolist()
        if goal is not None:
            given.target_position = goal.tolist()
        motion = self._new(7)
        try:
            return motion if self._ruckig.calculate(given, motion) in self._good else None
        except self._failure:
            # Ruckig says so where rounding keeps it from a motion that there is.
            return None

    def _inside(self, motion: Any) -> bool:
        """Whether all of a motion is inside the position limits."""
        ends = [(joint.min, joint.max) for joint in motion.position_extrema]
        (lowest, highest), (lower, upper) = np.array(ends).T, self._limits
        return bool((lowest >= lower).all() and (highest <= upper).all())
