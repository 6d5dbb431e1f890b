"""`Tracker`: joint targets for a target pose that moves, one an update, inside the limits of all joints."""

from __future__ import annotations

import math
from copy import copy
from threading import RLock
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from srs_ik.collision.scenes.figures import as_margin, refuse_margin
from srs_ik.errors import InvalidConfiguration, InvalidPose, quoted, warn_caller
from srs_ik.inputs.angles import as_joint_vector
from srs_ik.inputs.fixed import Fixed
from srs_ik.inputs.freedom import as_free_axis
from srs_ik.inputs.numbers import real_number
from srs_ik.inputs.poses import PoseLike, as_rigid_matrix, as_target
from srs_ik.kernels.entries.track import update
from srs_ik.kernels.layout import track as at
from srs_ik.kernels.layout.objectives import PARAMS
from srs_ik.solve.freedom import met_batch
from srs_ik.solve.freedom import solve as solve_free
from srs_ik.solve.pose import solve
from srs_ik.solve.solution import Solution
from srs_ik.solve.tracker.braking import braking
from srs_ik.solve.tracker.elbow import Choose, chosen, is_scene
from srs_ik.solve.tracker.jerk import JerkFilter
from srs_ik.solve.tracker.limits import as_period, kept, limits_of, pushes, usual_accelerations
from srs_ik.solve.tracker.step import TrackerStep
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.collision.owner import BodyOwner
    from srs_ik.collision.scenes.scene import Scene
    from srs_ik.solve.packed import PackedArm
    from srs_ik.solve.solution import Collision
    from srs_ik.solve.tracker.guard import Guard

CHOSEN_EVERY = 10
"""Updates from one choice of an arm angle, by a point or the bodies of a scene, to the next."""

ASK_AGAIN = 2000
"""Updates from one search of the whole redundancy to the next at least: that takes up to some milliseconds."""

CLOSE_BY = 1.0
"""A posture this close, rad, that is found where none was, is gone to by itself."""

PATIENCE = 0.05
"""Time constant, seconds, in which a target that is lost is expected to slow down."""

FED_BACK = 20
"""So many resets, each after a single update, are a loop that feeds measured joints back."""

TOGETHER = 1e-6
"""With limits of the jerk, joints this close to where they should be, rad, are there."""


