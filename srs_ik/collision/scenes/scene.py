"""What stands around an arm: named objects that can be moved, and what is to be left between them and the arm."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike

from srs_ik.collision.forms import Form, ball_around, frame_along, planes, row_of_spheres
from srs_ik.collision.scenes.figures import (
    as_faces,
    as_margin,
    as_name,
    as_points,
    as_pose,
    as_positive,
    as_size,
    as_vector,
    triangles_of,
    warn_of_a_large_box,
    warn_of_millimetres,
)
from srs_ik.collision.scenes.standing_arm import Bodied, thing_of_arm
from srs_ik.collision.scenes.thing import CELL, Thing, ball_of, cells_of
from srs_ik.errors import InvalidScene, did_you_mean, listed, quoted
from srs_ik.inputs.fixed import Fixed
from srs_ik.inputs.numbers import as_flag
from srs_ik.inputs.poses import PoseLike
from srs_ik.kernels.layout import collision as at
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.collision.scenes.files import Given
    from srs_ik.collision.scenes.messages import Told

MESH_SPHERES = 96
"""Spheres that cover a mesh, about."""


def check_scene(scene: Any) -> None:
    """Raise InvalidScene for what is no scene."""
    if not isinstance(scene, Scene):
        raise InvalidScene(f"a scene is a srs_ik.Scene, not {quoted(scene)}")


class Scene(Fixed):
    """What an arm must not touch, in the base frame of the arm; metres and radians.

    Without objects, it is the arm's own bodies that count. Every object has a name and can be moved. Answers with
    ``scene=`` keep clear of it by its margin and that of the question together.

    Boxes and cylinders count as convex solids between planes; where a sphere comes to their edges and corners they keep
    it farther away than need be, by less than an eighth of its radius. Capsules are rows of spheres, meshes are covered
    by spheres, and points are spheres.

    Args:
        exact: whether real shapes count, by coal, and not the spheres that cover the links; this takes longer.
        margin: m, to be left everywhere.

    Raises:
        InvalidScene: the margin is no finite number, or negative.
    """

    _closed = True

    version = 0
    """Changes with the objects that there are."""
    moves = 0
    """Changes with where they are."""

    def __init__(self, exact: bool = False, margin: float = 0.0) -> None:
        self.exact = exact
        self.margin = margin
        self._things: dict[str, Thing] = {}
        # Of objects that messages have told of, their shapes by name, and where these are in the object.
        self._told: dict[str, dict[str, Array]] = {}

    @property
    def exact(self) -> bool:
        """Whether real shapes count; may be set."""
        return self._exact

    @exact.setter
    def exact(self, exact: bool) -> None:
        self._exact = as_flag(exact, "exact", InvalidScene)

    @property
    def margin(self) -> float:
        """What is to be left everywhere, m; may be set."""
        return self._margin

    @margin.setter
    def margin(self, margin: float) -> None:
        self._margin = as_margin(margin)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the objects, in the order in which they were added."""
        return tuple(self._things)

    def __len__(self) -> int:
        return len(self._things)

    def __iter__(self) -> Iterator[Thing]:
        return iter(self._things.values())

    def __contains__(self, name: object) -> bool:
        return name in self._things

    def add_sphere(self, name: str, centre: ArrayLike, radius: float) -> None:
        """Add a sphere of a radius, m, about a centre (3,) in the base frame, m.

        Raises:
            InvalidScene: the name is taken, or the figures are not finite or not positive.
        """
        T = np.eye(4)
        T[:3, 3] = as_vector(centre, 3, f"centre of {quoted(name)}")
        self._add_form(name, T, "sphere", (as_positive(radius, f"radius of {quoted(name)}"),))

    def add_box(self, name: str, pose: PoseLike, size: ArrayLike) -> None:
        """Add a box about the origin of a pose; size (3,) are its edges, m.

        One longer than 30 m and nowhere thinner than 1 m gets a warning: it may be in millimetres.

        Raises:
            InvalidScene: the name is taken, the pose is none, or an edge is not positive and finite.
        """
        what = f"size of {quoted(name)}"
        edges = tuple(as_positive(edge, what) for edge in as_vector(size, 3, what))
        warn_of_a_large_box(edges, name)
        self._add_form(name, as_pose(pose, name), "box", edges)

    def add_cylinder(self, name: str, pose: PoseLike, radius: float, length: float) -> None:
        """Add a cylinder of a radius and a length, m, about the z axis of a pose, which is in its middle.

        Raises:
            InvalidScene: the name is taken, the pose is none, or a size is not positive and finite.
        """
        self._add_form(name, as_pose(pose, name), "cylinder", self._round(name, radius, length))

    def add_capsule(self, name: str, pose: PoseLike, radius: float, length: float) -> None:
        """Add a capsule: such a cylinder, and half a sphere of its radius at each end.

        Raises:
            InvalidScene: the name is taken, the pose is none, or a size is not positive and finite.
        """
        self._add_form(name, as_pose(pose, name), "capsule", self._round(name, radius, length))

    def add_mesh(self, name: str, pose: PoseLike, file: str | Path, scale: ArrayLike = 1.0) -> None:
        """Add a mesh, covered by spheres. A mesh wider than 30 m gets a warning: it may be in millimetres.

        Args:
            name: of the object.
            pose: of the frame of the mesh.
            file: .stl, .obj, .dae, .ply, .off, .glb or .gltf.
            scale: one factor, or one for each axis; 0.001 for a file in millimetres.

        Raises:
            InvalidScene: the name is taken, the pose or the scale is none, or the file cannot be read.
        """
        vertices, faces = triangles_of(file, scale, name)
        self.add_triangles(name, pose, vertices, faces)

    def add_triangles(self, name: str, pose: PoseLike, vertices: ArrayLike, faces: ArrayLike) -> None:
        """Add a mesh of vertices (n, 3), m, and faces (m, 3), covered by spheres.

        Raises:
            InvalidScene: the name is taken, the pose is none, or these are no triangles.
        """
        from srs_ik.collision.links.bodies import covered_mesh

        points = as_points(vertices, name)
        triangles = as_faces(faces, len(points), name)
        thing = Thing(as_name(name), as_pose(pose, name), (Form("mesh", (), np.eye(4), points, triangles),))
        warn_of_millimetres(points, name)
        self._put_spheres(thing, covered_mesh(points, triangles, MESH_SPHERES)[0])
        self._put(thing)

    def add_points(self, name: str, points: ArrayLike, radius: float) -> None:
        """Add a cloud of points (N, 3), each a sphere of one radius, m.

        Raises:
            InvalidScene: the name is taken, there are no points or more than 2,000,000, or figures are not finite, or
                the radius is negative.
        """
        cloud = as_points(points, name)
        size = as_size(radius, f"radius of {quoted(name)}")
        thing = Thing(as_name(name), np.eye(4))
        self._put_spheres(thing, np.column_stack([cloud, np.full(len(cloud), size)]))
        self._put(thing)

    def add_half_space(self, name: str, point: ArrayLike, normal: ArrayLike) -> None:
        """Add all that lies on the other side of a plane; the side that the normal points to is free.

        Raises:
            InvalidScene: the name is taken, figures are not finite, or the normal is zero.
        """
        origin = as_vector(point, 3, f"point of {quoted(name)}")
        direction = as_vector(normal, 3, f"normal of {quoted(name)}")
        length = float(np.linalg.norm(direction))
        if length < 1e-9:
            raise InvalidScene(f"normal of {quoted(name)} must not be zero: it gives a direction")
        unit = direction / length
        thing = Thing(as_name(name), np.eye(4), (Form("half_space", (), frame_along(unit, origin)),))
        thing.add(at.PLANES, np.array([[*unit, unit @ origin]]), np.array([*origin, np.inf]))
        self._put(thing)

    def add_arm(
        self, name: str, other: Bodied, q: ArrayLike, pose: PoseLike | None = None, beside: Bodied | None = None
    ) -> None:
        """Add another arm, standing at a posture.

        Args:
            name: of the object; messages call its bodies ``name/link``.
            other: the arm.
            q: (7,) where it stands, rad.
            pose: of its base frame in that of the arm that asks.
            beside: instead of a pose, an arm of the same robot: the one that asks.

        Raises:
            InvalidScene: the name is taken, the pose is none, neither or both of pose and `beside` are given, or that
                is of another robot, is this arm itself, or has other joints of their robot, such as a lift, elsewhere.
            InvalidConfiguration: not 7 finite angles.
            NoBodies: no shapes of the other arm are at hand.
        """
        self._put(thing_of_arm(name, other, q, pose, beside))

    def add_message(self, message: Any) -> None:
        """Do as a message of ROS says, told by its fields alone; all of it, or nothing.

        Args:
            message: a CollisionObject of moveit_msgs (id, pose, primitives, meshes), or what has a list of them as
                `collision_objects`, perhaps in a `world`. Frames in headers are not looked at: poses have to be in the
                base frame. As in MoveIt, one that is added takes the place of one with its name, a shape without a pose
                is where its object is, an object of one shape without a pose of its own is where that is, and a
                quaternion of four zeros is no turn; one is moved, and its shapes in it, or removed by its name, and all
                are removed by none. A whole PlanningScene (`is_diff` is false) first removes what messages have added.
                Of several shapes, the first is called ``name/0``.

        Raises:
            InvalidScene: it is none of these, it has an octomap, attached objects or padded links, an object has planes
                or is to be appended to, it is not there, or figures make no sense.
        """
        from srs_ik.collision.scenes.messages import of_message

        before = dict(self._things), dict(self._told)
        try:
            every = list(of_message(message))
            if getattr(message, "is_diff", True) is False:
                for name in [name for shapes in self._told.values() for name in shapes if name in self._things]:
                    self.remove(name)
                self._told.clear()
            for told in every:
                self._do(told)
        except InvalidScene:
            self._things, self._told = before
            self.version += 1
            raise

    def _do(self, told: Told) -> None:
        from srs_ik.collision.scenes.messages import MOVE, REMOVE

        shapes = self._told.pop(told.name, {told.name: np.eye(4)})
        if told.operation == MOVE:
            if told.shape_poses:
                self._find(next(iter(shapes)))
                if len(told.shape_poses) != len(shapes):
                    others = f"poses of {len(told.shape_poses)} shapes"
                    raise InvalidScene(f"{quoted(told.name)} has {len(shapes)}, and is moved with {others}")
                shapes = dict(zip(shapes, told.shape_poses, strict=True))
            for name, T_object_shape in shapes.items():
                self.move(name, told.place @ T_object_shape)
            self._told[told.name] = shapes
            return
        if told.operation == REMOVE and not told.name:
            shapes = dict.fromkeys(self._things, np.eye(4))
            self._told.clear()
        for name in shapes:
            if told.operation == REMOVE or name in self._things:
                self.remove(name)
        for given in told.parts:
            self._add_given(given)
        if told.parts:
            names = [given.arguments[0] for given in told.parts]
            self._told[told.name] = {name: np.linalg.inv(told.place) @ self._things[name].T for name in names}

    @classmethod
    def from_file(cls, file: str | Path, exact: bool = False) -> Scene:
        """A scene from a JSON or YAML file; see `docs/collisions.md` for what stands in it.

        Raises:
            InvalidScene: there is no such file, or it is none; the message says which object is wrong, and how.
            MissingExtra: a YAML file, and no reader for it is installed.
        """
        from srs_ik.collision.scenes.files import read_scene

        content = read_scene(file)
        try:
            scene = cls(as_flag(exact, "exact", InvalidScene) or content.exact, content.margin)
            for given in content.objects:
                scene._add_given(given)
        except InvalidScene as error:
            raise InvalidScene(f"{content.where}: {error}") from None
        return scene

    def pose(self, name: str) -> Array:
        """(4, 4) pose of an object in the base frame: that of its own frame, as `move` takes it.

        Raises:
            InvalidScene: there is no such object.
        """
        return self._find(name).T.copy()

    def move(self, name: str, pose: PoseLike) -> None:
        """Put an object somewhere else, by the pose of its own frame in the base frame.

        That of a cloud or a half-space, whose figures were given in the base frame, is the identity at first. Another
        thread may be at a question meanwhile: that sees the object where it was.

        Raises:
            InvalidScene: there is no such object, or the pose is none.
        """
        self._things[name] = self._find(name).moved(as_pose(pose, name))
        self.moves += 1

    def remove(self, name: str) -> None:
        """Take an object away.

        Raises:
            InvalidScene: there is no such object.
        """
        self._find(name)
        del self._things[name]
        self.version += 1

    def __copy__(self) -> Self:
        # It stays as it is while objects of this one are moved, added and removed, and the other way about.
        other = type(self).__new__(type(self))
        other.__dict__.update(self.__dict__)
        other._things = dict(self._things)
        return other

    def _add_given(self, given: Given) -> None:
        getattr(self, f"add_{given.kind}")(*given.arguments)
        if given.place is not None:
            self.move(given.arguments[0], given.place)

    def _find(self, name: str) -> Thing:
        if not isinstance(name, str) or name not in self._things:
            known = list(self._things)
            hint = did_you_mean(str(name), known)
            raise InvalidScene(f"the scene has no {quoted(name)}{hint}; it has {listed(known) or 'no object'}")
        return self._things[name]

    def _round(self, name: str, radius: float, length: float) -> tuple[float, float]:
        return as_positive(radius, f"radius of {quoted(name)}"), as_positive(length, f"length of {quoted(name)}")

    def _add_form(self, name: str, T: Array, kind: Any, size: tuple[float, ...]) -> None:
        form = Form(kind, size, np.eye(4))
        thing = Thing(as_name(name), T, (form,))
        spheres = row_of_spheres(form)
        if spheres is not None and len(spheres) <= CELL:
            thing.add(at.SPHERES, spheres, ball_of(spheres))
        else:
            thing.add(at.PLANES, planes(form), ball_around(form))
        self._put(thing)

    def _put_spheres(self, thing: Thing, rows: Array) -> None:
        """The spheres of an object in cells of neighbours."""
        for cell in cells_of(rows):
            thing.add(at.SPHERES, cell, ball_of(cell))

    def _put(self, thing: Thing) -> None:
        if thing.name in self._things:
            raise InvalidScene(f"the scene has {quoted(thing.name)} already; move it, remove it, or take another name")
        self._things[thing.name] = thing
        self.version += 1

    def __repr__(self) -> str:
        return f"Scene({listed(self.names)})" if self._things else "Scene(empty)"
