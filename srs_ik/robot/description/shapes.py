"""The shapes of a robot's links: what a URDF says about how the robot looks."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from srs_ik.robot.description import document
from srs_ik.robot.description.files import read
from srs_ik.robot.description.model import Drawing

Kind = Literal["box", "cylinder", "sphere", "capsule", "mesh"]
Rgba = tuple[float, float, float, float]

_KEPT: document.Kept = {
    "robot": frozenset({"link", "material"}),
    "link": frozenset({"visual", "collision"}),
    "visual": frozenset({"origin", "geometry", "material"}),
    "collision": frozenset({"origin", "geometry"}),
    "geometry": frozenset({"box", "cylinder", "sphere", "capsule", "mesh"}),
    "material": frozenset({"color"}),
}

_TREE: document.Kept = {"robot": frozenset({"joint"}), "joint": frozenset({"parent", "child"})}


@dataclass(frozen=True, eq=False)
class Shape:
    """One shape of a link."""

    link: str  # name of the link
    visual: bool  # true if it is meant to be seen, false if it is meant for collisions
    T_link_shape: NDArray[np.float64]  # (4, 4) pose of the shape in the link's frame
    kind: Kind  # what it is; a cylinder or capsule has its axis along z, and its centre in the origin
    # box: 3 edges; cylinder and capsule: radius and length; sphere: radius, metres; mesh: 3 scale factors
    size: tuple[float, ...]
    file: str = ""  # name of the mesh as the file gives it; empty otherwise
    rgba: Rgba | None = None  # colour and opacity, 0 to 1; None if not given


def read_shapes(drawing: Drawing | None) -> tuple[list[Shape], int]:
    """The shapes of a robot, and how many more make no sense (no size, a negative one, an unknown kind); None has none.

    Raises:
        InvalidRobot: the file is gone, or is no URDF any more.
    """
    if drawing is None:
        return [], 0
    content, label = _content(drawing)
    if isinstance(content, str | bytes):
        found = list(_of_elements(document.parse(content, label, _KEPT)))
    else:
        found = list(_of_yourdfpy(content))
    shapes = [shape for shape in found if shape is not None]
    return shapes, len(found) - len(shapes)


def read_tree(drawing: Drawing | None) -> list[tuple[str, str]]:
    """The names of the two links that each joint of a robot connects, the carrying one first.

    Raises:
        InvalidRobot: the file is gone, or is no URDF any more.
    """
    if drawing is None:
        return []
    content, label = _content(drawing)
    if not isinstance(content, str | bytes):
        return [(joint.parent, joint.child) for joint in content.robot.joints]
    joints = document.parse(content, label, _TREE).iterfind("joint")
    ends = [(joint.find("parent"), joint.find("child")) for joint in joints]
    return [(p.get("link", ""), c.get("link", "")) for p, c in ends if p is not None and c is not None]


def _content(drawing: Drawing) -> tuple[Any, str]:
    """What the robot was read from, and how messages call it."""
    label = str(drawing.file or "the URDF text")
    if drawing.content is None and drawing.file is not None:
        return read(drawing.file, label), label
    return drawing.content, label


def _of_elements(robot: Element) -> Iterator[Shape | None]:
    # A material is defined once, at the top or at its first use, and named from then on.
    colours = {m.get("name", ""): rgba for m in robot.iter("material") if (rgba := _colour(m)) is not None}
    for link in robot.iterfind("link"):
        for element in link:
            material = element.find("material")
            rgba = None
            if material is not None:
                rgba = _colour(material) or colours.get(material.get("name", ""))
            try:
                yield _shape(link.get("name", ""), element, rgba)
            except (ValueError, StopIteration):
                yield None


def _shape(link: str, element: Element, rgba: Rgba | None) -> Shape:
    geometry = element.find("geometry")
    inner = next(iter(geometry if geometry is not None else ()))
    kind: Any = inner.tag
    if kind == "box":
        size = _numbers(inner.get("size"), 3)
    elif kind == "sphere":
        size = _numbers(inner.get("radius"), 1)
    elif kind == "mesh":
        size = _numbers(inner.get("scale", "1 1 1"), 3)
    else:
        size = _numbers(inner.get("radius"), 1) + _numbers(inner.get("length"), 1)
    file = inner.get("filename", "")
    return _checked(link, element.tag == "visual", _pose(element.find("origin")), kind, size, file, rgba)


def _of_yourdfpy(urdf: Any) -> Iterator[Shape | None]:
    for link in urdf.robot.links:
        for visual, elements in ((True, link.visuals), (False, link.collisions)):
            for element in elements:
                try:
                    yield _yourdfpy_shape(link.name, visual, element)
                except (AttributeError, TypeError, ValueError):
                    yield None


def _yourdfpy_shape(link: str, visual: bool, element: Any) -> Shape:
    geometry = element.geometry
    file, kind, size = "", "", ()  # type: str, Any, Any
    if geometry.box is not None:
        kind, size = "box", geometry.box.size
    elif geometry.cylinder is not None:
        kind, size = "cylinder", (geometry.cylinder.radius, geometry.cylinder.length)
    elif geometry.sphere is not None:
        kind, size = "sphere", (geometry.sphere.radius,)
    elif geometry.mesh is not None:
        scale = geometry.mesh.scale
        kind, size, file = "mesh", np.broadcast_to(1.0 if scale is None else scale, 3), geometry.mesh.filename
    T = np.eye(4) if element.origin is None else np.array(element.origin, dtype=float)
    material = getattr(element, "material", None)
    rgba = None if material is None or material.color is None else tuple(map(float, material.color.rgba))
    return _checked(link, visual, T, kind, tuple(map(float, size)), file, rgba)


def _checked(
    link: str, visual: bool, T: NDArray[np.float64], kind: Kind, size: tuple[float, ...], file: str, rgba: Any
) -> Shape:
    sound = all(map(math.isfinite, size)) and all(size) and (kind == "mesh" or min(size) > 0.0)
    if not (kind and sound and np.isfinite(T).all() and bool(file) == (kind == "mesh")):
        raise ValueError
    return Shape(link, visual, T, kind, size, file, rgba)


def _pose(origin: Element | None) -> NDArray[np.float64]:
    T = np.eye(4)
    if origin is not None:
        T[:3, 3] = _numbers(origin.get("xyz", "0 0 0"), 3)
        T[:3, :3] = pin.rpy.rpyToMatrix(np.array(_numbers(origin.get("rpy", "0 0 0"), 3)))
    return T


def _colour(material: Element) -> Rgba | None:
    colour = material.find("color")
    if colour is None:
        return None
    try:
        r, g, b, a = (min(max(x, 0.0), 1.0) for x in _numbers(colour.get("rgba"), 4))
    except ValueError:
        return None
    return r, g, b, a


def _numbers(text: str | None, count: int) -> tuple[float, ...]:
    values = tuple(float(word) for word in (text or "").split())
    if len(values) != count or not all(map(math.isfinite, values)):
        raise ValueError
    return values
