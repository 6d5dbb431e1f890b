"""What a body of an MJCF file weighs: by its inertia, or by the shapes on it."""

from __future__ import annotations

import math
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from srs_ik.errors import quoted
from srs_ik.robot.description.mjcf.attributes import ORIENTATION, Attributes, Reader, turned_to

_DENSITY = "1000"
_WEIGHTLESS = ("plane", "hfield")
_SIZES = {"sphere": 1, "capsule": 2, "cylinder": 2, "ellipsoid": 3, "box": 3}
_INERTIAL = ORIENTATION | {"pos", "mass", "diaginertia", "fullinertia"}
_ALONG = ("capsule", "cylinder", "ellipsoid", "box")
_ROUNDING = 1e-6


class Masses:
    """Gathers the inertia of one body.

    Attributes:
        unknown: true if it depends on meshes, which are not read.
    """

    def __init__(self, read: Reader) -> None:
        self.unknown = False
        self._read = read
        self._stated: pin.Inertia | None = None
        self._shapes = pin.Inertia.Zero()
        self._by_shape = self._setting("inertiafromgeom", "auto")

    @property
    def inertia(self) -> pin.Inertia | None:
        """The inertia in the frame of the body; None if it cannot be known without meshes."""
        total = float(self._read.figure(self._setting("settotalmass", "-1"), "settotalmass of <compiler>"))
        if total > 0.0:
            return None
        if self._stated is not None and self._by_shape != "true":
            return self._bounded(self._stated)
        if self._by_shape == "false":
            return self._bounded(pin.Inertia.Zero())
        return None if self.unknown else self._bounded(self._shapes)

    def inertial(self, element: Element, of_body: bool, where: str) -> None:
        """Take an ``<inertial>``."""
        read, given = self._read, element.attrib
        read.known(element, _INERTIAL, where)
        read.one_orientation(given, where)
        if self._stated is not None or not of_body:
            raise read.fail(f"{where} is not the only one, or stands in a frame")
        if "pos" not in given or "mass" not in given:
            raise read.fail(f"{where} lacks its pos or mass")
        mass = read.figure(given["mass"], f"mass of {where}")
        moments = np.zeros((3, 3))
        if "fullinertia" in given:
            if ORIENTATION & given.keys() or "diaginertia" in given:
                raise read.fail(f"{where} has a fullinertia and another inertia or orientation")
            xx, yy, zz, xy, xz, yz = read.vector(given["fullinertia"], 6, f"fullinertia of {where}")
            moments = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        elif "diaginertia" in given:
            moments = np.diag(read.vector(given["diaginertia"], 3, f"diaginertia of {where}"))
        if mass < 0.0 or not np.abs(moments).max() < math.inf or np.linalg.eigvalsh(moments).min() < -_ROUNDING:
            raise read.fail(f"{where} has a mass or inertia that is negative")
        placement = read.placement(given, where)
        R = placement.rotation
        self._stated = pin.Inertia(mass, placement.translation, R @ moments @ R.T)

    def geom(self, attributes: Attributes, frame: pin.SE3, where: str) -> None:
        """Take a ``<geom>``, its attributes over those of its default class."""
        read = self._read
        first, last = read.vector(self._setting("inertiagrouprange", "0 5"), 2, "inertiagrouprange of <compiler>")
        kind = attributes.get("type", "sphere")
        if kind in _WEIGHTLESS or not first <= read.figure(attributes.get("group", "0"), f"group of {where}") <= last:
            return
        if "mass" in attributes and read.figure(attributes["mass"], f"mass of {where}") == 0.0:
            return
        if "mass" not in attributes and read.figure(attributes.get("density", _DENSITY), f"density of {where}") == 0.0:
            return
        if kind not in _SIZES or "mesh" in attributes or attributes.get("shellinertia", "false") != "false":
            self.unknown = True
            return
        size, placement = self._shape(attributes, kind, where)
        solid, volume = _solid(kind, size)
        density = read.figure(attributes.get("density", _DENSITY), f"density of {where}")
        mass = read.figure(attributes["mass"], f"mass of {where}") if "mass" in attributes else density * volume
        if not 0.0 <= mass < math.inf:
            raise read.fail(f"{where} has the mass {quoted(mass)}, which is none")
        weighed = pin.Inertia(mass, np.zeros(3), mass * solid)
        self._shapes += (frame * placement).act(weighed)

    def _shape(self, attributes: Attributes, kind: str, where: str) -> tuple[np.ndarray, pin.SE3]:
        read = self._read
        words = attributes.get("size", "").split()
        count = _SIZES[kind] - (kind in _ALONG and "fromto" in attributes and kind in ("capsule", "cylinder"))
        if "fromto" in attributes and kind in ("ellipsoid", "box"):
            count = 1
        size = read.vector(" ".join(words[:count]), count, f"size of {where}")
        if "fromto" in attributes and kind in _ALONG:
            ends = read.vector(attributes["fromto"], 6, f"fromto of {where}").reshape(2, 3)
            half = math.hypot(*(ends[0] - ends[1])) / 2.0
            placement = pin.SE3(turned_to(read.direction(ends[0] - ends[1], f"fromto of {where}")), ends.mean(axis=0))
            size = np.array([size[0], half] if kind in ("capsule", "cylinder") else [size[0], size[0], half])
        else:
            placement = read.placement(attributes, where)
        if not size.min() > 0.0:
            raise read.fail(f"size of {where} is {quoted(attributes.get('size', ''))}, which is not positive")
        return size, placement

    def _bounded(self, inertia: pin.Inertia) -> pin.Inertia:
        least = [
            max(0.0, self._read.figure(self._setting(key, "0"), f"{key} of <compiler>"))
            for key in ("boundmass", "boundinertia")
        ]
        if max(least) == 0.0:
            return inertia
        values, vectors = np.linalg.eigh(inertia.inertia)
        moments = vectors @ np.diag(np.maximum(values, least[1])) @ vectors.T
        return pin.Inertia(max(inertia.mass, least[0]), inertia.lever, moments)

    def _setting(self, key: str, usual: str) -> str:
        return self._read.compiler.others.get(key, usual)


def _solid(kind: str, size: np.ndarray) -> tuple[np.ndarray, float]:
    """Inertia about the centre for a mass of 1, and the volume."""
    if kind == "sphere":
        return pin.Inertia.FromSphere(1.0, size[0]).inertia, 4.0 / 3.0 * math.pi * size[0] ** 3
    if kind == "capsule":
        volume = math.pi * size[0] ** 2 * (2.0 * size[1] + 4.0 / 3.0 * size[0])
        return pin.Inertia.FromCapsule(1.0, size[0], 2.0 * size[1]).inertia, volume
    if kind == "cylinder":
        return pin.Inertia.FromCylinder(1.0, size[0], 2.0 * size[1]).inertia, 2.0 * math.pi * size[0] ** 2 * size[1]
    if kind == "ellipsoid":
        return pin.Inertia.FromEllipsoid(1.0, *size).inertia, 4.0 / 3.0 * math.pi * math.prod(size)
    return pin.Inertia.FromBox(1.0, *(2.0 * size)).inertia, 8.0 * math.prod(size)
