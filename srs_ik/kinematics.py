"""Forward kinematics, Jacobian and the measure of a pose: Pinocchio on the 7 joints of the description itself."""

from __future__ import annotations

import math
import os
import threading
import warnings
from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray

from srs_ik.errors import InvalidConfiguration, InvalidRobot, SrsIkError, did_you_mean, quoted
from srs_ik.inputs.angles import as_joint_vector
from srs_ik.inputs.fixed import Fixed
from srs_ik.inputs.messages import picked, positions_by_name
from srs_ik.inputs.numbers import array_or_empty, real_number
from srs_ik.inputs.poses import PoseError, PoseLike, as_rigid_matrix
from srs_ik.robot.chain import Chain
from srs_ik.robot.locked import configuration_of
from srs_ik.robot.skeleton import is_revolute
from srs_ik.system.arrays import Array

_ELSEWHERE = 1e-3
"""Rad or m by which a joint between base and tip may be measured elsewhere than an arm has it locked."""


def check_arm(arm: Any, error: type[SrsIkError] = InvalidRobot) -> None:
    """Raise the error for what is no arm, such as its name or its file, before anything is asked of it."""
    if not isinstance(arm, ChainKinematics):
        hint = "; load it first" if isinstance(arm, str | os.PathLike) else ""
        raise error(f"an arm is what srs_ik.load gives, not {quoted(arm)}{hint}")


