"""The joints and frames of a robot: which chains of revolute joints there are, and their axes as lines."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import pinocchio as pin

from srs_ik.errors import FrameNotFound, InvalidRobot
from srs_ik.robot.limb import Vector

_REVOLUTE = ("JointModelRX", "JointModelRY", "JointModelRZ", "JointModelRevoluteUnaligned")
_CONTINUOUS = ("JointModelRUBX", "JointModelRUBY", "JointModelRUBZ", "JointModelRevoluteUnboundedUnaligned")
_PRISMATIC = ("JointModelPX", "JointModelPY", "JointModelPZ", "JointModelPrismatic")

_FRAME_PREFERENCE = (
    pin.FrameType.BODY,
    pin.FrameType.OP_FRAME,
    pin.FrameType.FIXED_JOINT,
    pin.FrameType.SENSOR,
    pin.FrameType.JOINT,
)
"""Which frame a name means where several kinds bear it: links first, as links and joints often share names."""


@dataclass(frozen=True, eq=False)
class Lines:
    """Joint axes as lines, and the tip, at the zero configuration in the base frame; shapes as in `Chain`."""

    axes: Vector
    points: Vector
    T_base_tip_zero: Vector


@dataclass(frozen=True)
class _Frame:
    name: str
    rank: int
    joint: int
    parent: int


class Skeleton:
    """The joints and frames of a robot, looked up once for any number of questions.

    It stands in its neutral configuration, or in the one that is given.
    """

    def __init__(self, model: Any, configuration: Vector | None = None) -> None:
        self.model = model
        self.joint_names: tuple[str, ...] = tuple(model.names)
        self.parents: tuple[int, ...] = tuple(int(parent) for parent in model.parents)
        self._above: list[list[int]] = [[] for _ in self.parents]
        for joint, parent in enumerate(self.parents[1:], 1):
            self._above[parent].append(joint)
        self._data = model.createData()
        self._J_world = pin.computeJointJacobians(
            model, self._data, pin.neutral(model) if configuration is None else configuration
        )
        pin.updateFramePlacements(model, self._data)
        ranks = {kind: rank for rank, kind in enumerate(_FRAME_PREFERENCE)}
        self._frames = [_Frame(f.name, ranks[f.type], int(f.parentJoint), int(f.parentFrame)) for f in model.frames]
        self._below: dict[tuple[int, int], list[int]] = {}
        # The first frame is the universe, which is its own parent.
        for k, frame in enumerate(self._frames[1:], 1):
            self._below.setdefault((frame.parent, frame.rank), []).append(k)
        self._revolute = [is_revolute(joint) for joint in model.joints]
        joint_rank = ranks[pin.FrameType.JOINT]
        self._own_frame = {
            f.joint: k
            for k, f in enumerate(self._frames)
            if f.rank == joint_rank and f.name == self.joint_names[f.joint]
        }

    def is_revolute(self, joint: int) -> bool:
        """True if a joint turns about one fixed axis, with or without stops."""
        return self._revolute[joint]

    def limits(self, joint: int) -> tuple[float, float]:
        """The position limits of a revolute joint, rad; infinite where it is continuous."""
        return limits_of(self.model, self.model.joints[joint])

    def what_is(self, joint: int) -> str:
        """What a joint that is not revolute is, as a clause."""
        return "is prismatic" if is_prismatic(self.model.joints[joint]) else "is not revolute"

    def hanging_on(self, joint: int) -> tuple[int, ...]:
        """The joints of any kind of which a joint is the parent."""
        return tuple(self._above[joint])

    def path(self, joint: int) -> list[int]:
        """The joints from the root of the robot to a joint, itself included."""
        found = []
        while joint > 0:
            found.append(joint)
            joint = self.parents[joint]
        return found[::-1]

    def windows(self, excluded: Collection[str] = ()) -> list[tuple[int, ...]]:
        """Indices of every run of seven revolute joints of which each is the parent of the next, by the last one.

        Joints that are excluded by name cannot take part, such as those that mimic another one.
        """
        return [run[-7:] for run in self._runs(excluded) if len(run) >= 7]

    def longest_run(self, excluded: Collection[str]) -> tuple[int, ...]:
        """The most revolute joints in a row, as for `windows`; the first of equals."""
        return max(self._runs(excluded), key=len, default=())

    def _runs(self, excluded: Collection[str]) -> list[tuple[int, ...]]:
        """For each joint the revolute joints in a row that end with it, from the base outwards; maybe none."""
        runs: list[tuple[int, ...]] = [()]
        for joint, name in enumerate(self.joint_names[1:], 1):
            usable = self._revolute[joint] and name not in excluded
            runs.append((*runs[self.parents[joint]], joint) if usable else ())
        return runs

    def oddity(self, joints: Sequence[int]) -> int:
        """How unlike a limb a run of consecutive joints lies in its robot: 0 where it begins and ends as limbs do.

        Limbs begin at the root, at a fork or behind a sliding joint, do not fork on the way, and end where nothing, a
        fork or a joint that is not revolute follows. Every exception counts 1.
        """
        before, after = self.parents[joints[0]], self._above[joints[-1]]
        begins_within = before != 0 and self._revolute[before] and len(self._above[before]) == 1
        ends_within = len(after) == 1 and self._revolute[after[0]]
        forks = sum(len(self._above[joint]) > 1 for joint in joints[:-1])
        return int(begins_within) + int(ends_within) + forks

    def find_frame(self, name: str) -> int:
        """Index of the frame of a name; a link is preferred to a joint or sensor of the same name."""
        found = frame_of(self.model, name)
        if found is None:
            raise FrameNotFound(name, self.frame_names(), robot=self.model.name)
        return found

    def has_frame(self, name: str) -> bool:
        """True if `find_frame` knows a name."""
        return any(frame.name == name for frame in self._frames)

    def frame_names(self) -> list[str]:
        """Names that `find_frame` knows, links first, each once."""
        ranked = sorted(self._frames[1:], key=lambda frame: frame.rank)
        return list(dict.fromkeys(frame.name for frame in ranked))

    def frames_on(self, joint: int) -> list[str]:
        """Names of the links and sites that a joint carries, without those behind other joints."""
        kinds = [_FRAME_PREFERENCE.index(kind) for kind in (pin.FrameType.BODY, pin.FrameType.OP_FRAME)]
        return [frame.name for frame in self._frames if frame.joint == joint and frame.rank in kinds]

    def joint_of(self, frame: str) -> int:
        """Index of the joint that carries a frame, 0 for a frame that no joint moves."""
        return self._frames[self.find_frame(frame)].joint

    def joints_between(self, base: str, tip: str) -> list[int]:
        """Joints that move the tip frame but not the base frame, from the base outwards."""
        below = self.path(self.joint_of(base))
        return [joint for joint in self.path(self.joint_of(tip)) if joint not in below]

    def default_base(self, joint: int) -> str:
        """Name of the link that carries a joint.

        Raises:
            InvalidRobot: the model was made without frames there, so the base frame has to be named.
        """
        own = self._own_frame.get(joint)
        if own is not None:
            return self._frames[self._frames[own].parent].name
        return self._frame_on(self.parents[joint], "base")

    def default_tip(self, joint: int) -> str:
        """Name of the outermost link that is surely the hand of a joint.

        From the link that the joint moves, the way goes on as long as there is exactly one child link and it is
        attached by a fixed joint; it ends at a fork and before a moving joint.

        Raises:
            InvalidRobot: the model was made without frames there, so the tip frame has to be named.
        """
        start = self._own_frame.get(joint)
        if start is None:
            return self._frame_on(joint, "tip")
        links = self._children(start, pin.FrameType.BODY)
        if not links:
            return self._frames[start].name
        tip = links[0]
        while True:
            fixed = self._children(tip, pin.FrameType.FIXED_JOINT)
            if len(fixed) != 1 or self._children(tip, pin.FrameType.JOINT):
                break
            links = self._children(fixed[0], pin.FrameType.BODY)
            if len(links) != 1:
                break
            (tip,) = links
        return self._frames[tip].name

    def ends_of(self, names: Collection[str]) -> tuple[str, str] | None:
        """The link that carries the first of some joints in one line, and the link that the last one moves.

        Joints, fixed ones too, are named themselves or by their links. None where they are not in one line, or some are
        not of this robot.
        """
        body, joint = (_FRAME_PREFERENCE.index(kind) for kind in (pin.FrameType.BODY, pin.FrameType.JOINT))
        fixed = _FRAME_PREFERENCE.index(pin.FrameType.FIXED_JOINT)
        own = {f.name: k for k, f in enumerate(self._frames) if f.rank in (joint, fixed)}
        links = {f.name: f.parent for f in self._frames if f.rank == body}
        found = [own.get(name, links.get(name, 0)) for name in names]
        ways = sorted((self._frames_above(k) for k in found), key=len)
        if not ways or 0 in found or any(way[-1] not in longer for way, longer in pairwise(ways)):
            return None
        first, last = ways[0][-1], ways[-1][-1]
        moved = self._children(last, pin.FrameType.BODY)
        return self._frames[self._frames[first].parent].name, self._frames[moved[0] if moved else last].name

    def _frames_above(self, frame: int) -> list[int]:
        """Frames from the root to one, itself included."""
        found = []
        while frame > 0:
            found.append(frame)
            frame = self._frames[frame].parent
        return found[::-1]

    def carries(self, frame: str, joint: int) -> bool:
        """True if a frame lies on the way from the root of the robot to a joint, so that the joint hangs on it."""
        wanted, own = self.find_frame(frame), self._own_frame.get(joint)
        if own is None:
            return self._frames[wanted].joint in (0, *self.path(self.parents[joint]))
        above = self._frames[own].parent
        while above not in (wanted, 0):
            above = self._frames[above].parent
        return above == wanted

    def measure(self, joints: Sequence[int], base: str, tip: str) -> Lines:
        """The axes of revolute joints between two frames as lines, by Pinocchio's Jacobian."""
        T_base_world = self._data.oMf[self.find_frame(base)].inverse()
        # Columns of joints that mimic another are there too, where Pinocchio has them as such.
        columns = [self.model.joints[joint].idx_vExtended for joint in joints]
        axes = (T_base_world.rotation @ self._J_world[3:, columns]).T
        points = np.array([T_base_world.act(self._data.oMi[joint].translation) for joint in joints])
        return Lines(axes, points, self.transform(base, tip))

    def transform(self, to: str, frame: str) -> Vector:
        """(4, 4) pose of one frame in another."""
        T_world_to, T_world_frame = (self._data.oMf[self.find_frame(name)] for name in (to, frame))
        return T_world_to.actInv(T_world_frame).homogeneous

    def _children(self, frame: int, kind: Any) -> list[int]:
        return self._below.get((frame, _FRAME_PREFERENCE.index(kind)), [])

    def _frame_on(self, joint: int, end: str) -> str:
        """Some frame on a joint of a model that has no frames for its joints."""
        if joint == 0:
            return self._frames[0].name
        on_joint = sorted((frame.rank, k) for k, frame in enumerate(self._frames) if frame.joint == joint)
        if not on_joint:
            name = self.model.name
            message = f"the model {name!r} has no frame on joint {self.joint_names[joint]!r}: add one, to be its {end}"
            raise InvalidRobot(message, name)
        return self._frames[on_joint[0][1]].name


def frame_of(model: Any, name: str) -> int | None:
    """Index of the frame of a name in a ``pinocchio.Model``, links first; None where there is none."""
    found = [(_FRAME_PREFERENCE.index(frame.type), k) for k, frame in enumerate(model.frames) if frame.name == name]
    return min(found)[1] if found else None


def is_revolute(joint: Any) -> bool:
    """True if a joint of a ``pinocchio.Model`` turns about one fixed axis, with or without stops."""
    return joint.shortname() in _REVOLUTE + _CONTINUOUS


def is_prismatic(joint: Any) -> bool:
    """True if a joint of a ``pinocchio.Model`` slides along one fixed axis."""
    return str(joint.shortname()).startswith(_PRISMATIC)


def limits_of(model: Any, joint: Any) -> tuple[float, float]:
    """Position limits of a joint of a ``pinocchio.Model``, rad or m; infinite where it has no single position."""
    if joint.nq != 1:
        return -np.inf, np.inf
    return float(model.lowerPositionLimit[joint.idx_q]), float(model.upperPositionLimit[joint.idx_q])
