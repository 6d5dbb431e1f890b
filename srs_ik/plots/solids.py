"""The arm and its ellipsoids as patches in space, in one collection: Matplotlib sorts by depth within one alone."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pinocchio as pin

from srs_ik.plots.figure import ARM, JOINT
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.arm import Arm

_AROUND, _ALONG = 28, 12
_LIGHT = np.array([0.3, -0.5, 0.81])


class Solid(NamedTuple):
    """Patches of one colour."""

    patches: Array
    """(n, 4, 3) corners, counter-clockwise seen from outside, metres."""
    colour: str
    alpha: float = 1.0


class Skeleton(NamedTuple):
    """Where the arm is at a configuration, in the base frame."""

    line: Array
    """(5, 3) base, shoulder, elbow, wrist and tip."""
    points: Array
    """(7, 3) a point on each joint axis: that nearest to its centre."""
    axes: Array
    """(7, 3) unit directions of the joint axes."""


def skeleton(arm: Arm, q: Array) -> Skeleton:
    """The limb at seven joint angles: what it is at zero, turned about one joint axis after the other."""
    limb = arm.limb
    moved, T = [], pin.SE3.Identity()
    for axis, point, angle in zip(limb.axes, limb.points, q, strict=True):
        turn = pin.AngleAxis(float(angle), axis).toRotationMatrix()
        T = T * pin.SE3(turn, point - turn @ point)
        moved.append(T)
    centres = np.repeat([limb.shoulder, limb.elbow, limb.wrist], (3, 1, 3), axis=0)
    along = np.einsum("ij,ij->i", centres - limb.points, limb.axes)
    nearest = limb.points + along[:, None] * limb.axes
    tip = moved[6] * limb.T_base_tip_zero[:3, 3]
    return Skeleton(
        np.array([np.zeros(3), limb.shoulder, moved[2] * limb.elbow, moved[4] * limb.wrist, tip]),
        np.array([T * p for T, p in zip(moved, nearest, strict=True)]),
        np.array([T.rotation @ a for T, a in zip(moved, limb.axes, strict=True)]),
    )


def arm_solids(shape: Skeleton) -> list[Solid]:
    """Links as tubes, joints as short cylinders along their axes; those of one centre lie behind one another."""
    size = float(np.linalg.norm(np.diff(shape.line[1:4], axis=0), axis=1).sum())
    width = 0.045 * size
    links = [tube(a, b, width) for a, b in zip(shape.line, shape.line[1:], strict=False) if np.linalg.norm(b - a) > 0]
    solids = [Solid(np.concatenate(links), ARM)]
    turning = [tube(p - 1.5 * width * a, p + 1.5 * width * a, 1.15 * width) for p, a in zip(*shape[1:], strict=True)]
    return [*solids, Solid(np.concatenate(turning), JOINT)]


def tube(start: Array, end: Array, radius: float) -> Array:
    """(n, 4, 3) patches of a closed cylinder."""
    axis = (end - start) / np.linalg.norm(end - start)
    across = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
    across /= np.linalg.norm(across)
    angle = np.linspace(0.0, 2.0 * np.pi, _AROUND + 1)
    ring = radius * (np.outer(np.cos(angle), across) + np.outer(np.sin(angle), np.cross(axis, across)))
    centres = np.linspace(start, end, _ALONG + 1)
    # The ends close to a point, as rings of no radius.
    rings = [0.0 * ring + start, *(ring + c for c in centres), 0.0 * ring + end]
    return _patches(np.array(rings))


def ellipsoid(centre: Array, semi_axes: Array) -> Array:
    """(n, 4, 3) patches of an ellipsoid with these semi-axes (3, 3), right-handed, in columns."""
    latitude = np.linspace(-0.5 * np.pi, 0.5 * np.pi, _AROUND // 2 + 1)
    longitude = np.linspace(0.0, 2.0 * np.pi, _AROUND + 1)
    level, around = np.meshgrid(latitude, longitude, indexing="ij")
    sphere = np.stack([np.cos(level) * np.cos(around), np.cos(level) * np.sin(around), np.sin(level)], axis=-1)
    return _patches(centre + sphere @ semi_axes.T)


def collection(solids: list[Solid]) -> Any:
    """One Matplotlib collection of solids, lit from above."""
    from matplotlib.colors import to_rgb
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    colours = []
    for patches, colour, alpha in solids:
        normals = np.cross(patches[:, 2] - patches[:, 0], patches[:, 3] - patches[:, 1])
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
        light = 0.62 + 0.38 * normals @ _LIGHT
        colours.append(
            np.column_stack([np.clip(np.outer(light, to_rgb(colour)), 0.0, 1.0), np.full(len(light), alpha)])
        )
    faces = np.concatenate(colours)
    # Edges of their own colour close the hairlines between patches; on a transparent solid they would show twice.
    edges = np.where(faces[:, 3:] < 1.0, 0.0, faces)
    patches = np.concatenate([solid.patches for solid in solids])
    return Poly3DCollection(patches, facecolors=faces, edgecolors=edges, linewidths=0.4)


def _patches(grid: Array) -> Array:
    """(n, 4, 3) patches between the points of a grid (rows, columns, 3)."""
    return np.stack([grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]], axis=2).reshape(-1, 4, 3)
