"""Bodies of an MJCF file with their joints and sites, each in the frame of what carries it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Literal, NamedTuple
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from srs_ik.errors import quoted
from srs_ik.robot.description.mjcf.attributes import ORIENTATION, Attributes, Reader, turned_to, words
from srs_ik.robot.description.mjcf.mass import Masses
from srs_ik.system import bounds

Kind = Literal["hinge", "slide", "ball", "free"]

FREEDOM = {"hinge": 1, "slide": 1, "ball": 3, "free": 6}
WORLD = "world"

_PLACE = frozenset({"name", "childclass", "pos"}) | ORIENTATION
_BODY = _PLACE | {"mocap", "gravcomp", "sleep", "simple", "user"}
_JOINT = words(
    "name class type group pos axis springdamper limited actuatorfrclimited solreflimit solimplimit solreffriction "
    "solimpfriction stiffness range actuatorfrcrange actuatorgravcomp margin ref springref armature damping "
    "frictionloss user"
)
_FREEJOINT = frozenset({"name", "group", "align"})
_SITE = ORIENTATION | words("name class type group pos material size fromto rgba user")
_WITHOUT_EFFECT = frozenset({"camera", "light", "plugin"})
_REPEATED = frozenset({"geom", "camera", "light"})
"""What a ``<replicate>`` may hold: the names of bodies, joints and sites in it would have to be made up."""


@dataclass(frozen=True, eq=False)
class Joint:
    """A joint of a body."""

    name: str  # its name
    kind: Kind  # "hinge", "slide", "ball" or "free"
    anchor: np.ndarray  # (3,) a point that it leaves in place, in the frame of its body, metres
    axis: np.ndarray  # (3,) unit vector, in the same frame
    lower: float  # lower limit, rad or metres; -inf where there is none
    upper: float  # upper limit; inf where there is none
    effort: float  # largest force or torque of all actuators on it together, N or N m; inf where the joint says none
    ref: float  # position at which the body lies as the file places it, rad or metres
    damping: float = 0.0  # force or torque over speed, N s/m or N m s/rad
    friction: float = 0.0  # dry friction, N or N m
    armature: float = 0.0  # inertia of its rotor, kg or kg m^2


@dataclass(eq=False)
class Body:
    """A body.

    Attributes:
        name: its name.
        parent: index of the body that carries it; the world, which is body 0, has -1.
        placement: its frame in that of the parent, with every joint at its reference.
        joints: its joints; the first moves all that follow.
        sites: name and placement of each site that has a name.
        masses: what it weighs.
    """

    name: str
    parent: int
    placement: pin.SE3
    masses: Masses
    joints: list[Joint] = field(default_factory=list)
    sites: list[tuple[str, pin.SE3]] = field(default_factory=list)


class _Scope(NamedTuple):
    """Where elements stand: index of the body, the frame they are placed in, their default class, and its element."""

    body: int
    frame: pin.SE3
    childclass: str
    element: Element


def read_bodies(root: Element, read: Reader) -> list[Body]:
    """Every body below the element ``<mujoco>``, parents before children, the world first.

    Raises:
        InvalidRobot: an element or attribute that moves things makes no sense or is not understood, a name is used
            twice, or there are no bodies or too many.
    """
    return _Tree(read).bodies_of(root)


class _Tree:
    def __init__(self, read: Reader) -> None:
        self._read = read
        self._bodies = [Body(WORLD, -1, pin.SE3.Identity(), Masses(read))]
        self._names: dict[str, set[str]] = {"body": {WORLD}, "joint": set(), "site": set(), "frame": set()}
        self._freedom = 0

    def bodies_of(self, root: Element) -> list[Body]:
        for section in root.iterfind("worldbody"):
            self._read.known(section, (), "<worldbody>")
            self._world(section)
        if len(self._bodies) == 1:
            raise self._read.fail("it is an MJCF file without any <body>")
        return self._bodies

    def _world(self, section: Element) -> None:
        scope = _Scope(0, pin.SE3.Identity(), "main", section)
        # By hand, not by recursion: files may nest deeper than Python does.
        pending: list[tuple[Iterator[Element], _Scope]] = [(iter(section), scope)]
        while pending:
            elements, scope = pending[-1]
            element = next(elements, None)
            if element is None:
                pending.pop()
            elif element.tag == "body":
                pending.append((iter(element), self._body(element, scope)))
            elif element.tag == "frame":
                pending.append((iter(element), self._frame(element, scope)))
            else:
                self._other(element, scope)

    def _body(self, element: Element, scope: _Scope) -> _Scope:
        name = self._name(element, "body", f"body{len(self._bodies)}")
        where = f"body {quoted(name)}"
        self._read.known(element, _BODY, where)
        self._read.one_orientation(element.attrib, where)
        if len(self._bodies) > bounds.LINKS:
            raise self._read.fail(f"it has more than the {bounds.LINKS} bodies that are read")
        placement = scope.frame * self._read.placement(element.attrib, where)
        self._bodies.append(Body(name, scope.body, placement, Masses(self._read)))
        return _Scope(len(self._bodies) - 1, pin.SE3.Identity(), self._childclass(element, scope, where), element)

    def _frame(self, element: Element, scope: _Scope) -> _Scope:
        where = f"frame {quoted(element.get('name', ''))}"
        if "name" in element.attrib:
            self._name(element, "frame", "")
        self._read.known(element, _PLACE, where)
        self._read.one_orientation(element.attrib, where)
        frame = scope.frame * self._read.placement(element.attrib, where)
        return _Scope(scope.body, frame, self._childclass(element, scope, where), element)

    def _childclass(self, element: Element, scope: _Scope, where: str) -> str:
        name = element.get("childclass")
        return scope.childclass if name is None else self._read.class_named(name, where)

    def _other(self, element: Element, scope: _Scope) -> None:
        body = self._bodies[scope.body]
        where = f"<{element.tag[:60]}> of body {quoted(body.name)}"
        if element.tag in ("joint", "freejoint", "inertial") and scope.body == 0:
            raise self._read.fail(f"the world has a <{element.tag}>; it moves and weighs nothing")
        if element.tag == "joint":
            self._joint(element, scope, body)
        elif element.tag == "freejoint":
            name = self._name(element, "joint", f"{body.name}_free")
            self._read.known(element, _FREEJOINT, f"joint {quoted(name)}")
            self._add(
                body, Joint(name, "free", np.zeros(3), np.array([0.0, 0.0, 1.0]), -math.inf, math.inf, math.inf, 0)
            )
        elif element.tag == "site":
            self._site(element, scope, body)
        elif element.tag == "geom":
            body.masses.geom(self._read.merged(element, scope.childclass, where), scope.frame, where)
        elif element.tag == "inertial":
            body.masses.inertial(element, scope.element.tag == "body", where)
        elif element.tag == "replicate" and all(inner.tag in _REPEATED for inner in element):
            body.masses.unknown = True
        elif element.tag not in _WITHOUT_EFFECT:
            raise self._read.fail(f"body {quoted(body.name)} has a <{element.tag[:60]}>, which is not understood")

    def _joint(self, element: Element, scope: _Scope, body: Body) -> None:
        read = self._read
        name = self._name(element, "joint", f"{body.name}Joint_{len(body.joints)}")
        where = f"joint {quoted(name)}"
        attributes = read.merged(element, scope.childclass, where)
        for key in attributes:
            if key not in _JOINT:
                raise read.fail(f"{where} has the attribute {quoted(key)}, which is not understood")
        read.joint_choices(attributes, where)
        kind: Kind = attributes.get("type", "hinge")  # type: ignore[assignment]
        turns, moves = kind in ("hinge", "ball"), kind != "free"
        anchor = scope.frame.act(read.position(attributes.get("pos", "0 0 0"), f"pos of {where}"))
        axis = read.vector(attributes.get("axis", "0 0 1"), 3, f"axis of {where}")
        if kind in ("hinge", "slide"):
            axis = scope.frame.rotation @ read.direction(axis, f"axis of {where}")
        lower, upper = self._range(attributes, "limited", "range", kind, where)
        if turns:
            lower, upper = read.angle(lower), read.angle(upper)
        least, most = self._range(attributes, "actuatorfrclimited", "actuatorfrcrange", kind, where)
        ref = read.figure(attributes.get("ref", "0"), f"ref of {where}")
        if kind == "hinge":
            ref = read.angle(ref)
        if abs(ref) > bounds.FARTHEST or lower >= bounds.FARTHEST or upper <= -bounds.FARTHEST:
            raise read.fail(f"{where} has limits or a ref that are out of any reach")
        effort = min(-least, most) if least < 0.0 < most else math.inf
        losses = [self._loss(attributes, key, where) for key in ("damping", "frictionloss", "armature")]
        self._add(body, Joint(name, kind, anchor if moves else np.zeros(3), axis, lower, upper, effort, ref, *losses))

    def _loss(self, attributes: Attributes, key: str, where: str) -> float:
        """A figure from 0 on; of a damping that depends on the speed, the part that does not, which comes first."""
        word = attributes.get(key, "0")
        loss = self._read.figure(word.split()[0] if key == "damping" and word.split() else word, f"{key} of {where}")
        if not 0.0 <= loss <= bounds.FARTHEST:
            raise self._read.fail(f"{where} has the {key} {loss:g}, which is negative or beyond any reach")
        return loss

    def _range(self, attributes: Attributes, limited: str, key: str, kind: Kind, where: str) -> tuple[float, float]:
        """A range where it counts, infinite otherwise."""
        read = self._read
        lower, upper = read.vector(attributes.get(key, "0 0"), 2, f"{key} of {where}")
        counts = attributes.get(limited, "auto")
        if kind == "free" or (kind == "ball" and key != "range") or counts == "false":
            return -math.inf, math.inf
        given = lower != 0.0 or upper != 0.0
        if counts == "auto" and not given:
            return -math.inf, math.inf
        if counts == "auto" and not read.compiler.autolimits:
            raise read.fail(f"{where} has a {key} but no {limited}, and <compiler> says autolimits='false'")
        if not lower < upper or (kind == "ball" and lower != 0.0):
            raise read.fail(
                f"{where} has the {key} {lower:g} {upper:g}: a lower limit above its upper limit, or no range"
            )
        return float(lower), float(upper)

    def _add(self, body: Body, joint: Joint) -> None:
        kinds = [*(other.kind for other in body.joints), joint.kind]
        where = f"joint {quoted(joint.name)}"
        if "free" in kinds and (len(kinds) > 1 or body.parent != 0):
            raise self._read.fail(f"{where} is not understood: a free joint is the only one of a body on the world")
        if sum(FREEDOM[kind] for kind in kinds) > 6 or ("ball" in kinds[:-1] and joint.kind != "slide"):
            raise self._read.fail(f"{where} is one more than the body {quoted(body.name)} can have")
        self._freedom += FREEDOM[joint.kind]
        if self._freedom > bounds.FREEDOM:
            raise self._read.fail(f"it has more than the {bounds.FREEDOM} degrees of freedom that are read")
        body.joints.append(joint)

    def _site(self, element: Element, scope: _Scope, body: Body) -> None:
        where = f"site {quoted(element.get('name', ''))}"
        attributes = self._read.merged(element, scope.childclass, where)
        for key in attributes:
            if key not in _SITE:
                raise self._read.fail(f"{where} has the attribute {quoted(key)}, which is not understood")
        if "fromto" in attributes:
            ends = self._read.vector(attributes["fromto"], 6, f"fromto of {where}").reshape(2, 3)
            if "pos" in attributes:
                raise self._read.fail(f"{where} has a fromto and a pos; one is enough")
            z = self._read.direction(ends[0] - ends[1], f"fromto of {where}")
            placement = pin.SE3(turned_to(z), ends.mean(axis=0))
        else:
            placement = self._read.placement(attributes, where)
        if "name" in element.attrib:
            body.sites.append((self._name(element, "site", ""), scope.frame * placement))

    def _name(self, element: Element, what: str, otherwise: str) -> str:
        """The name of an element, which no other of its kind bears."""
        names = self._names[what]
        name = element.get("name", "")
        if not name:
            name = otherwise
            while name in names:
                name += "_"
        if name in names:
            raise self._read.fail(f"the {what} name {quoted(name)} is used twice")
        if len(name) > bounds.NAME or not name.isprintable():
            message = f"the {what} name {quoted(name)} cannot be printed, or is longer than {bounds.NAME}"
            raise self._read.fail(message)
        if name == "universe":
            message = "something in it is called 'universe', which is Pinocchio's name of the world"
            raise self._read.fail(message)
        names.add(name)
        return name
