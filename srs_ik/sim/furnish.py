"""What an arm meets a world with, and the world around it, as shapes of MuJoCo."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from srs_ik.collision.parts import thickened
from srs_ik.errors import NoBodies
from srs_ik.inputs.poses import as_rigid_matrix
from srs_ik.robot.limb import Vector
from srs_ik.sim.world import Box, Payload, Peg, Wall, World

if TYPE_CHECKING:
    from srs_ik.arm import Arm
    from srs_ik.collision.forms import Form

TIP, LINKS = 1, 2
"""Bits of what touches: the ball at the tip, and the links of the arm."""

FEW_CORNERS = 400
"""A hull with more corners is made of as many of them; MuJoCo's contacts take longer with each."""


class Furnisher:
    """Adds shapes to a specification of MuJoCo whose bodies are those of an arm.

    Args:
        mujoco: the module.
        spec: its ``MjSpec``.
        arm: the arm; poses are given in its base frame.

    Attributes:
        R_root_base: (3, 3) MuJoCo's world from the base frame.
        p_root_base: (3,) m.
    """

    def __init__(self, mujoco: Any, spec: Any, arm: Arm) -> None:
        self._mujoco, self._spec, self._arm = mujoco, spec, arm
        self._bare = spec.compile()
        self._data = mujoco.MjData(self._bare)
        mujoco.mj_kinematics(self._bare, self._data)
        self._frames = arm.joint_frames(np.zeros(7))
        root = self._frames[0]
        self.R_root_base = np.ascontiguousarray(root[:3, :3].T)
        self.p_root_base = -self.R_root_base @ root[:3, 3]

    def local(self, k: int, T: Vector) -> tuple[Any, Vector]:
        """The body that joint k moves, counted from 0, and a pose (4, 4) of the base frame at zero in its frame."""
        index = int(self._bare.joint(self._arm.joint_names[k]).bodyid[0])
        R = self._data.xmat[index].reshape(3, 3)
        pose = np.eye(4)
        pose[:3, :3] = R.T @ self.R_root_base @ T[:3, :3]
        pose[:3, 3] = R.T @ (self.R_root_base @ T[:3, 3] + self.p_root_base - self._data.xpos[index])
        return self._spec.body(self._bare.body(index).name), pose

    def local_point(self, k: int, point: Vector) -> tuple[Any, Vector]:
        """The same of a point (3,)."""
        T = np.eye(4)
        T[:3, 3] = point
        body, pose = self.local(k, T)
        return body, pose[:3, 3]

    # The arm ----------------------------------------------------------------------------------------------------

    def put_ball(self, radius: float) -> None:
        """The ball at the tip."""
        hand, centre = self.local_point(6, self._arm.limb.T_base_tip_zero[:3, 3])
        self._add(hand, self._mujoco.mjtGeom.mjGEOM_SPHERE, [radius, 0, 0], TIP, pos=centre)

    def put_arm(self, world: World) -> str:
        """What the whole arm meets the world with: "shapes" of its links, or "bars" along upper arm and forearm."""
        if world.shapes:
            try:
                bodies = [body for body in self._arm.bodies if body.joint]
            except NoBodies:
                bodies = []
            for body in bodies:
                for form in body.forms:
                    self._put_form(body.joint, form)
            if any(body.forms for body in bodies):
                return "shapes"
        limb = self._arm.limb
        for k, start, end in ((2, limb.shoulder, limb.elbow), (3, limb.elbow, limb.wrist)):
            body, first = self.local_point(k, start)
            ends = [*first, *self.local_point(k, end)[1]]
            self._add(body, self._mujoco.mjtGeom.mjGEOM_CAPSULE, [world.arm_radius, 0, 0], LINKS, fromto=ends)
        return "bars"

    def put_payload(self, payload: Payload) -> None:
        """A ball of some mass in the hand, which touches nothing."""
        tip = self._arm.limb.T_base_tip_zero
        offset = tip[:3, :3] @ np.asarray(payload.centre, dtype=float)
        mass, radius = float(payload.mass), float(payload.radius)
        hand, centre = self.local_point(6, tip[:3, 3] + offset)
        load = hand.add_body(name="payload", pos=centre)
        load.explicitinertial, load.mass, load.inertia = True, mass, np.full(3, 0.4 * mass * radius**2)
        # Not given, the compiler takes the place of the body in the hand for it.
        load.ipos, load.iquat = np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])

    def _put_form(self, joint: int, form: Form) -> None:
        """A form of a link that a joint, counted from 1, moves; of a mesh its convex hull."""
        kinds = self._mujoco.mjtGeom
        body, T = self.local(joint - 1, self._frames[joint] @ form.T)
        if form.kind == "mesh":
            assert form.vertices is not None
            self._add(body, kinds.mjGEOM_MESH, None, LINKS, T=T, meshname=self._hull(form.vertices))
        elif form.kind == "box":
            self._add(body, kinds.mjGEOM_BOX, 0.5 * np.array(form.size), LINKS, T=T)
        elif form.kind == "sphere":
            self._add(body, kinds.mjGEOM_SPHERE, [form.size[0], 0, 0], LINKS, T=T)
        else:
            radius, length = form.size
            kind = kinds.mjGEOM_CYLINDER if form.kind == "cylinder" else kinds.mjGEOM_CAPSULE
            self._add(body, kind, [radius, 0.5 * length, 0], LINKS, T=T)

    def _hull(self, vertices: Vector) -> str:
        """Name of a new mesh, which goes around points."""
        from scipy.spatial import ConvexHull

        points = thickened(vertices)
        corners = points[ConvexHull(points).vertices]
        if len(corners) > FEW_CORNERS:
            # The farthest ones along directions that are spread evenly.
            k = np.arange(FEW_CORNERS) + 0.5
            z, turn = 1.0 - 2.0 * k / FEW_CORNERS, np.pi * (1.0 + 5.0**0.5) * k
            ways = np.stack([np.sqrt(1.0 - z * z) * np.cos(turn), np.sqrt(1.0 - z * z) * np.sin(turn), z])
            corners = corners[np.unique((corners @ ways).argmax(axis=0))]
        mesh = self._spec.add_mesh(name=f"hull {len(self._spec.meshes)}")
        mesh.uservert = corners.ravel().astype(np.float32)
        mesh.userface = ConvexHull(corners).simplices.ravel().astype(np.int32)
        mesh.inertia = self._mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
        return str(mesh.name)

    # The world --------------------------------------------------------------------------------------------------

    def put_wall(self, wall: Wall) -> None:
        """A half-space."""
        normal = self.R_root_base @ np.asarray(wall.normal, dtype=float)
        length = np.linalg.norm(normal)
        pose = np.eye(4)
        # The plane of MuJoCo has its normal along z; how it is turned about that does not matter.
        pose[:3, :3] = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), normal / length).toRotationMatrix()
        pose[:3, 3] = self._in_root(np.asarray(wall.point, dtype=float))
        self._add_fixed(self._mujoco.mjtGeom.mjGEOM_PLANE, [1, 1, 0.1], TIP | LINKS if wall.whole else TIP, T=pose)

    def put_peg(self, peg: Peg) -> None:
        """A round bar."""
        ends = [self._in_root(np.asarray(end, dtype=float)) for end in (peg.start, peg.end)]
        self._add_fixed(
            self._mujoco.mjtGeom.mjGEOM_CAPSULE, [peg.radius, 0, 0], TIP | LINKS, fromto=[*ends[0], *ends[1]]
        )

    def put_box(self, box: Box) -> None:
        """A box."""
        T, size = as_rigid_matrix(box.pose), np.asarray(box.size, dtype=float)
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = self.R_root_base @ T[:3, :3], self._in_root(T[:3, 3])
        self._add_fixed(self._mujoco.mjtGeom.mjGEOM_BOX, 0.5 * size, TIP | LINKS, T=pose)

    def _in_root(self, point: Vector) -> Vector:
        return np.asarray(self.R_root_base @ point + self.p_root_base)

    def _add(self, body: Any, kind: Any, size: Any, meets: int, T: Vector | None = None, **where: Any) -> None:
        body.add_geom(type=kind, contype=meets, conaffinity=0, mass=0.0, **_sized(size), **_placed(T), **where)

    def _add_fixed(self, kind: Any, size: Any, meets: int, T: Vector | None = None, **where: Any) -> None:
        self._spec.worldbody.add_geom(type=kind, contype=0, conaffinity=meets, **_sized(size), **_placed(T), **where)


def _sized(size: Any) -> dict[str, Any]:
    return {} if size is None else {"size": list(map(float, size))}


def _placed(T: NDArray[np.float64] | None) -> dict[str, Any]:
    if T is None:
        return {}
    turn = pin.Quaternion(np.ascontiguousarray(T[:3, :3]))
    return {"pos": T[:3, 3], "quat": [turn.w, turn.x, turn.y, turn.z]}