class ChainKinematics(Fixed):
    """The 7 joints between two frames, as Pinocchio computes them; nothing here knows of a shoulder or a wrist.

    Attributes:
        base: name of the base frame.
        tip: name of the tip frame.
        joint_names: the 7 joint names, from shoulder to wrist.
        lower: (7,) lower joint limits, rad; -inf where continuous.
        upper: (7,) upper joint limits, rad; inf where continuous.
        velocity_limit: (7,) rad/s; inf where the description gives none.
        effort_limit: (7,) N m; inf where the description gives none.
        acceleration_limit: (7,) rad/s^2; inf where nobody gives one, as descriptions have none.
        model: `pinocchio.Model` of the 7 joints. Its root need not be `base`: poses here are those of
            `oMf[base].inverse() * oMf[tip]`.
        held_mass: mass of what the hand holds, which `model` has with joint 7, kg; see `Arm.with_object`.
    """

    _fixed = frozenset(
        {"name", "base", "tip", "joint_names", "lower", "upper", "velocity_limit", "effort_limit", "acceleration_limit"}
        | {"model", "held_mass"}
    )

    def __init__(self, chain: Chain, name: str) -> None:
        self.name = name
        self.base = chain.base
        self.tip = chain.tip
        self.joint_names = chain.joint_names
        self.lower = chain.lower
        self.upper = chain.upper
        self.velocity_limit = chain.velocity_limit
        self.effort_limit = chain.effort_limit
        self.acceleration_limit = chain.acceleration_limit
        self.model = chain.model
        self.held_mass = chain.load
        self._locked = chain.locked
        self._between = chain.between
        self._base_frame = chain.base_id
        self._tip_frame = chain.tip_id

    @property
    def locked(self) -> dict[str, float]:
        """Where other joints of the robot stand that were not locked at zero, by name, rad or m."""
        return dict(self._locked)

    @property
    def still_joints(self) -> tuple[str, ...]:
        """Names of the other joints between base and tip, all of which are locked."""
        return tuple(self._between)

    def configuration(self, q: ArrayLike, model: Any = None, others: ArrayLike | None = None) -> Array:
        """Pinocchio's configuration (model.nq,) of 7 joint angles: a continuous joint is its cosine and sine there.

        Args:
            q: (7,) joint angles, rad.
            model: `pinocchio.Model` of the whole robot, which has these joints by name; that of the arm if not given.
            others: (model.nq,) configuration of that robot, for its other joints; if not given, where the arm has them
                locked. Those between base and tip are no farther from there than 0.001 rad or m.

        Raises:
            InvalidConfiguration: not 7 finite angles, a model that lacks one of the joints, or others of another size,
                or with which the tip would not be where the arm has it.
        """
        q = as_joint_vector(q, limits=(self.lower, self.upper))
        if model is None and others is not None:
            raise InvalidConfiguration("others are those of a whole robot: give its model, too")
        places = self._places if model is None else _places_of(self._joints_in(model))
        configuration = np.empty(self.model.nq) if model is None else self._whole(model, others)
        (plain, at), (endless, cosines) = places
        configuration[at] = q[plain]
        if len(endless):
            configuration[cosines], configuration[cosines + 1] = np.cos(q[endless]), np.sin(q[endless])
        return configuration

    def _whole(self, model: Any, others: ArrayLike | None) -> Array:
        """A configuration of a whole robot that its caller may write into."""
        if others is None:
            known = set(model.names)
            return configuration_of(model, {name: x for name, x in self._locked.items() if name in known})
        whole = _finite(others, model)
        for said in self._elsewhere(model, whole):
            raise InvalidConfiguration(said)
        return whole

    def _elsewhere(self, model: Any, whole: Array) -> Iterator[str]:
        """What is said of joints between base and tip that are elsewhere in a whole robot than the arm has them."""
        known = {name: model.joints[k] for k, name in enumerate(model.names)} if self._between else {}
        for name, at in self._between.items():
            joint = known.get(name)
            if joint is not None and joint.nq == len(at):
                said = _elsewhere(name, whole[joint.idx_q : joint.idx_q + joint.nq], at)
                if said:
                    yield said

    def angles(self, configuration: ArrayLike, model: Any = None) -> Array:
        """7 joint angles of a configuration (model.nq,) of Pinocchio; those of continuous joints in [-pi, pi].

        A warning says where a joint between base and tip is elsewhere than the arm has it: the tip is not where
        `forward_kinematics` says, then.

        Args:
            configuration: of the model.
            model: `pinocchio.Model` of the whole robot, which has these joints by name; that of the arm if not given.

        Raises:
            InvalidConfiguration: not model.nq finite numbers, or a model that lacks one of the joints.
        """
        joints = self._joints if model is None else self._joints_in(model)
        values = _finite(configuration, self.model if model is None else model)
        for said in self._elsewhere(model, values) if model is not None else ():
            warnings.warn(said, UserWarning, stacklevel=2)
        return np.array(
            [values[j.idx_q] if j.nq == 1 else np.arctan2(values[j.idx_q + 1], values[j.idx_q]) for j in joints]
        )

    def _joints_in(self, model: Any) -> list[Any]:
        """The seven joints, by their names, in the model of a whole robot."""
        if not isinstance(model, pin.Model):
            raise InvalidConfiguration(f"the whole robot is a pinocchio.Model, not {type(model).__name__}")
        names = list(model.names)
        for name in self.joint_names:
            if name not in names:
                hint = did_you_mean(name, names)
                raise InvalidConfiguration(f"the model {model.name!r} has no joint {name!r}{hint}")
        joints = [model.joints[names.index(name)] for name in self.joint_names]
        for name, joint in zip(self.joint_names, joints, strict=True):
            if not is_revolute(joint):
                raise InvalidConfiguration(f"joint {name!r} of the model {model.name!r} does not turn about one axis")
        return joints

    def joint_vector(self, state: Any) -> Array:
        """7 joint angles out of a joint state, by the names of the joints; other joints in it are left out.

        A warning says where one of these is between base and tip, and elsewhere than the arm has it.

        Args:
            state: a mapping from joint names to angles, such as `Solution.as_dict` gives, or an object with the fields
                `name` and `position`, such as a JointState of sensor_msgs; rad.

        Raises:
            InvalidConfiguration: one of the 7 joints is missing, or its angle is no finite number.
        """
        positions = positions_by_name(state)
        q = as_joint_vector(picked(positions, self.joint_names), "the joint state")
        for name in self._between.keys() & positions.keys():
            at, there = self._between[name], real_number(positions[name])
            # Pinocchio has the cosine and the sine of a joint that turns without end.
            said = _elsewhere(name, np.array([np.cos(there), np.sin(there)] if len(at) == 2 else [there]), at)
            if said:
                warnings.warn(said, UserWarning, stacklevel=2)
        return q

    def forward_kinematics(self, q: ArrayLike) -> pin.SE3:
        """Pose of the tip frame in the base frame.

        Raises:
            InvalidConfiguration: not 7 finite angles.
        """
        data = self._data
        pin.forwardKinematics(self.model, data, self.configuration(q))
        T_world_base = pin.updateFramePlacement(self.model, data, self._base_frame)
        return T_world_base.actInv(pin.updateFramePlacement(self.model, data, self._tip_frame))

    def joint_frames(self, q: ArrayLike) -> Array:
        """(8, 4, 4) poses in the base frame: of the root of the robot, which stands still, and of the 7 joints.

        Raises:
            InvalidConfiguration: not 7 finite angles.
        """
        data = self._data
        pin.forwardKinematics(self.model, data, self.configuration(q))
        T_world_base = pin.updateFramePlacement(self.model, data, self._base_frame)
        return np.stack([T_world_base.actInv(T_world_joint).homogeneous for T_world_joint in data.oMi])

    def joint_places(self, q: ArrayLike, joints: Iterable[int]) -> list[pin.SE3]:
        """Poses in the base frame of some of what `joint_frames` gives: 0 is the root of the robot, 1 to 7 the joints.

        Raises:
            InvalidConfiguration: not 7 finite angles.
        """
        data = self._data
        pin.forwardKinematics(self.model, data, self.configuration(q))
        T_world_base = pin.updateFramePlacement(self.model, data, self._base_frame)
        return [T_world_base.actInv(data.oMi[joint]) for joint in joints]

    def jacobian(self, q: ArrayLike) -> Array:
        """Geometric Jacobian (6, 7) of the tip point in base axes: linear rows (m/s per rad/s) first, then angular.

        Raises:
            InvalidConfiguration: not 7 finite angles.
        """
        data = self._data
        J = pin.computeFrameJacobian(
            self.model, data, self.configuration(q), self._tip_frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        )
        R_base_world = pin.updateFramePlacement(self.model, data, self._base_frame).rotation.T
        return np.vstack([R_base_world @ J[:3], R_base_world @ J[3:]])

    def verify(self, pose: PoseLike, q: ArrayLike) -> PoseError:
        """Distance and angle between the tip at q and a pose, by Pinocchio.

        The angle is taken from sine and cosine together: by arc cosine alone, as the paper has it (erratum 8), errors
        end at 3e-8 rad.

        Raises:
            InvalidPose: the pose is no finite rigid transform.
            InvalidConfiguration: not 7 finite angles.
        """
        T_base_wanted = as_rigid_matrix(pose)
        T_base_tip = self.forward_kinematics(q)
        turn = T_base_tip.rotation.T @ T_base_wanted[:3, :3]
        skew = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
        return PoseError(
            math.hypot(*(T_base_wanted[:3, 3] - T_base_tip.translation).tolist()),
            float(np.arctan2(np.linalg.norm(skew), np.trace(turn) - 1.0)),
        )

    @cached_property
    def _joints(self) -> list[Any]:
        return [self.model.joints[i] for i in range(1, 8)]

    @cached_property
    def _places(self) -> list[tuple[NDArray[np.intp], NDArray[np.intp]]]:
        return _places_of(self._joints)

    @cached_property
    def _thread_data(self) -> threading.local:
        return threading.local()

    @property
    def _data(self) -> Any:
        """Pinocchio's work space, one for each thread."""
        local = self._thread_data
        if not hasattr(local, "data"):
            local.data = self.model.createData()
        return local.data


