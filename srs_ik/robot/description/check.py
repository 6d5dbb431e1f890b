"""Checks of a URDF's elements before any library sees them, so that what is wrong is said in one clear sentence."""

from __future__ import annotations

import math
from typing import NamedTuple
from xml.etree.ElementTree import Element

from srs_ik.errors import InvalidRobot, did_you_mean, quoted
from srs_ik.robot.description.figures import figure
from srs_ik.system import bounds

JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
_WITH_AXIS = frozenset({"revolute", "continuous", "prismatic", "planar"})
_WITH_RANGE = frozenset({"revolute", "prismatic"})

_FREEDOM = {"revolute": 1, "continuous": 1, "prismatic": 1, "planar": 3, "floating": 6}

_MIN_AXIS = 1e-6
"""Shortest joint axis that is taken for a direction; unit axes are the rule."""

_INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_MASSES = f"a mass is between 0 and {bounds.HEAVIEST:g} kg"


class Follower(NamedTuple):
    """How a joint follows another one: it is at ``multiplier * position of the leader + offset``, rad or m."""

    leader: str  # name of the other joint; empty where the file does not say
    multiplier: float = 1.0
    offset: float = 0.0


def check(robot: Element, source: str) -> dict[str, Follower]:
    """Check the elements of a robot, and settle in place what files leave open.

    A robot without a name is called "robot". Every figure is replaced by its shortest exact decimal form. Negative or
    absent efforts and velocities become 0, which means "not given" (Pinocchio refuses negative ones). Elements without
    effect are removed: limits and axes of joints that have none, inertias without mass or matrix, and `<mimic>`.

    Args:
        robot: the element `<robot>`, as `srs_ik.robot.description.document.parse` returns it; changed in place.
        source: what error messages call it.

    Returns:
        For each joint that mimics another one how it does.

    Raises:
        InvalidRobot: names are missing or used twice, figures are no finite numbers, a range is reversed, an axis has
            no direction, or links and joints are not one tree.
    """
    return _Checker(source).robot(robot)


