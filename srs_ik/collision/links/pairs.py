"""Which bodies of an arm are watched for meeting each other, and why others are not."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING

from srs_ik.collision.links.bodies import Body
from srs_ik.collision.links.ranges import JointRange
from srs_ik.collision.links.survey import MANY, Survey
from srs_ik.errors import InvalidRobot, listed
from srs_ik.robot.description.model import is_xml
from srs_ik.robot.description.shapes import read_tree
from srs_ik.robot.description.srdf import Disabled, disabled

if TYPE_CHECKING:
    from srs_ik.kinematics import ChainKinematics
    from srs_ik.robot.description.model import Drawing


@dataclass(frozen=True)
class Pair:
    """Two bodies of an arm.

    Attributes:
        first: name of the one nearer to the base.
        second: name of the other.
        kept: whether they are watched.
        reason: why, in a word or two.
    """

    first: str
    second: str
    kept: bool
    reason: str


def find_pairs(
    arm: ChainKinematics, bodies: Sequence[Body], drawing: Drawing | None, srdf: str | Path | None
) -> tuple[list[Pair], list[JointRange]]:
    """All pairs of bodies of an arm, each kept or not, with the reason, and ranges of joints that keep some apart.

    Bodies on one joint are rigid to each other, and links that one joint connects touch at it. With an SRDF, what that
    disables is not watched; without, what touches at more than 95 % of random postures on the real shapes, and what is
    proved never to meet: the distance at the middle of a box of joint angles, and how far any point can move in it.

    Args:
        arm: the seven joints.
        bodies: its bodies.
        drawing: where the tree of links is.
        srdf: path or text of an SRDF file.

    Raises:
        InvalidRobot: the SRDF file is missing or no SRDF, disables nothing, or is of another robot.
    """
    said = None if srdf is None else _said_of(arm, drawing, srdf)
    neighbours = _neighbours(arm, bodies, drawing)
    survey = None
    pairs = []
    ranges = []
    for i, j in combinations(range(len(bodies)), 2):
        a, b = bodies[i], bodies[j]
        if a.joint > b.joint:
            i, j, a, b = j, i, b, a
        names = frozenset((a.name, b.name))
        if a.joint == b.joint:
            pairs.append(Pair(a.name, b.name, False, "on one joint"))
        elif said is not None and said.reason(names):
            pairs.append(Pair(a.name, b.name, False, f"SRDF: {said.reason(names)}"))
        elif said is not None and b.joint != a.joint + 2:
            pairs.append(Pair(a.name, b.name, True, "watched"))
        elif names in neighbours and srdf is None:
            pairs.append(Pair(a.name, b.name, False, "adjacent"))
        else:
            survey = survey or Survey(arm, bodies)
            reason = survey.reason(i, j) if srdf is None else ""
            found = None if reason else survey.told_by_a_joint(i, j)
            if found is None and not reason and srdf is None and survey.only_spheres_meet(i, j):
                reason = f"spheres always meet, shapes at none of {MANY} postures"
            if found is not None and found.bounds.min() > 0.0:
                # With a margin, it is watched.
                ranges.append(found)
                reason = "never meet (proved)"
            elif found is not None:
                ranges.append(found)
                pairs.append(Pair(a.name, b.name, True, f"watched, by the range of {arm.joint_names[found.joint]}"))
                continue
            pairs.append(Pair(a.name, b.name, not reason, reason or "watched"))
    return pairs, ranges


def _said_of(arm: ChainKinematics, drawing: Drawing | None, srdf: str | Path) -> Disabled:
    said, label = disabled(srdf), "the SRDF" if is_xml(str(srdf)) else str(srdf)
    if not said.names:
        raise InvalidRobot(f"{label} disables no pair of links: is it an SRDF?", label)
    links = {frame.name for frame in arm.model.frames}.union(*read_tree(drawing))
    if said.names.isdisjoint(links):
        raise InvalidRobot(f"{label} is of another robot: {arm.name} has none of {listed(sorted(said.names))}", label)
    return said


def with_overrides(
    pairs: Iterable[Pair], keep: Iterable[tuple[str, str]], drop: Iterable[tuple[str, str]]
) -> list[Pair]:
    """The pairs, some of them watched or not as their caller says."""
    kept, dropped = {frozenset(p) for p in keep}, {frozenset(p) for p in drop}
    out = []
    for pair in pairs:
        names = frozenset((pair.first, pair.second))
        if names in kept and pair.reason != "on one joint":
            pair = Pair(pair.first, pair.second, True, "watched, as asked for")
        elif names in dropped:
            pair = Pair(pair.first, pair.second, False, "dropped, as asked for")
        out.append(pair)
    return out


def _neighbours(arm: ChainKinematics, bodies: Sequence[Body], drawing: Drawing | None) -> set[frozenset[str]]:
    """Names of bodies that one of the joints connects, links without shapes between them left out."""
    joint_of = {frame.name: frame.parentJoint for frame in arm.model.frames if frame.name}
    shaped = {body.name for body in bodies}
    carrier: dict[str, str] = {child: parent for parent, child in read_tree(drawing)}
    found = set()
    for body in bodies:
        link, crossed = body.name, 0
        while link in carrier:
            parent = carrier[link]
            crossed += joint_of.get(parent) != joint_of.get(link)
            link = parent
            if link in shaped:
                if crossed:
                    found.add(frozenset((body.name, link)))
                break
    return found
