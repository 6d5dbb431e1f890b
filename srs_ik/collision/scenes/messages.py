"""Objects from messages of ROS, as MoveIt sends them, told by their fields alone."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import zip_longest
from typing import Any, NamedTuple

import numpy as np

from srs_ik.collision.scenes.files import Given
from srs_ik.errors import InvalidPose, InvalidScene, listed, quoted
from srs_ik.inputs.messages import pose_matrix
from srs_ik.inputs.rotations import pose_of_xyz_rpy
from srs_ik.system.arrays import Array

_BOX, _SPHERE, _CYLINDER = 1, 2, 3
"""Types of shape_msgs/SolidPrimitive."""

ADD, REMOVE, MOVE = 0, 1, 3
"""Operations of a moveit_msgs/CollisionObject; a byte in Python's messages of ROS 2."""


class Told(NamedTuple):
    """What a message says of an object."""

    operation: int
    name: str
    place: Array  # (4, 4) of the object
    parts: list[Given]  # the shapes of one that is added
    shape_poses: list[Array]  # (4, 4) in the object, those that one that is moved gives its shapes


def of_message(message: Any) -> Iterator[Told]:
    """What a message says of objects: see `Scene.add_message`."""
    world = getattr(message, "world", message)
    objects = getattr(world, "collision_objects", None)
    _refuse_unread(message)
    if len(getattr(getattr(getattr(world, "octomap", None), "octomap", None), "data", ())):
        raise InvalidScene("the message has an octomap, which nothing reads; see Scene.add_points")
    if objects is not None:
        for each in objects:
            yield from of_message(each)
        return
    name = getattr(message, "id", None)
    if not isinstance(name, str):
        raise InvalidScene(f"a message of objects has an id, or collision_objects, unlike a {type(message).__name__}")
    operation = getattr(message, "operation", ADD)
    operation = operation[0] if isinstance(operation, bytes) and len(operation) == 1 else operation
    if operation not in (ADD, REMOVE, MOVE):
        raise InvalidScene(f"the message of {quoted(name)} neither adds, moves nor removes it: nothing else is read")
    place = _of(getattr(message, "pose", None), name)
    poses = [_of(pose, name) for which in ("primitive_poses", "mesh_poses") for pose in getattr(message, which, ())]
    if operation != ADD:
        yield Told(operation, name, place, [], poses)
        return
    parts = _parts(message, name, place)
    if len(parts) == len(poses) == 1 and np.array_equal(place, np.eye(4)):
        # As in MoveIt, an object of one shape that says only where that is, is itself there.
        place = poses[0]
    yield Told(operation, name, place, parts, [])


def _parts(message: Any, name: str, outer: Array) -> list[Given]:
    """The shapes of an object, by its name, or if there are several by that and their numbers."""
    if len(getattr(message, "planes", ())):
        raise InvalidScene(f"{quoted(name)} has planes, which nothing reads; see Scene.add_half_space")
    primitives = _shapes(message, "primitives", "primitive_poses", name)
    meshes = _shapes(message, "meshes", "mesh_poses", name)
    several = len(primitives) + len(meshes) > 1
    if not primitives and not meshes:
        raise InvalidScene(f"{quoted(name)} has neither primitives nor meshes")
    parts = []
    for k, (primitive, T) in enumerate(primitives):
        parts.append(_primitive(f"{name}/{k}" if several else name, outer @ T, primitive))
    for k, (mesh, T) in enumerate(meshes, len(primitives)):
        vertices = [(v.x, v.y, v.z) for v in mesh.vertices]
        faces = np.array([tuple(t.vertex_indices) for t in mesh.triangles], dtype=np.int64)
        parts.append(Given("triangles", (f"{name}/{k}" if several else name, outer @ T, vertices, faces)))
    return parts


def _refuse_unread(message: Any) -> None:
    """Refuse a moveit_msgs/PlanningScene with what counts there and would not count here."""
    attached = getattr(getattr(message, "robot_state", None), "attached_collision_objects", ())
    if len(attached):
        names = listed([str(getattr(getattr(each, "object", None), "id", "?")) for each in attached])
        raise InvalidScene(f"the robot of the message holds {names}: give them to Arm.with_object, and its world here")
    for what, plain in (("padding", 0.0), ("scale", 1.0)):
        for link in getattr(message, f"link_{what}", ()):
            if getattr(link, what, plain) != plain:
                said = f"link_{what} of {quoted(getattr(link, 'link_name', '?'))}"
                raise InvalidScene(
                    f"the message has {said}, which nothing reads: give a Scene a margin, and its world here"
                )


def _shapes(message: Any, what: str, places: str, name: str) -> list[tuple[Any, Array]]:
    """Shapes with their poses in the object; as in MoveIt, one without a pose is where the object is."""
    shapes, poses = list(getattr(message, what, ())), list(getattr(message, places, ()))
    if len(poses) > len(shapes):
        raise InvalidScene(f"{quoted(name)} has {len(shapes)} {what} and {len(poses)} {places}")
    return [(shape, _of(pose, name)) for shape, pose in zip_longest(shapes, poses)]


def _of(pose: Any, name: str) -> Array:
    """(4, 4) of a pose of an object; as in MoveIt, one that nobody has set is the identity, and so is a turn."""
    if pose is None:
        return np.eye(4)
    turn, place = getattr(pose, "orientation", None), getattr(pose, "position", None)
    try:
        if all(getattr(turn, axis, None) == 0.0 for axis in "xyzw"):
            xyz = [getattr(place, axis, np.nan) for axis in "xyz"]
            found: Array | None = pose_of_xyz_rpy(xyz, (0.0, 0.0, 0.0)).homogeneous
        else:
            found = pose_matrix(pose)
    except InvalidPose as error:
        raise InvalidScene(f"pose of {quoted(name)}: {error}") from None
    if found is None:
        raise InvalidScene(f"pose of {quoted(name)} is no pose of geometry_msgs")
    return found


def _primitive(name: str, T: Array, primitive: Any) -> Given:
    sizes = list(getattr(primitive, "dimensions", ()))
    kind = getattr(primitive, "type", None)
    if kind == _BOX:
        return Given("box", (name, T, sizes))
    if kind == _SPHERE and len(sizes) == 1:
        return Given("sphere", (name, T[:3, 3], sizes[0]))
    if kind == _CYLINDER and len(sizes) == 2:
        # Its height comes first.
        return Given("cylinder", (name, T, sizes[1], sizes[0]))
    raise InvalidScene(f"{quoted(name)} is of type {kind!r} with {len(sizes)} sizes; known are box, sphere, cylinder")