class _Checker:
    """The checks, with the source that their messages name."""

    def __init__(self, source: str) -> None:
        self.source = source

    def fail(self, what: str) -> InvalidRobot:
        return InvalidRobot(f"{self.source}: {what}", self.source)

    def robot(self, robot: Element) -> dict[str, Follower]:
        # Parsers refuse a robot without a name; makers leave it out all the same.
        robot.attrib["name"] = robot.get("name", "").strip() or "robot"
        self.name(robot, "the <robot> element")
        links, joints = robot.findall("link"), robot.findall("joint")
        if not links:
            raise self.fail("there is no <link> in it")
        if len(links) > bounds.LINKS:
            raise self.fail(f"it has {len(links)} links, more than the {bounds.LINKS} that are read")
        self.unique([self.name(link, f"<link> number {k}") for k, link in enumerate(links, 1)], "link")
        self.unique([self.name(joint, f"<joint> number {k}") for k, joint in enumerate(joints, 1)], "joint")
        for link in links:
            self.link(link)
        freedom = sum(_FREEDOM.get(joint.get("type", ""), 0) for joint in joints)
        if freedom > bounds.FREEDOM:
            raise self.fail(
                f"its joints have {freedom} degrees of freedom, more than the {bounds.FREEDOM} that are read"
            )
        followers = {joint.attrib["name"]: self.joint(joint) for joint in joints}
        self.tree([link.attrib["name"] for link in links], joints)
        # The version decides whether quaternions count; without any it only makes parsers complain of unknown ones.
        has_quaternion = any("quat_xyzw" in origin.attrib for origin in robot.iter("origin"))
        kept = {"name", "version"} if has_quaternion else {"name"}
        robot.attrib = {key: value for key, value in robot.attrib.items() if key in kept}
        return {name: follower for name, follower in followers.items() if follower is not None}

    def name(self, element: Element, which: str) -> str:
        name = element.get("name", "")
        if not name.strip():
            raise self.fail(f"{which} has no name")
        if len(name) > bounds.NAME:
            raise self.fail(f"{which} has a name of {len(name)} characters, {quoted(name)}; {bounds.NAME} are read")
        if not name.isprintable():
            raise self.fail(f"{which} has the name {quoted(name)}, with characters that cannot be printed")
        return name

    def unique(self, names: list[str], what: str) -> None:
        seen: set[str] = set()
        for name in names:
            if name in seen:
                raise self.fail(f"the {what} name {quoted(name)} is used twice")
            seen.add(name)

    def link(self, link: Element) -> None:
        inertial = link.find("inertial")
        if inertial is None:
            return
        where = f"inertia of link {quoted(link.attrib['name'])}"
        mass, inertia = inertial.find("mass"), inertial.find("inertia")
        if (
            mass is None
            or inertia is None
            or "value" not in mass.attrib
            or any(k not in inertia.attrib for k in _INERTIA)
        ):
            link.remove(inertial)
            return
        if not 0.0 <= self.number(mass, "value", where) <= bounds.HEAVIEST:
            raise self.fail(f"the mass of link {quoted(link.attrib['name'])} is {mass.attrib['value']}; {_MASSES}")
        for key in _INERTIA:
            if abs(self.number(inertia, key, where)) > bounds.HEAVIEST:
                raise self.fail(f"{key} of the {where} is {inertia.attrib[key]}, more than {bounds.HEAVIEST:g} kg m^2")
        self.origin(inertial, where)

    def joint(self, joint: Element) -> Follower | None:
        """Check one joint; how it mimics another, or None."""
        where = f"joint {quoted(joint.attrib['name'])}"
        if joint.attrib["name"] == "universe":
            raise self.fail("a joint of it is called 'universe', which is Pinocchio's name of the world")
        kind = joint.get("type")
        if kind is None:
            raise self.fail(f"{where} has no type; types are {', '.join(JOINT_TYPES)}")
        if kind not in JOINT_TYPES:
            raise self.fail(f"{where} has the unknown type {quoted(kind)}; types are {', '.join(JOINT_TYPES)}")
        joint.attrib = {"name": joint.attrib["name"], "type": kind}
        for end in ("parent", "child"):
            element = joint.find(end)
            if element is None or not element.get("link", "").strip():
                raise self.fail(f"{where} has no {end} link")
        self.origin(joint, where)
        self.axis(joint, kind, where)
        self.limit(joint, kind, where)
        self.dynamics(joint, kind, where)
        return self.mimic(joint, kind, where)

    def origin(self, element: Element, where: str) -> None:
        origin = element.find("origin")
        if origin is None:
            return
        for key, length in (("xyz", 3), ("rpy", 3), ("quat_xyzw", 4)):
            if key in origin.attrib:
                values = self.vector(origin, key, length, where)
                if key == "xyz" and max(map(abs, values)) > bounds.FARTHEST:
                    far = quoted(origin.attrib[key])
                    raise self.fail(
                        f"<origin> xyz of {where} is {far}, farther than {bounds.FARTHEST:g} m; figures are metres"
                    )
                if key == "quat_xyzw" and not _MIN_AXIS < math.hypot(*values) < bounds.FARTHEST:
                    raise self.fail(f"<origin> quat_xyzw of {where} is {quoted(origin.attrib[key])}, no rotation")

    def axis(self, joint: Element, kind: str, where: str) -> None:
        axis = joint.find("axis")
        if axis is None:
            return
        if kind not in _WITH_AXIS:
            joint.remove(axis)
        elif "xyz" not in axis.attrib:
            raise self.fail(f"{where} has an <axis> without xyz")
        elif math.hypot(*self.vector(axis, "xyz", 3, where)) < _MIN_AXIS:
            raise self.fail(f"{where} has the axis {quoted(axis.attrib['xyz'])}, which has no direction")

    def limit(self, joint: Element, kind: str, where: str) -> None:
        limit = joint.find("limit")
        if limit is None:
            if kind in _WITH_RANGE:
                raise self.fail(f"{where} is {kind} but has no <limit>; one without stops has the type continuous")
            return
        if kind not in _WITH_RANGE and kind != "continuous":
            joint.remove(limit)
            return
        kept = {key: max(0.0, self.number(limit, key, where, 0.0)) for key in ("effort", "velocity")}
        if kind in _WITH_RANGE:
            lower, upper = (self.number(limit, key, where, 0.0) for key in ("lower", "upper"))
            if lower > upper:
                raise self.fail(f"{where} has the lower limit {lower!r} above its upper limit {upper!r}")
            if lower >= bounds.FARTHEST or upper <= -bounds.FARTHEST:
                raise self.fail(f"{where} has the limits {lower!r} and {upper!r}, which are out of any reach")
            kept |= {"lower": lower, "upper": upper}
        limit.attrib = {key: repr(value) for key, value in kept.items()}

    def dynamics(self, joint: Element, kind: str, where: str) -> None:
        dynamics = joint.find("dynamics")
        if dynamics is None:
            return
        values = {key: self.number(dynamics, key, where, 0.0) for key in ("damping", "friction")}
        if kind == "fixed" or min(values.values()) < 0.0:
            joint.remove(dynamics)
        else:
            dynamics.attrib = {key: repr(value) for key, value in values.items()}

    def mimic(self, joint: Element, kind: str, where: str) -> Follower | None:
        mimic = joint.find("mimic")
        if mimic is None:
            return None
        joint.remove(mimic)
        if kind == "fixed":
            return None
        multiplier, offset = (self.number(mimic, key, where, x) for key, x in (("multiplier", 1.0), ("offset", 0.0)))
        if max(abs(multiplier), abs(offset)) > bounds.FARTHEST:
            raise self.fail(f"<mimic> of {where} has a figure beyond {bounds.FARTHEST:g}")
        return Follower(mimic.get("joint", ""), multiplier, offset)

    def number(self, element: Element, key: str, where: str, default: float | None = None) -> float:
        if key not in element.attrib and default is not None:
            return default
        value = self.figure(element.attrib[key], f"<{element.tag}> {key} of {where}")
        element.attrib[key] = repr(value)
        return value

    def vector(self, element: Element, key: str, length: int, where: str) -> list[float]:
        words = element.attrib[key].split()
        what = f"<{element.tag}> {key} of {where}"
        if len(words) != length:
            raise self.fail(f"{what} is {quoted(element.attrib[key])}, not {length} numbers")
        values = [self.figure(word, what) for word in words]
        element.attrib[key] = " ".join(map(repr, values))
        return values

    def figure(self, text: str, what: str) -> float:
        value = figure(text)
        if math.isnan(value):
            raise self.fail(f"{what} is {quoted(text)}, not a finite number")
        return value

    def tree(self, links: list[str], joints: list[Element]) -> None:
        """Check that links and joints are one tree that is not too deep."""
        known = set(links)
        joint_above: dict[str, str] = {}
        children: dict[str, list[str]] = {}
        for joint in joints:
            where = quoted(joint.attrib["name"])
            parent, child = (_attribute(joint, end) for end in ("parent", "child"))
            for end, link in (("parent", parent), ("child", child)):
                if link not in known:
                    raise self.fail(f"the {end} {quoted(link)} of joint {where} is no link{did_you_mean(link, links)}")
            if child in joint_above:
                above = quoted(joint_above[child])
                raise self.fail(f"the link {quoted(child)} is the child of two joints, {above} and {where}")
            joint_above[child] = joint.attrib["name"]
            children.setdefault(parent, []).append(child)
        roots = [link for link in links if link not in joint_above]
        if len(roots) > 1:
            names = ", ".join(map(quoted, roots[:5])) + (", ..." if len(roots) > 5 else "")
            raise self.fail(f"it has {len(roots)} links without a parent joint, not one: {names}")
        reached: set[str] = set()
        level, depth = roots, 0
        while level:
            if depth > bounds.CHAIN:
                raise self.fail(f"it has a chain of more than {bounds.CHAIN} joints, longer than is read")
            reached.update(level)
            level = [child for link in level for child in children.get(link, ())]
            depth += 1
        lost = [link for link in links if link not in reached]
        if lost:
            raise self.fail(f"its joints form a closed loop at the link {quoted(lost[0])}; a URDF is a tree")


def _attribute(joint: Element, end: str) -> str:
    element = joint.find(end)
    return "" if element is None else element.attrib["link"]
