"""Jerk limits for a tracker, by Ruckig: from the state that the joints have to where the tracker wants them next."""

from __future__ import annotations

from typing import Any

import numpy as np

from srs_ik.errors import MissingExtra
from srs_ik.system.arrays import Array

SHARE = 1.0 - 1e-3
"""Share of the limits that Ruckig is given: its motions are exact to some 1e-10 rad, which differences magnify."""


class JerkFilter:
    """Joint angles within limits of velocity, acceleration and jerk that follow others as fast as these allow.

    A step is taken only if the joints can come to rest from its end inside the position limits, and that motion is
    kept: where no step is good, it is what goes on. So the limits hold whatever is followed.
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
        try:
            import ruckig
        except ImportError:
            raise MissingExtra("jerk", "limits of the jerk") from None
        self._dt = dt
        self._lower, self._upper = limits
        self._ruckig: Any = ruckig.Ruckig(7, dt)
        self._new = ruckig.Trajectory
        self._good = (ruckig.Result.Working, ruckig.Result.Finished)
        self._input: Any = ruckig.InputParameter(7)
        self._input.max_velocity, self._input.max_acceleration, self._input.max_jerk = (
            (SHARE * bound).tolist() for bound in bounds
        )
        self._input.synchronization = ruckig.Synchronization.No
        self._to_goal, self._to_rest = ruckig.ControlInterface.Position, ruckig.ControlInterface.Velocity
        self._rest: Any = None
        self._resting = 0.0
        self._state = (q0.tolist(), [0.0] * 7, [0.0] * 7)

    def step(self, goal: Array, velocity: Array) -> Array:
        """The joint angles a period on, towards a goal that moves with a velocity: (7,) rad."""
        for through in (0.99 * SHARE * velocity, np.zeros(7)):
            motion = self._motion(self._state, goal, through)
            after = motion and motion.at_time(self._dt)[:3]
            rest = after and self._motion(after, None, np.zeros(7))
            if rest and self._inside(rest):
                self._state, self._rest, self._resting = after, rest, 0.0
                return np.array(after[0])
        if self._rest is not None:
            self._resting += self._dt
            self._state = self._rest.at_time(self._resting)[:3]
        return np.clip(self._state[0], self._lower, self._upper)

    def _motion(self, state: Any, goal: Array | None, velocity: Array) -> Any:
        """The fastest motion from a state to a goal and a velocity there, or to that velocity alone."""
        given = self._input
        given.current_position, given.current_velocity, given.current_acceleration = state
        given.control_interface = self._to_rest if goal is None else self._to_goal
        given.target_velocity = velocity.tolist()
        if goal is not None:
            given.target_position = goal.tolist()
        motion = self._new(7)
        return motion if self._ruckig.calculate(given, motion) in self._good else None

    def _inside(self, motion: Any) -> bool:
        """Whether all of a motion is inside the position limits."""
        ends = [(joint.min, joint.max) for joint in motion.position_extrema]
        lowest, highest = np.array(ends).T
        return bool((lowest >= self._lower).all() and (highest <= self._upper).all())
