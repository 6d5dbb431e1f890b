"""Another arm as an object of a scene: its links where it stands."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from srs_ik.collision.scenes.figures import as_name, as_pose
from srs_ik.collision.scenes.thing import Thing, ball_of
from srs_ik.errors import InvalidScene, quoted
from srs_ik.inputs.poses import PoseLike
from srs_ik.kernels.layout import collision as at
from srs_ik.kinematics import check_arm
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.collision.links.bodies import Body


class Bodied(Protocol):
    """What a scene asks of an arm that stands in it."""

    name: str
    model: Any
    joint_names: tuple[str, ...]
    locked: dict[str, float]

    @property
    def bodies(self) -> list[Body]:
        """The links of the arm, and what it holds."""

    def joint_frames(self, q: ArrayLike) -> Array:
        """(8, 4, 4) frames of the root and of the joints in the base frame."""


def thing_of_arm(name: str, other: Bodied, q: ArrayLike, pose: PoseLike | None, beside: Bodied | None) -> Thing:
    """An arm at joint angles, by the pose of its base or beside an arm of the same robot: see `Scene.add_arm`."""
    if (pose is None) == (beside is None):
        raise InvalidScene(f"where {quoted(name)} stands is given by a pose, or by an arm of the same robot: beside=")
    for each in (other,) if beside is None else (other, beside):
        check_arm(each, InvalidScene)
    frames = other.joint_frames(q)
    T = as_pose(pose, name) if beside is None else beside.joint_frames(np.zeros(7))[0] @ np.linalg.inv(frames[0])
    thing = Thing(as_name(name), T)
    bodies = other.bodies if beside is None else [body for body in other.bodies if body.joint]
    if beside is not None:
        thing.replaces = frozenset(body.name for body in bodies)
        if thing.replaces.isdisjoint(frame.name for frame in beside.model.frames):
            raise InvalidScene(
                f"{quoted(name)} is of another robot: {beside.name} has none of its links; give its pose instead"
            )
        _check_stands_as(name, other, beside)
    for body in bodies:
        F = frames[body.joint]
        rows = np.column_stack([body.spheres[:, :3] @ F[:3, :3].T + F[:3, 3], body.spheres[:, 3]])
        label = f"{thing.name}/{body.name}"
        thing.add(at.SPHERES, rows, ball_of(rows), label)
        thing.parts.append((label, tuple(form.moved(F) for form in body.forms)))
    return thing


def _check_stands_as(name: str, other: Bodied, beside: Bodied) -> None:
    """Raise InvalidScene where two arms of one robot share joints, or have its other joints in different places."""
    own = {*other.joint_names, *beside.joint_names}
    if len(own) < len(other.joint_names) + len(beside.joint_names):
        raise InvalidScene(f"{quoted(name)} has joints of {beside.name} itself, which cannot be beside itself")
    for joint in sorted({*other.locked, *beside.locked} - own):
        here, there = beside.locked.get(joint, 0.0), other.locked.get(joint, 0.0)
        if here != there:
            raise InvalidScene(
                f"joint {joint!r} stands at {here:g} for {beside.name} and at {there:g} for {quoted(name)}: "
                f"load both with locked={{{joint!r}: ...}}"
            )
