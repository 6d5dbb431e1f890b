"""An arm with bodies: what it is covered by, which pairs are watched, what it holds."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike

from srs_ik.errors import InvalidScene, quoted
from srs_ik.kinematics import ChainKinematics
from srs_ik.meshes.folders import folders_of
from srs_ik.system.forks import WHOLE
from srs_ik.system.waiting import said_if_long

if TYPE_CHECKING:
    from srs_ik.collision.links.bodies import Body
    from srs_ik.collision.links.pairs import Pair
    from srs_ik.collision.links.ranges import JointRange
    from srs_ik.collision.scenes.scene import Scene
    from srs_ik.collision.tables import OwnTables, Tables
    from srs_ik.robot.description.model import Drawing
    from srs_ik.robot.limb import SrsLimb


@dataclass(frozen=True)
class BodyPlan:
    """How the bodies of an arm are found."""

    folders: tuple[str, ...] = ()  # to search for meshes
    spheres: str = ""  # file of spheres of the links, or these as JSON; empty for none
    srdf: str = ""  # path or text of an SRDF file; empty for none
    keep: tuple[tuple[str, str], ...] = ()  # pairs of bodies that are watched in any case
    drop: tuple[tuple[str, str], ...] = ()  # pairs of bodies that are not watched
    held: tuple[Body, ...] = ()  # what the hand holds, poses in the frame of joint 7


class BodyOwner(ChainKinematics):
    """What an arm knows of its bodies; found when first asked for, in seconds, and kept in the user's cache folder."""

    limb: SrsLimb
    drawing: Drawing | None
    plan: BodyPlan

    def _planned(self, plan: BodyPlan, load: Any = None) -> Self:
        raise NotImplementedError

    @property
    def bodies(self) -> list[Body]:
        """The links that have shapes, as spheres that cover these for certain, and what the hand holds.

        Raises:
            NoBodies: there are no shapes, or meshes of a link are not at hand.
            InvalidRobot: a file is gone, or is no URDF or SRDF any more.
            InvalidScene: a file of spheres holds none, or some of a link that the robot does not have.
        """
        return list(self._found[0])

    @property
    def pairs(self) -> list[Pair]:
        """All pairs of bodies, each watched or not, with the reason; see `bodies` for what is raised."""
        return list(self._found[1])

    def with_bodies(
        self,
        folders: str | Path | Sequence[str | Path] = (),
        spheres: str | Path | Mapping[str, ArrayLike] | None = None,
        srdf: str | Path | None = None,
        keep: Iterable[tuple[str, str]] = (),
        drop: Iterable[tuple[str, str]] = (),
    ) -> Self:
        """This arm with bodies found in another way. The arm itself stays as it is.

        Args:
            folders: a folder to search for meshes, or several.
            spheres: spheres of the links in place of their shapes: a file of cuRobo (YAML) or foam (JSON), or (n, 4)
                centres in the frame of the link and radii, m, by the names of links.
            srdf: path or text of an SRDF file; its disabled pairs are not watched, and all others are. By default the
                one that counts already: that of `load`, if it disables any, or of an earlier call.
            keep: pairs of names that are watched in any case.
            drop: pairs of names that are not watched, on your word.

        Raises:
            InvalidRobot: there is no such folder.
        """
        from srs_ik.collision.links.sphere_files import as_text

        text = self.plan.srdf if srdf is None else str(srdf)
        if isinstance(spheres, Mapping):
            file = as_text(spheres)
        else:
            file = "" if spheres is None else str(Path(spheres).absolute())
        given = BodyPlan(tuple(map(str, folders_of(folders))), file, text, _pairs(keep), _pairs(drop), self.plan.held)
        return self._planned(given)

    def with_object(
        self,
        name: str,
        pose: Any,
        size: ArrayLike | None = None,
        *,
        radius: float | None = None,
        length: float | None = None,
        file: str | Path | None = None,
        scale: ArrayLike | None = None,
        mass: float | None = None,
    ) -> Self:
        """This arm with an object in its hand, which counts as a part of it. The arm itself stays as it is.

        With a mass, gravity torques, force polytopes, `optimise(pose, "gravity_torque")` and torque controllers carry
        it, too: a solid of one density.

        Args:
            name: of the object.
            pose: of the object in the tip frame.
            size: (3,) edges of a box, m.
            radius: of a sphere, or with `length` of a cylinder along z, m.
            length: of a cylinder, m.
            file: a mesh.
            scale: of the mesh, one factor, or one for each axis; 0.001 for a file in millimetres.
            mass: kg; without it the object has a form alone, and weighs nothing.

        Raises:
            InvalidScene: the name is that of a link or of what is held already, the pose is none, sizes or mass are
                not positive, or not one kind of form is given.
            InvalidRobot: a mass is given, and the description of the arm has none.
        """
        from srs_ik.collision.links.bodies import held, link_frames
        from srs_ik.collision.links.weight import inertia_of
        from srs_ik.collision.scenes.scene import Scene

        if isinstance(name, str) and name in link_frames(self):
            raise InvalidScene(f"{quoted(name)} is a link of {self.name}: an object in its hand needs another name")
        scene = Scene()
        given = (size is not None, radius is not None, file is not None)
        if sum(given) != 1 or (length is not None and radius is None):
            raise InvalidScene(f"{quoted(name)} is given by a size, by a radius (and a length), or by a file")
        if file is None and scale is not None:
            raise InvalidScene(f"scale goes with the file of a mesh, and {quoted(name)} has none")
        if size is not None:
            scene.add_box(name, pose, size)
        elif file is not None:
            scene.add_mesh(name, pose, file, 1.0 if scale is None else scale)
        elif radius is not None:
            # A sphere has a pose, too: its centre.
            scene.add_cylinder(name, pose, radius, radius if length is None else length)
        thing = next(iter(scene))
        forms = [form.moved(thing.T) for form in thing.forms]
        if radius is not None and length is None:
            forms = [replace(forms[0], kind="sphere", size=(float(radius),))]
        if name in {body.name for body in self.plan.held}:
            raise InvalidScene(f"{self.name} holds {quoted(name)} already")
        frames = self.joint_frames(np.zeros(7))
        T_joint_tip = np.linalg.inv(frames[7]) @ self.forward_kinematics(np.zeros(7)).homogeneous
        load = None if mass is None else inertia_of(forms[0], mass, name)
        return self._planned(replace(self.plan, held=(*self.plan.held, held(name, forms, T_joint_tip))), load)

    def tables(self, scene: Scene) -> Tables:
        """What kernels know of this arm in a scene; made once, and patched where objects move."""
        from srs_ik.collision.tables import OwnTables, Tables

        state = self.__dict__
        known: Tables | None = state.get("_tables")
        tables = None if known is None else known.of(scene)
        if tables is None:
            own: OwnTables | None = state.get("_own")
            if own is None:
                own = state["_own"] = OwnTables(self, self.limb, *self._found)
            tables = Tables(own, scene)
        state["_tables"] = tables
        return tables

    @property
    def _found(self) -> tuple[list[Body], list[Pair], list[JointRange]]:
        state = self.__dict__
        if "_bodies_found" not in state:
            words = f"{self.name}: spheres that cover its links, and which of them can meet, are found once and kept"
            with WHOLE, _finding, said_if_long(words):
                if "_bodies_found" not in state:
                    state["_bodies_found"] = self._find()
        found: tuple[list[Body], list[Pair], list[JointRange]] = state["_bodies_found"]
        return found

    def _find(self) -> tuple[list[Body], list[Pair], list[JointRange]]:
        from srs_ik.collision.links.bodies import link_bodies
        from srs_ik.collision.links.pairs import find_pairs, with_overrides
        from srs_ik.collision.links.sphere_files import read_spheres

        plan = self.plan
        spheres = read_spheres(plan.spheres) if plan.spheres else None
        bodies = [*link_bodies(self, self.drawing, plan.folders, spheres), *plan.held]
        names = {body.name for body in bodies}
        for pair in (*plan.keep, *plan.drop):
            for name in pair:
                if name not in names:
                    raise InvalidScene(f"{self.name} has no body {quoted(name)}; it has {', '.join(sorted(names))}")
        pairs, ranges = find_pairs(self, bodies, self.drawing, plan.srdf or None)
        pairs = with_overrides(pairs, plan.keep, plan.drop)
        dropped = {frozenset(pair) for pair in plan.drop}
        ranges = [r for r in ranges if frozenset((bodies[r.first].name, bodies[r.second].name)) not in dropped]
        return bodies, pairs, ranges


_finding = threading.RLock()


def _pairs(pairs: Iterable[tuple[str, str]]) -> tuple[tuple[str, str], ...]:
    try:
        found = tuple((str(a), str(b)) for a, b in pairs)
    except (TypeError, ValueError):
        raise InvalidScene("pairs of bodies are given as [(name, name), ...]") from None
    return found
