"""Damage to robot files, reproducible from a number: in their bytes, and in their structure."""

from __future__ import annotations

import copy
import random
from collections.abc import Callable
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

BYTES = (b"", b"\0", b"\xff\xfe", b"<", b">", b'"', b"&", b"&#0;", b"nan", b"-", b"1e999", b"]]>", b"<!--", b"\xf0\x9f")
# fmt: off
NUMBERS = (
    "nan", "inf", "-inf", "1e400", "-1e308", "1e300", "1e-320", "0", "-0", "-1", "+1", "1e9", "1e16", "0x10", "1_0",
    "1,5", "${pi}", "--", "3.141592653589793",
)
VECTORS = (
    "0 0 0", "nan 0 0", "0 0 1e300", "1e-9 0 0", "1 0", "1 0 0 0", "0 0 -1", "x y z", "", "1e7 0 0", "-1e5 0 0",
    "1.5707963 0 0", "0 1.5707963267948966 0",
)
TEXTS = ("", " ", "universe", "root_joint", "base_link", "a" * 2000, "a\nb", "..", "/", "\u202e", "é", "%s%n", "${x}")
KINDS = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar", "ball", "REVOLUTE")
TAGS = (
    "robot", "link", "joint", "inertial", "origin", "mass", "inertia", "parent", "child", "axis", "limit", "dynamics",
    "mimic", "visual", "gazebo",
)
# fmt: on


def mutated(text: str, seed: int) -> bytes:
    """A robot file with one to five things wrong, or not: every mutation is decided by the seed alone."""
    rng = random.Random(seed)
    if rng.random() < 0.4 or not text.lstrip().startswith("<"):
        return _damaged_bytes(text.encode(), rng)
    robot = ElementTree.fromstring(text)
    for _ in range(rng.choice((1, 1, 1, 2, 3, 5))):
        rng.choice(_STRUCTURE)(robot, rng)
    data = ElementTree.tostring(robot)
    return _damaged_bytes(data, rng) if rng.random() < 0.1 else data


def _damaged_bytes(data: bytes, rng: random.Random) -> bytes:
    for _ in range(rng.choice((1, 1, 2, 4, 16))):
        start = rng.randrange(len(data) + 1)
        end = min(len(data), start + rng.choice((0, 1, 1, 4, 40, 400)))
        put = rng.choice((rng.choice(BYTES), rng.randbytes(rng.randrange(9)), data[start:end] * 2, data[end:start:-1]))
        data = data[:start] + put + data[end:]
    if rng.random() < 0.02:
        data = data[: rng.randrange(len(data) + 1)]
    if rng.random() < 0.02:
        data = b'<!DOCTYPE r [<!ENTITY a "b"><!ENTITY c "&a;&a;">]>' + data
    return data


def _some(robot: Element, rng: random.Random, *tags: str) -> Element:
    """An element of these tags, or of any; the robot itself where there is none."""
    found = [element for element in robot.iter() if element is not robot and (not tags or element.tag in tags)]
    return rng.choice(found) if found else robot


def _number(robot: Element, rng: random.Random) -> None:
    element = _some(robot, rng, "limit", "mass", "inertia", "dynamics", "mimic")
    if element.attrib:
        element.set(rng.choice(list(element.attrib)), rng.choice(NUMBERS))


def _vector(robot: Element, rng: random.Random) -> None:
    element = _some(robot, rng, "origin", "axis")
    element.set(rng.choice(("xyz", "rpy", "quat_xyzw")), rng.choice(VECTORS))


def _range(robot: Element, rng: random.Random) -> None:
    limit = _some(robot, rng, "limit")
    lower, upper = limit.get("lower", "0"), limit.get("upper", "0")
    new = rng.choice(((upper, lower), (lower, lower), (lower, "1e300"), ("-1e308", "1e308"), ("7", "8"), ("0", "0")))
    limit.attrib.update(zip(("lower", "upper"), new, strict=True))


def _any_attribute(robot: Element, rng: random.Random) -> None:
    element = _some(robot, rng)
    if element.attrib:
        name = rng.choice(list(element.attrib))
        if rng.random() < 0.3:
            del element.attrib[name]
        else:
            element.set(name, rng.choice(TEXTS + NUMBERS))


def _kind(robot: Element, rng: random.Random) -> None:
    _some(robot, rng, "joint").set("type", rng.choice(KINDS))


def _end(robot: Element, rng: random.Random) -> None:
    links = [link.get("name", "") for link in robot.findall("link")] or [""]
    _some(robot, rng, "parent", "child").set("link", rng.choice(links))


def _same_name(robot: Element, rng: random.Random) -> None:
    tag = rng.choice(("link", "joint"))
    _some(robot, rng, tag).set("name", _some(robot, rng, tag).get("name", ""))


def _tag(robot: Element, rng: random.Random) -> None:
    _some(robot, rng).tag = rng.choice(TAGS)


def _removed(robot: Element, rng: random.Random) -> None:
    parent = _some(robot, rng) if rng.random() < 0.7 else robot
    if len(parent):
        parent.remove(rng.choice(list(parent)))


def _doubled(robot: Element, rng: random.Random) -> None:
    parent = _some(robot, rng) if rng.random() < 0.5 else robot
    if len(parent):
        parent.insert(rng.randrange(len(parent) + 1), copy.deepcopy(rng.choice(list(parent))))


def _moved(robot: Element, rng: random.Random) -> None:
    element = copy.deepcopy(_some(robot, rng))
    _some(robot, rng).append(element)


def _nested(robot: Element, rng: random.Random) -> None:
    inner = _some(robot, rng)
    for _ in range(rng.choice((3, 100))):
        inner = ElementTree.SubElement(inner, rng.choice(TAGS))


def _grown(robot: Element, rng: random.Random) -> None:
    """A chain of more joints at the end of some link."""
    above = _some(robot, rng, "link").get("name", "")
    kind = rng.choice(("revolute", "fixed", "floating", "continuous"))
    for k in range(rng.choice((1, 7, 60, 600))):
        name = f"grown_{k}"
        ElementTree.SubElement(robot, "link", name=name)
        joint = ElementTree.SubElement(robot, "joint", name=name, type=kind)
        ElementTree.SubElement(joint, "parent", link=above)
        ElementTree.SubElement(joint, "child", link=name)
        ElementTree.SubElement(joint, "axis", xyz=rng.choice(("1 0 0", "0 1 0", "0 0 1")))
        ElementTree.SubElement(joint, "limit", lower="-1", upper="1", effort="1", velocity="1")
        above = name


_STRUCTURE: tuple[Callable[[Element, random.Random], None], ...] = (
    _number,
    _number,
    _vector,
    _vector,
    _range,
    _any_attribute,
    _kind,
    _end,
    _same_name,
    _tag,
    _removed,
    _doubled,
    _moved,
    _nested,
    _grown,
)
