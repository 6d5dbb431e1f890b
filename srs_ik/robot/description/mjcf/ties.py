"""Joints of an MJCF file that an ``<equality>`` ties to others, so that none of them moves freely."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from xml.etree.ElementTree import Element

from srs_ik.errors import quoted
from srs_ik.robot.description.mjcf.attributes import Reader, words
from srs_ik.robot.description.mjcf.bodies import FREEDOM, Body, Joint

_ALWAYS = words("name class active solref solimp")
_ATTRIBUTES = {
    "joint": words("joint1 joint2 polycoef"),
    "tendon": words("tendon1 tendon2 polycoef"),
    "connect": words("body1 body2 anchor site1 site2"),
    "weld": words("body1 body2 relpose anchor site1 site2 torquescale"),
    # Those of soft bodies, which have no joints.
    "flex": words("flex"),
    "flexvert": words("flex"),
    "flexstrain": words("flex cell"),
}


def tied_joints(root: Element, bodies: Sequence[Body], read: Reader) -> dict[str, float | None]:
    """The joints that are tied: by a polynomial, by a tendon, or in a loop that a connection closes.

    A constraint with ``active="false"`` does not count. With each joint is where it is held, rad or m: by a constant,
    which MuJoCo counts from the joint's ``ref``; None where that depends on others.

    Raises:
        InvalidRobot: a constraint is of an unknown kind, or names what is not there.
    """
    ties = _Ties(root, bodies, read)
    tied = dict.fromkeys(ties.names())
    return {name: ties.held.get(name) for name in tied}


class _Ties:
    def __init__(self, root: Element, bodies: Sequence[Body], read: Reader) -> None:
        self._root, self._bodies, self._read = root, bodies, read
        self._joints = {joint.name: joint for body in bodies for joint in body.joints if FREEDOM[joint.kind] == 1}
        self.held: dict[str, float] = {}
        self._body = {body.name: k for k, body in enumerate(bodies)}
        self._site = {name: k for k, body in enumerate(bodies) for name, _ in body.sites}

    def names(self) -> Iterator[str]:
        for section in self._root.iterfind("equality"):
            for element in section:
                where = f"<{element.tag[:60]}> of <equality>"
                if element.tag not in _ATTRIBUTES:
                    raise self._read.fail(f"{where} is not understood")
                self._read.known(element, _ALWAYS | _ATTRIBUTES[element.tag], where)
                tied = list(self._tied_by(element, where))
                if self._read.choice(element.attrib, "active", ("true", "false"), "true", where) == "true":
                    yield from tied
                    if element.tag == "joint" and "joint2" not in element.attrib:
                        self._hold(self._joints[tied[0]], element, where)

    def _hold(self, joint: Joint, element: Element, where: str) -> None:
        constant = self._read.figure([*element.get("polycoef", "").split(), "0"][0], f"polycoef of {where}")
        self.held[joint.name] = joint.ref + constant

    def _tied_by(self, element: Element, where: str) -> Iterator[str]:
        if element.tag == "joint":
            yield from self._named(element, ("joint1", "joint2"), where)
        elif element.tag == "tendon":
            yield from self._of_tendons(element, where)
        elif element.tag in ("connect", "weld"):
            yield from self._of_loop(element, where)

    def _named(self, element: Element, keys: Sequence[str], where: str) -> Iterator[str]:
        for key in keys:
            if key == keys[0] or key in element.attrib:
                yield self._there(element.get(key, ""), self._joints, f"{key} of {where}")

    def _of_tendons(self, element: Element, where: str) -> Iterator[str]:
        wanted = {element.get(key) for key in ("tendon1", "tendon2")} - {None}
        tendons = [tendon for section in self._root.iterfind("tendon") for tendon in section]
        for tendon in tendons:
            if tendon.get("name") not in wanted:
                continue
            if tendon.tag != "fixed":
                raise self._read.fail(f"{where} holds a <{tendon.tag[:60]}> tendon, which is not understood")
            for joint in tendon.iterfind("joint"):
                self._read.known(joint, ("joint", "coef"), f"<joint> of tendon {quoted(tendon.get('name', ''))}")
                yield from self._named(joint, ("joint",), where)

    def _of_loop(self, element: Element, where: str) -> Iterator[str]:
        """The joints between two bodies, or between one and the world."""
        ways = []
        by_site = "site1" in element.attrib
        for key in ("site1", "site2") if by_site else ("body1", "body2"):
            known = self._site if by_site else self._body
            name = element.get(key, "" if key.endswith("1") or by_site else "world")
            ways.append(set(self._way(known[self._there(name, known, f"{key} of {where}")])))
        for k in ways[0] ^ ways[1]:
            yield from (joint.name for joint in self._bodies[k].joints)

    def _way(self, body: int) -> Iterator[int]:
        while body > 0:
            yield body
            body = self._bodies[body].parent

    def _there(self, name: str, known: object, what: str) -> str:
        if name not in known:  # type: ignore[operator]
            raise self._read.fail(f"{what} is {quoted(name)}, which is not there")
        return name
