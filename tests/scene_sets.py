"""Scenes like those of MotionBenchMaker, made by a script: a table with things on it, a shelf, an open box, a cage.

Each is a list of objects in the base frame, made for the reach of an arm, the same for the package and for coal.
"""

from __future__ import annotations

from dataclasses import dataclass

import coal
import numpy as np
from arms import generator
from scipy.spatial.transform import Rotation

import srs_ik

KINDS = ("table", "shelf", "box", "cage")


@dataclass(frozen=True)
class Object:
    """One object: its name, its kind, sizes as `Scene` takes them, and where it is."""

    name: str
    kind: str
    size: tuple[float, ...]
    T: np.ndarray


def made(kind: str, arm: srs_ik.Arm, rng: np.random.Generator) -> list[Object]:
    """The objects of a scene of some kind before an arm, in front of its shoulder in a random direction."""
    reach = arm.limb.upper_arm + arm.limb.forearm
    yaw = rng.uniform(-np.pi, np.pi)
    front = np.eye(4)
    front[:3, :3] = Rotation.from_euler("z", yaw).as_matrix()
    front[:3, 3] = arm.limb.shoulder
    maker = {"table": _table, "shelf": _shelf, "box": _box, "cage": _cage}[kind]
    return [
        Object(name, form, tuple(reach * s for s in size), front @ _at(reach * np.array(place), turn))
        for name, form, size, place, turn in maker(rng)
    ]


def _at(place, turn):
    T = np.eye(4)
    T[:3, :3] = Rotation.from_euler("z", turn).as_matrix()
    T[:3, 3] = place
    return T


def _table(rng):
    """A table top, and balls, cans and parcels on it."""
    height = rng.uniform(-0.75, -0.45)
    yield "table", "box", (0.9, 1.4, 0.05), (0.95, 0.0, height), 0.0
    for k in range(5):
        x, y = rng.uniform(0.6, 1.2), rng.uniform(-0.6, 0.6)
        size = rng.uniform(0.05, 0.12)
        top = height + 0.025
        if k % 3 == 0:
            yield f"ball {k}", "sphere", (size,), (x, y, top + size), 0.0
        elif k % 3 == 1:
            tall = rng.uniform(0.15, 0.4)
            yield f"can {k}", "cylinder", (0.6 * size, tall), (x, y, top + 0.5 * tall), 0.0
        else:
            tall = rng.uniform(0.1, 0.3)
            yield f"parcel {k}", "box", (2 * size, size, tall), (x, y, top + 0.5 * tall), rng.uniform(-3, 3)


def _shelf(rng):
    """Two sides, a back, and boards."""
    x, low = rng.uniform(0.75, 0.95), rng.uniform(-0.7, -0.5)
    for side in (-1, 1):
        yield f"side {side}", "box", (0.35, 0.03, 1.2), (x, 0.55 * side, low + 0.6), 0.0
    yield "back", "box", (0.03, 1.1, 1.2), (x + 0.17, 0.0, low + 0.6), 0.0
    for k in range(4):
        yield f"board {k}", "box", (0.35, 1.1, 0.03), (x, 0.0, low + 0.4 * k), 0.0


def _box(rng):
    """A box without a lid."""
    x, y, low = rng.uniform(0.6, 0.8), rng.uniform(-0.3, 0.3), rng.uniform(-0.8, -0.5)
    wide, tall = rng.uniform(0.5, 0.7), rng.uniform(0.2, 0.35)
    yield "floor", "box", (wide, wide, 0.03), (x, y, low), 0.0
    for k, (dx, dy) in enumerate(((1, 0), (-1, 0), (0, 1), (0, -1))):
        size = (0.03, wide, tall) if dx else (wide, 0.03, tall)
        yield f"wall {k}", "box", size, (x + 0.5 * wide * dx, y + 0.5 * wide * dy, low + 0.5 * tall), 0.0


def _cage(rng):
    """Poles around the arm, and a bar."""
    for k in range(5):
        angle, far = rng.uniform(-2.0, 2.0), rng.uniform(0.6, 0.9)
        yield f"pole {k}", "cylinder", (0.03, 2.0), (far * np.cos(angle), far * np.sin(angle), 0.0), 0.0
    yield "bar", "capsule", (0.04, 0.5), (0.5, rng.uniform(-0.4, 0.4), rng.uniform(0.3, 0.6)), 0.0


def scene_of(objects: list[Object], **options) -> srs_ik.Scene:
    """The objects as a scene of the package."""
    scene = srs_ik.Scene(**options)
    for each in objects:
        if each.kind == "box":
            scene.add_box(each.name, each.T, each.size)
        elif each.kind == "sphere":
            scene.add_sphere(each.name, each.T[:3, 3], *each.size)
        elif each.kind == "cylinder":
            scene.add_cylinder(each.name, each.T, *each.size)
        else:
            scene.add_capsule(each.name, each.T, *each.size)
    return scene


def geometry_of(each: Object):
    """An object as coal's geometry."""
    kinds = {"box": coal.Box, "sphere": coal.Sphere, "cylinder": coal.Cylinder, "capsule": coal.Capsule}
    return kinds[each.kind](*each.size)


def file_of_scene(objects: list[Object]) -> dict:
    """The objects as they stand in a scene file."""
    rows = []
    for each in objects:
        quat = Rotation.from_matrix(each.T[:3, :3]).as_quat().tolist()
        size = each.size[0] if each.kind == "sphere" else list(each.size)
        row = {"name": each.name, each.kind: size, "xyz": each.T[:3, 3].tolist()}
        rows.append(row if each.kind == "sphere" else row | {"quat": quat})
    return {"objects": rows}


def boxes_and_balls(arm, truth, scene):
    """The same objects for both (or for a scene alone), some on one side only: a mirrored arm would not go unseen."""
    rng = generator("scene", 3)
    for k in range(6):
        p = rng.uniform(-1.0, 1.0, 3)
        p = arm.limb.shoulder + (0.35 + 0.3 * rng.random()) * p / np.linalg.norm(p)
        T = srs_ik.pose_from_xyz_rpy(p, rng.uniform(-2, 2, 3))
        if k % 3 == 0:
            size = rng.uniform(0.05, 0.2, 3)
            scene.add_box(f"box {k}", T, size)
            shape = coal.Box(*size)
        elif k % 3 == 1:
            scene.add_sphere(f"ball {k}", p, 0.08)
            shape = coal.Sphere(0.08)
        else:
            scene.add_cylinder(f"can {k}", T, 0.05, 0.25)
            shape = coal.Cylinder(0.05, 0.25)
        if truth is not None:
            truth.add(f"object {k}", T.homogeneous, shape)