class Tracker(Fixed):
    """Follows a target pose, one joint step an update, and passes no limit; made by `Arm.tracker`.

    The limits hold for the joint angles as they come out: the difference of two, over the period, is within the
    velocity limits, the difference of two such velocities, over the period, within the acceleration limits, and every
    joint can always stop before the end of its range. With a scene, so can the arm before it comes too close to a body
    that stands still.

    Attributes:
        dt: seconds between two updates.
        velocity_limit: (7,) rad/s.
        acceleration_limit: (7,) rad/s^2; inf for a joint without one.
        jerk_limit: (7,) rad/s^3, or None.
        free_axis: what of a target's rotation is free, or None.
        margin: what is to be left between any two bodies, m; it goes with a scene.
    """

    _fixed = frozenset(("dt", "velocity_limit", "acceleration_limit", "jerk_limit", "free_axis", "margin"))
    _closed = True
    _instead = "only elbow and smoothing can; make another tracker by Arm.tracker"

    def __init__(
        self,
        arm: tuple[PackedArm, BodyOwner],
        q0: ArrayLike,
        dt: float,
        bounds: tuple[ArrayLike | None, ArrayLike | None, ArrayLike | None],
        elbow: Any,
        smoothing: float | None,
        free_axis: Any,
        scene: Scene | None,
        margin: float,
    ) -> None:
        packed, owner = arm
        self._packed, self._arm = packed, owner
        # One update at a time, whoever asks.
        self._one = RLock()
        velocity, acceleration, jerk = bounds
        self.dt = as_period(dt)
        self.velocity_limit = limits_of(velocity, packed, "velocity", packed.velocity_limit)
        usual = usual_accelerations(packed, self.velocity_limit)
        self.acceleration_limit = limits_of(acceleration, packed, "acceleration", usual, endless=True)
        self._settings = np.zeros(at.SETTINGS + PARAMS)
        self._settings[at.PERIOD] = self.dt
        self._settings[at.SPEED : at.ACCELERATION] = self.velocity_limit
        self._settings[at.ACCELERATION : at.SMOOTHING] = pushes(self.acceleration_limit, self.velocity_limit, self.dt)
        self._settings[at.PATIENCE] = PATIENCE
        self._work = np.zeros((8, 16, 9))
        self._nowhere = np.eye(4)
        self.jerk_limit = None if jerk is None else limits_of(jerk, packed, "jerk", np.empty(7))
        self.free_axis = None if free_axis is None else as_free_axis(free_axis)
        if self.free_axis is not None:
            self._settings[at.HAS_FREE] = 1.0
            self._settings[at.FREE : at.SETTINGS] = self.free_axis.packed
        self._guard: Guard | None = None
        self.margin = as_margin(margin)
        if scene is not None:
            self._guard = self._guard_in(scene)
        elif not is_scene(elbow):
            refuse_margin(margin)
        self._scene_given = scene is not None
        self.elbow = elbow
        self.smoothing = smoothing
        self._resets_in_a_row = 0
        self._reset(as_joint_vector(q0, "q0"))

    @property
    def q(self) -> Array:
        """(7,) joint angles of the last update, rad."""
        return self._state[at.Q : at.V].copy() if self._jerk is None else self._sent[1].copy()

    @property
    def elbow(self) -> Any:
        """What the elbow does with the freedom that the target leaves it; may be set between updates."""
        return self._elbow

    @elbow.setter
    def elbow(self, elbow: Any) -> None:
        (kind, angle, parameters), self._choose = chosen(elbow, self._packed, self._arm)
        self._settings[at.ELBOW], self._settings[at.ANGLE_WANTED] = self._policy = kind, angle
        self._settings[at.SETTINGS :] = parameters
        if is_scene(elbow) and not self._scene_given and self.scene is not elbow:
            self._guard = self._guard_in(elbow)
        self._elbow, self._just_set = elbow, True

    @property
    def scene(self) -> Scene | None:
        """What the arm stops before; if none was given, the last that was the elbow's; None for nothing.

        Its objects may be moved between updates.
        """
        return None if self._guard is None else self._guard.scene

    def _guard_in(self, scene: Scene) -> Guard:
        # A tracker without a scene needs nothing of collisions.
        from srs_ik.solve.tracker.guard import Guard

        return Guard(self._arm, self._packed, scene, self.margin)

    @property
    def smoothing(self) -> float | None:
        """Time constant of the filter that takes jitter from the target, seconds; None for what its noise asks for.

        It may be set between updates.
        """
        return self._smoothing

    @smoothing.setter
    def smoothing(self, seconds: float | None) -> None:
        self._smoothing = None if seconds is None else real_number(seconds)
        if self._smoothing is not None and not 0.0 <= self._smoothing < math.inf:
            given = quoted(seconds)
            raise InvalidConfiguration(f"smoothing must be a number of seconds from 0 on, or None, not {given}")
        self._settings[at.SMOOTHING] = at.MEASURED if self._smoothing is None else self._smoothing

    @property
    def smoothed(self) -> float:
        """Time constant of that filter in the last update, seconds; 0.0 where the target was taken as it came."""
        return float(self._state[at.SMOOTHED])

    @property
    def noise(self) -> tuple[float, float]:
        """Standard deviation of the target's jitter along an axis, m, and about one, rad, as measured on its way.

        From the last 36 targets that came.
        """
        return float(self._state[at.NOISE]), float(self._state[at.NOISE + 1])

    def reset(self, q0: ArrayLike) -> None:
        """Begin anew, at rest: after a stop, or where the robot was moved otherwise, and not before every update.

        Args:
            q0: (7,) joint angles, rad.

        Raises:
            InvalidConfiguration: not 7 finite angles, or one outside its limits.
        """
        with self._one:
            self._resets_in_a_row = self._resets_in_a_row + 1 if self._state[at.TICK] == 1.0 else 0
            if self._resets_in_a_row == FED_BACK:
                warn_caller(
                    "reset before every update makes the arm begin at rest each time, and fall behind: "
                    "do not feed measured joints back, a tracker knows where it has sent them"
                )
            self._reset(as_joint_vector(q0, "q0"))

    def _reset(self, q: Array) -> None:
        outside = np.maximum(self._packed.lower - q, q - self._packed.upper)
        if outside.max() > 0.0:
            joint = int(outside.argmax())
            raise InvalidConfiguration(
                f"q0 has {self._packed.joint_names[joint]} {outside[joint]:.6g} rad outside its limits; "
                "a tracker begins inside of them, as np.clip(q0, arm.lower, arm.upper) is"
            )
        self._state = np.zeros(at.STATE)
        self._state[at.Q : at.V] = self._state[at.GOAL : at.GOAL_RATE] = q
        # The first target may be where the tip is.
        self._state[at.ON] = 1.0
        self._state[at.GAP] = np.inf
        # Who is in the way while the arm brakes.
        self._stops: Collision | None = None
        self._jerk: JerkFilter | None = None
        if self.jerk_limit is not None:
            pushes = self._settings[at.ACCELERATION : at.SMOOTHING].copy()
            bounds = self.velocity_limit, pushes, self.jerk_limit
            self._jerk = JerkFilter(q, self.dt, (self._packed.lower, self._packed.upper), bounds)
            self._sent = np.array([q, q])

    def update(self, pose: PoseLike | None) -> TrackerStep:
        """The joint angles for the end of the next period.

        Args:
            pose: where the tip should be then, in the base frame; None where no target has come. A pose that is not
                finite or no rigid transform counts as none, and the status says so.

        Raises:
            InvalidPose: nothing like a pose: another shape, or no numbers.
        """
        with self._one:
            return self._update(pose)

    def _update(self, pose: PoseLike | None) -> TrackerStep:
        out = np.empty(at.STEP)
        before = self._state[at.Q : at.GOAL].copy()
        T = None if pose is None else as_target(pose)
        if self._choose is not None:
            self._choose_elbow(self._choose)
        if T is None:
            update(self._packed.family, self._state, self._settings, self._nowhere, 0, self._work, out)
        else:
            update(self._packed.family, self._state, self._settings, T, 1, self._work, out)
            if out[at.STEP_REASON] == at.FORBIDDEN and self._state[at.ASKED] == at.UNKNOWN:
                self._ask(out)
        hit = None if self._guard is None else self._hold(self._guard, before, out, T)
        if self._jerk is not None:
            hit = self._send(self._jerk, out, T) or hit
        if hit is not None:
            out[at.STEP_STATUS], out[at.STEP_JOINT] = at.HELD, 0.0
        return TrackerStep(out, self._packed.joint_names, (self._packed.lower, self._packed.upper), hit)

    def _hold(self, guard: Guard, before: Array, out: Array, T: Array | None) -> Collision | None:
        """Brake instead of a step after which the arm could not stop in time: who is in the way, None for nobody.

        Once it brakes it comes to rest first: to ask in between would let it shake.
        """
        hit = self._stops if before[7:].any() else None
        if hit is None:
            way = np.vstack([before[:7], self._braking(out[at.STEP_Q : at.STEP_V], out[at.STEP_V : at.STEP_A])])
            allowed, hit = guard.look(way, lambda: self._braking(before[:7], before[7:]))
            if allowed:
                self._stops = None
                return hit
        self._stops = hit
        stop = self._braking(before[:7], before[7:])
        q = stop[min(1, len(stop) - 1)]
        v = (q - before[:7]) / self.dt
        self._state[at.Q : at.V], self._state[at.V : at.GOAL] = q, v
        # The plan and the tip are those of the step that is not taken.
        self._state[at.ON] = self._state[at.PLANNED] = 0.0
        out[at.STEP_Q : at.STEP_V], out[at.STEP_V : at.STEP_A] = q, v
        out[at.STEP_A : at.STEP_STATUS] = (v - before[7:]) / self.dt
        self._measure(out, T)
        return hit

    def _braking(self, q: Array, v: Array) -> Array:
        push = self._settings[at.ACCELERATION : at.SMOOTHING]
        return braking(q, v, push, self.dt, (self._packed.lower, self._packed.upper))

    def _choose_elbow(self, choose: Choose) -> None:
        """Ask for the arm angle that suits the elbow's policy now and then, while the tip is on the target."""
        if int(self._state[at.TICK]) % CHOSEN_EVERY and not self._just_set:
            return
        self._just_set = False
        policy = self._policy
        if self._state[at.ON] == 1.0:
            policy = at.ANGLE, choose(self._state[at.Q : at.V], self._state[at.ASKED] != at.MOVES)
        self._settings[at.ELBOW], self._settings[at.ANGLE_WANTED] = policy

    def _ask(self, out: Array) -> None:
        """Before a target that rests is said to be out of reach, once: search its whole redundancy, as `solve` does."""
        T = self._target()
        if self.free_axis is None:
            found = solve(self._packed, T, seed=self.q)
            q, met = found.q, bool(found)
        else:
            # To look on where this meets nothing takes a tenth of a second.
            postures, all_met = met_batch(self._packed, T[None], self.free_axis, self.q[None])
            q, met = postures[0], bool(all_met[0])
        self._state[at.ASKED] = at.RECONFIGURE if met else at.NOWHERE
        self._state[at.ASK_FROM] = self._state[at.TICK] + ASK_AGAIN
        if not met:
            return
        self._state[at.ELSEWHERE] = at.RECONFIGURE
        out[at.STEP_STATUS], out[at.STEP_REASON] = at.HELD, at.OTHER_POSTURE
        if np.abs(q - self._state[at.GOAL : at.GOAL_RATE]).max() < CLOSE_BY:
            self._go_to(q)
            out[at.STEP_STATUS], out[at.STEP_REASON] = at.LIMITED, at.ON_THE_WAY

    def _go_to(self, q: Array) -> None:
        """Send the arm to a posture."""
        self._state[at.DETOUR_END : at.MISS] = q
        self._state[at.DETOUR], self._state[at.ON], self._state[at.ELSEWHERE] = 1.0, 0.0, at.UNKNOWN

    def _send(self, jerk: JerkFilter, out: Array, T: Array | None) -> Collision | None:
        """Limit the jerk of a step, and write what comes of it: who is in the way, None for nobody."""
        wanted = out[at.STEP_Q : at.STEP_V].copy()
        q, hit = jerk.step(wanted, out[at.STEP_V : at.STEP_A], self._guard)
        before, last = self._sent
        self._sent = np.array([last, q])
        out[at.STEP_Q : at.STEP_V] = q
        out[at.STEP_V : at.STEP_A] = (q - last) / self.dt
        out[at.STEP_A : at.STEP_STATUS] = (q - 2.0 * last + before) / self.dt**2
        behind = np.abs(wanted - q)
        self._measure(out, T)
        if out[at.STEP_STATUS] == at.OK and behind.max() > TOGETHER:
            out[at.STEP_STATUS], out[at.STEP_REASON] = at.LIMITED, at.BEHIND
            out[at.STEP_JOINT] = 1.0 + int((behind / self.velocity_limit).argmax())
        return hit

    def _measure(self, out: Array, T: Array | None) -> None:
        """Write how far the tip of a step is from a target, or from where that is expected."""
        if out[at.STEP_REASON] != at.BAD_TARGET:
            goal = self._target() if T is None and self._state[at.STARTED] else T
            if goal is not None:
                q = out[at.STEP_Q : at.STEP_V]
                out[at.STEP_POSITION_ERROR], out[at.STEP_ORIENTATION_ERROR] = self._error(goal, q)

    def _error(self, T: Array, q: Array) -> tuple[float, float]:
        """Metres and radians between the tip and a target, but for what that leaves free."""
        if self.free_axis is None:
            return self._arm.verify(T, q)
        tip = self._arm.forward_kinematics(q)
        lean = self.free_axis.lean(tip.rotation, T[:3, :3])
        # The square of 1e300 m is no float.
        return math.hypot(*(tip.translation - T[:3, 3]).tolist()), lean

    def reconfigure(self, pose: PoseLike | None = None) -> Solution:
        """Let the arm go to the posture of a pose that is nearest to the present one, in whatever configuration.

        The joints go there straight, within all limits, while `update` is called with targets as before; between, the
        tip is not on the target. With a scene it is the nearest posture that is free, and the arm stops before what
        stands in its straight way.

        Args:
            pose: the last target if not given.

        Returns:
            The posture; where the pose has none, one that says why, and the arm stays as it is.

        Raises:
            InvalidPose: no finite rigid transform, or none given and no target yet.
        """
        with self._one:
            T = self._target() if pose is None else as_rigid_matrix(pose)
            found = self._nearest_posture(T)
            if found:
                self._go_to(found.q)
            return found

    def _nearest_posture(self, T: Array) -> Solution:
        if self._guard is not None:
            return self._guard.nearest(T, self.q, self.free_axis)
        if self.free_axis is None:
            return solve(self._packed, T, seed=self.q)
        return solve_free(self._packed, T, self.free_axis, self.q, True)

    def _target(self) -> Array:
        if not self._state[at.STARTED]:
            raise InvalidPose("there was no target yet: give reconfigure a pose")
        T = np.eye(4)
        T[:3, :3] = self._state[at.ROTATION : at.POSITION].reshape(3, 3)
        T[:3, 3] = self._state[at.POSITION : at.TWIST]
        return T

    def __getstate__(self) -> dict[str, Any]:
        """What a copy begins with: an update writes in place, and must not move another tracker."""
        own: dict[str, Any] = {name: vars(self)[name].copy() for name in ("_state", "_settings", "_work")}
        own |= {"_jerk": copy(self._jerk), "_choose": copy(self._choose), "_one": None}
        return {**vars(self), **own}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """A copy's limits are fixed, too: NumPy forgets that of arrays that are copied."""
        self.__dict__.update(state, _one=RLock())
        for limits in (self.velocity_limit, self.acceleration_limit, self.jerk_limit):
            if limits is not None:
                kept(limits)

    def __repr__(self) -> str:
        return f"<Tracker of {self._packed.name}, {self.dt:g} s, elbow {self._elbow!r}>"
