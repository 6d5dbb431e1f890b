"""The torque controller: ports whose torques add up, and the weight of the arm."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from srs_ik.analysis.gravity import require_masses
from srs_ik.arm import Arm
from srs_ik.control.impedance import FractalImpedance, JointLimits, JointSpeeds
from srs_ik.errors import InvalidConfiguration, InvalidController, InvalidTask, quoted
from srs_ik.inputs.angles import as_bounded_joint_vector, as_joint_vector
from srs_ik.inputs.control import flag, seven_positive, thing, things, vector
from srs_ik.inputs.poses import PoseLike, as_rigid_matrix
from srs_ik.kernels.entries import control as entries
from srs_ik.kernels.layout import control as at
from srs_ik.system.arrays import Array, equal_to_itself

if TYPE_CHECKING:
    from srs_ik.inputs.task import Task
    from srs_ik.solve.posture import Side, Tie
    from srs_ik.solve.solution import Solution

Usual = TypeVar("Usual", JointLimits, JointSpeeds)


@equal_to_itself
class PortReading(NamedTuple):
    """What a port did in the last tick."""

    on: str
    """The place, or "joint_limit" or "joint_speed"."""
    error: Array
    """(3,) from the place to its target, m, or the rotation vector, rad; one figure for arm angle and joint limits, and
    for a brake, rad/s beyond where it begins."""
    axes: Array
    """(3, 3) directions, base axes, along which the law acts: those of the base, or of the radial form."""
    peak: Array
    """(3,) largest error of the current divergence along each of these axes, m or rad."""
    converging: Array
    """(3,) bool: on the way back, along each of these axes."""
    force: Array
    """(3,) N or N m, without damping."""
    energy: float
    """Energy of the profile at the error, J; the port gives back no more than this."""
    power: float
    """Power into the arm, with damping, W."""
    joint: str | None
    """Name of the joint, of a joint limit or a brake."""

    def __repr__(self) -> str:
        error, force = (np.array2string(values, precision=4) for values in (self.error, self.force))
        where = self.on if self.joint is None else f"{self.on} of {self.joint}"
        return f"PortReading({where}: error {error}, force {force}, {self.energy:.3g} J, {self.power:.3g} W)"


class TorqueController:
    """Torques by superposition: J' h of every port, and the torque that holds the arm's weight.

    No matrix is inverted and no port is projected: the torque is finite in every configuration, and at most the sum of
    |J'| times the largest force of each port, with J in the axes of the port, and the weight.

    A port does nothing until it has a target. Until then the arm is held up, repelled by `limits` and braked by
    `speeds`, and not pulled anywhere.

    Args:
        arm: the arm; its masses count where `gravity` does.
        ports: the impedances, one a place at most; none to hold the weight alone.
        gravity: whether the weight of the arm is held.
        limits: repelling joint limits; True for the usual ones, None or False for none.
        max_torque: largest torque of each joint, N m, one or (7,); the arm's effort limits if not given.
        speeds: brakes on fast joints; True for those that begin at the arm's velocity limits, None or False for none.

    Raises:
        InvalidController: a thing of another class, two impedances on one place, or torques that are none; gravity
            and an arm without masses; or brakes whose figures the arm does not tell.
    """

    def __init__(
        self,
        arm: Arm,
        ports: Iterable[FractalImpedance],
        gravity: bool = True,
        limits: JointLimits | bool | None = None,
        max_torque: ArrayLike | None = None,
        speeds: JointSpeeds | bool | None = None,
    ) -> None:
        self.arm = thing(arm, Arm, "arm", "srs_ik.load")
        self.ports = things(ports, FractalImpedance, "ports")
        self.limits = _one_or_none(limits, JointLimits, "limits")
        self.speeds = _one_or_none(speeds, JointSpeeds, "speeds")
        places = [port.on for port in self.ports]
        for place in places:
            if places.count(place) > 1:
                raise InvalidController(f"{places.count(place)} ports are on {quoted(place)}: a place has one")
        if flag(gravity, "gravity"):
            try:
                require_masses(arm, "load a description with inertias, or pass gravity=False")
            except InvalidTask as error:
                raise InvalidController(str(error)) from None
        rows = [port.row() for port in self.ports]
        limits_at = self.limits.rows(arm.lower, arm.upper) if self.limits else []
        brakes = self.speeds.rows(arm) if self.speeds else []
        rows += limits_at + brakes
        self._names: list[tuple[str, str | None]] = [(place, None) for place in places]
        for name, guards in (("joint_limit", limits_at), ("joint_speed", brakes)):
            self._names += [(name, arm.joint_names[int(guard[at.JOINT])]) for guard in guards]
        self._rows = np.array(rows).reshape(-1, at.PORT)
        self._kinds = self._rows[: len(self.ports), at.KIND].copy()
        # A port without a target is a brake that begins at no speed.
        self._rows[: len(self.ports), at.KIND] = at.JOINT_SPEED
        self._rows[: len(self.ports), at.TARGET] = np.inf
        self._states = np.zeros((len(rows), at.STATE))
        self._bounds = np.append(_largest_torques(arm, max_torque), float(gravity))
        self._work = np.zeros((at.WORK, 7))
        self._motion = np.zeros((2, 7))
        self._family, self._weights = arm.packed.family, arm.packed.weights
        self.solution: Solution | None = None
        self.elbow_target = np.full(3, np.nan)
        self.restart()

    # Targets ----------------------------------------------------------------------------------------------------

    def set_target(
        self, pose: PoseLike, arm_angle: float | None = None, seed: ArrayLike | None = None, restart: bool = True
    ) -> Solution:
        """Aim at a pose: tip and orientation at the pose itself, elbow where `Arm.solve` puts it.

        Args:
            pose: wanted pose of the tip frame in the base frame; also one out of reach.
            arm_angle: rad; that of the posture that `Arm.solve` chooses, if not given. A port on the elbow or on the
                arm angle holds it.
            seed: (7,) posture to stay near, rad.
            restart: whether every port begins a new divergence, as after a jump; False for a target that moves on.

        Returns:
            The posture from which the elbow was taken, which is kept as `solution`.

        Raises:
            InvalidPose: the pose is no finite rigid transform.
            InvalidConfiguration: arm angle or seed are malformed.
            InvalidController: restart is neither True nor False, or no port holds what is given.
        """
        flag(restart, "restart")
        self._require_ports("a pose")
        if arm_angle is not None:
            self._require_ports("an arm angle", "elbow", "arm_angle")
        T = as_rigid_matrix(pose)
        self.solution = self.arm.solve(T, arm_angle=arm_angle, seed=seed)
        angle = self.solution.arm_angle if arm_angle is None else float(arm_angle)
        self._aim(T, self._elbow_at(self.solution.q), angle, restart)
        return self.solution

    def set_task(
        self, task: Task, side: Side = "left", restart: bool = True, respect_limits: bool = True, tie: Tie = "lower"
    ) -> Any:
        """Aim at a task of the paper: the tip where `Arm.solve_task` wants it, the elbow of its geometric posture.

        Args:
            task: one task.
            side: as for `Arm.solve_task`.
            restart: as for `set_target`.
            respect_limits: as for `Arm.solve_task`.
            tie: as for `Arm.solve_task`.

        Returns:
            The solution of `Arm.solve_task`, which is kept as `solution`.

        Raises:
            InvalidTask: no task, several at once, or another side.
            InvalidController: a flag is neither True nor False, or there are no ports.
        """
        flag(restart, "restart")
        flag(respect_limits, "respect_limits")
        self._require_ports("a task")
        found = self.arm.solve_task(task, side, respect_limits, tie)
        if np.ndim(found.q) != 1:
            raise InvalidTask("a controller takes one task at a time")
        self.solution = found  # type: ignore[assignment]
        T = found.T_base_tip
        self._aim(as_rigid_matrix(T), self._elbow_at(found.q), self.arm.arm_angle(found.q), restart)
        return found

    def set_posture(self, q: ArrayLike, restart: bool = True) -> None:
        """Aim at where tip and elbow are at (7,) joint angles, rad, for example those of a tracker or a path.

        Raises:
            InvalidConfiguration: not 7 finite angles, or one beyond 1e6 rad.
            InvalidController: restart is neither True nor False, or there are no ports.
        """
        flag(restart, "restart")
        self._require_ports("a posture")
        q = as_bounded_joint_vector(q)
        self._aim(self.arm.forward_kinematics(q).homogeneous, self._elbow_at(q), self.arm.arm_angle(q), restart)

    def set_elbow(self, point: ArrayLike) -> None:
        """Aim the elbow at a point (3,), m, base frame; tip and orientation keep their targets, or have none yet.

        Raises:
            InvalidController: not three finite figures, or no port is on the elbow.
        """
        where = vector(point, "point of the elbow")
        self._require_ports("a point of the elbow", "elbow")
        self._put({at.ELBOW: where})
        self.elbow_target = where

    def restart(self) -> None:
        """Forget all peaks: the next tick begins a new divergence at every port."""
        self._states[:] = 0.0
        self._states[:, at.LAST : at.LAST + 3] = -1.0
        self._states[:, at.SIZE] = -1.0

    # The tick ---------------------------------------------------------------------------------------------------

    def torque(self, q: ArrayLike, v: ArrayLike) -> Array:
        """Torques of the joints, (7,), N m.

        The ports take note of each call as of one period: ask once a period, in order.

        Args:
            q: (7,) joint angles, rad, none beyond 1e6 rad.
            v: (7,) joint speeds, rad/s, none beyond 1e6 rad/s.

        Raises:
            InvalidConfiguration: not 7 finite figures each, or one beyond these bounds.
        """
        motion = self._motion
        if _is_seven(q) and _is_seven(v):
            motion[0] = q
            motion[1] = v
        else:
            motion[0] = as_joint_vector(q, "q")
            motion[1] = as_joint_vector(v, "v")
        if not entries.tick(self._family, self._weights, self._rows, self._states, self._bounds, motion, self._work):
            as_bounded_joint_vector(motion[0])
            raise InvalidConfiguration(f"v must be 7 finite joint speeds, none beyond {at.LARGEST_SPEED:g} rad/s")
        return self._work[at.TORQUE].copy()

    @property
    def readings(self) -> list[PortReading]:
        """What every port did in the last tick, in the order of `ports`, then the joint limits, then the brakes."""
        return [
            PortReading(
                name,
                state[at.ERROR : at.ERROR + 3].copy(),
                np.eye(3) if port[at.PER_AXIS] else state[at.FRAME : at.FRAME + 9].reshape(3, 3).copy(),
                state[at.PEAK : at.PEAK + 3].copy(),
                state[at.CONVERGING : at.CONVERGING + 3] != 0.0,
                state[at.FORCE : at.FORCE + 3].copy(),
                float(state[at.ENERGY]),
                float(state[at.POWER]),
                joint,
            )
            for (name, joint), port, state in zip(self._names, self._rows, self._states, strict=True)
        ]

    @property
    def energy(self) -> float:
        """Energy of all profiles at their errors in the last tick, J."""
        return float(self._states[:, at.ENERGY].sum())

    @property
    def power(self) -> float:
        """Power of all ports into the arm in the last tick, W."""
        return float(self._states[:, at.POWER].sum())

    @property
    def gravity_torque(self) -> Array:
        """Torques that held the arm's weight in the last tick, (7,), N m; zero without gravity."""
        return self._work[at.WEIGHT].copy()

    def __repr__(self) -> str:
        held: list[str] = [port.on for port in self.ports]
        held += [what for what, given in (("joint limits", self.limits), ("joint speeds", self.speeds)) if given]
        held += ["weight"] if self._bounds[-1] else []
        return f"TorqueController({self.arm.name}: {', '.join(held) or 'nothing'})"

    def _require_ports(self, what: str, *places: str) -> None:
        """Raise InvalidController where no port is on one of some places, or on any: nothing would hold the target."""
        there = {port.on for port in self.ports}
        if not (there.intersection(places) if places else there):
            where = f" on {' or '.join(map(repr, places))}" if places else ""
            raise InvalidController(f"the controller has no port{where} that would hold {what}")

    def _elbow_at(self, q: Array) -> Array:
        return self.arm.centres(q).elbow

    def _aim(self, T: Array, elbow: Array, arm_angle: float, restart: bool) -> None:
        self.elbow_target = elbow
        self._put(
            {at.TIP: T[:3, 3], at.ORIENTATION: T[:3, :3].ravel(), at.ELBOW: elbow, at.ARM_ANGLE: np.array([arm_angle])}
        )
        if restart:
            self.restart()

    def _put(self, targets: dict[float, Array]) -> None:
        """Write targets into the rows of the ports, by kind."""
        for kind, port, state in zip(self._kinds, self._rows, self._states, strict=False):
            target = targets.get(float(kind))
            if target is not None:
                port[at.KIND] = kind
                port[at.TARGET : at.TARGET + target.size] = target
                state[at.MOVED] = 1.0


def _is_seven(values: Any) -> bool:
    return type(values) is np.ndarray and values.dtype.char == "d" and values.shape == (7,)


def _one_or_none(value: Any, kind: type[Usual], what: str) -> Usual | None:
    """What is given of a class, the usual one for True, None for None and False."""
    if isinstance(value, kind):
        return value
    if value is None or isinstance(value, bool):
        return kind() if value else None
    raise InvalidController(f"{what} has to be True, False, None or of class {kind.__name__}, not {quoted(value)}")


def _largest_torques(arm: Arm, given: Any) -> Array:
    """(7,) torques, N m, infinite where nothing limits them."""
    return np.array(arm.effort_limit) if given is None else seven_positive(given, "max_torque")
