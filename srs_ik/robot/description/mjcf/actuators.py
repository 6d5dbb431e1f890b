"""What the actuators of an MJCF file can do at a joint: their force limits, by their gear."""

from __future__ import annotations

import math
from xml.etree.ElementTree import Element

from srs_ik.errors import quoted
from srs_ik.robot.description.mjcf.attributes import ACTUATORS, Attributes, Reader, words

_LAWS = words("kp kv dampratio timeconst")
"""Attributes, of a default class, that stand for a law between control and force."""


def joint_efforts(root: Element, read: Reader) -> dict[str, float]:
    """The force or torque, N or N m, that the actuators of each joint reach to both sides; inf where it has no limit.

    Raises:
        InvalidRobot: a figure is none, or a class is not defined.
    """
    ranges: dict[str, tuple[float, float]] = {}
    for section in root.iterfind("actuator"):
        for element in section:
            joint = element.get("joint", element.get("jointinparent"))
            if element.tag in ACTUATORS and joint is not None:
                least, most = ranges.get(joint, (0.0, 0.0))
                low, high = _range_of(element, read)
                ranges[joint] = least + low, most + high
    return {joint: min(-least, most) if least < 0.0 < most else math.inf for joint, (least, most) in ranges.items()}


def _range_of(element: Element, read: Reader) -> tuple[float, float]:
    """Least and largest torque of an actuator at its joint."""
    where = f"<{element.tag}> {quoted(element.get('name', ''))}"
    attributes = read.merged_actuator(element, where)
    ranges = [_limited(attributes, "force", 1.0, read, where)]
    if element.tag == "motor":
        ranges.append(_limited(attributes, "ctrl", 1.0, read, where))
    elif element.tag == "general" and _is_gain(attributes):
        gain = _first(attributes, "gainprm", read, where)
        ranges.append(_limited(attributes, "ctrl", gain, read, where))
    gear = _first(attributes, "gear", read, where)
    ends = [gear * end for end in (max(low for low, _ in ranges), min(high for _, high in ranges))] if gear else [0.0]
    return min(ends), max(ends)


def _is_gain(attributes: Attributes) -> bool:
    """Whether the force of a general actuator is its control times a gain."""
    fixed = attributes.get("gaintype", "fixed") == "fixed" and attributes.get("biastype", "none") == "none"
    return fixed and attributes.get("dyntype", "none") == "none" and not _LAWS & attributes.keys()


def _limited(attributes: Attributes, kind: str, gain: float, read: Reader, where: str) -> tuple[float, float]:
    """The range of force or control where it counts, times a gain; infinite otherwise."""
    least, most = read.vector(attributes.get(f"{kind}range", "0 0"), 2, f"{kind}range of {where}")
    counts = attributes.get(f"{kind}limited", "auto")
    if counts == "auto" and least < most and not read.compiler.autolimits:
        raise read.fail(f"{where} has a {kind}range but no {kind}limited, and <compiler> says autolimits='false'")
    if counts == "false" or not least < most or gain == 0.0:
        return -math.inf, math.inf
    ends = float(gain * least), float(gain * most)
    return min(ends), max(ends)


def _first(attributes: Attributes, key: str, read: Reader, where: str) -> float:
    """The first of some figures; 1 where they are not given."""
    return read.figure((attributes.get(key, "1").split() or [""])[0], f"{key} of {where}")