def _elsewhere(name: str, there: Array, at: Sequence[float]) -> str:
    """What is wrong where a joint between base and tip is elsewhere than the arm has it; empty where nothing is."""
    if np.abs(there - at).max(initial=0.0) <= _ELSEWHERE:
        return ""
    where = "is not where"
    if len(at) <= 2:
        said, meant = (x[0] if len(at) == 1 else math.atan2(x[1], x[0]) for x in (there, at))
        where = f"is at {said:g}, not at {meant:g} where"
    return (
        f"joint {name!r}, between base and tip, {where} the arm has it; load takes its position as "
        "locked={joint: position}"
    )


def _finite(configuration: ArrayLike, model: Any) -> Array:
    """A configuration (model.nq,) as a new array of floats; raises InvalidConfiguration for anything else."""
    values = array_or_empty(configuration)
    if values.shape != (model.nq,) or not np.isfinite(values).all():
        raise InvalidConfiguration(f"a configuration of {model.name} is {model.nq} finite numbers")
    return values


def _places_of(joints: Sequence[Any]) -> list[tuple[NDArray[np.intp], NDArray[np.intp]]]:
    """Joints with one figure in a configuration, and those with cosine and sine: which, and where that begins."""
    kinds = [[(k, joint.idx_q) for k, joint in enumerate(joints) if joint.nq == size] for size in (1, 2)]
    return [(rows[:, 0], rows[:, 1]) for rows in (np.array(kind, np.intp).reshape(-1, 2) for kind in kinds)]
