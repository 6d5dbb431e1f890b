"""Groups of a MoveIt SRDF file: which frames they go from and to; and the pairs of links that it disables."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from srs_ik.errors import InvalidRobot, did_you_mean, listed
from srs_ik.robot.description import document
from srs_ik.robot.description.files import read
from srs_ik.robot.description.model import is_xml

if TYPE_CHECKING:
    from srs_ik.robot.skeleton import Skeleton

_KEPT: Mapping[str, frozenset[str]] = {"robot": frozenset({"group"}), "group": frozenset({"chain", "joint", "link"})}

_JOINTS = 7

_PAIRS: Mapping[str, frozenset[str]] = {
    "robot": frozenset({"disable_collisions", "disable_default_collisions", "enable_collisions"})
}


class Group(NamedTuple):
    """A planning group that may be an arm: by the ends of its chain, or by its parts."""

    ends: tuple[str, str] | None
    """Base and tip frame."""
    parts: frozenset[str] = frozenset()
    """Names of its joints, or of the links that these carry."""


def groups(source: str | Path) -> dict[str, Group]:
    """Every group of an SRDF file, by path or text, that is one chain, or that lists at least seven joints or links.

    Raises:
        InvalidRobot: the file is missing or no SRDF.
    """
    text, label = _text(source)
    found = {}
    for group in document.parse(text, label, _KEPT).findall("group"):
        name, inside = group.get("name"), group.findall("chain")
        parts = frozenset(part.get("name", "") for kind in ("joint", "link") for part in group.findall(kind))
        # A group of two chains is two arms.
        if not name or len(inside) > 1 or not (inside or len(parts) >= _JOINTS):
            continue
        if not inside:
            found[name] = Group(None, parts)
            continue
        base, tip = inside[0].get("base_link"), inside[0].get("tip_link")
        if not base or not tip:
            raise InvalidRobot(f"{label}: the chain of group {name!r} lacks base_link or tip_link", label)
        found[name] = Group((base, tip))
    return found


class Disabled(NamedTuple):
    """Which pairs of links an SRDF file says need not be watched for collisions."""

    pairs: Mapping[frozenset[str], str]
    """Those, and why."""
    links: frozenset[str]
    """Links whose pairs need not ..."""
    enabled: frozenset[frozenset[str]]
    """... but for these pairs."""

    @property
    def names(self) -> frozenset[str]:
        """The links that it speaks of."""
        return self.links.union(*self.pairs, *self.enabled)

    def reason(self, pair: frozenset[str]) -> str:
        """Why a pair need not be watched; empty where it has to be."""
        if pair in self.pairs:
            return self.pairs[pair]
        return "disabled by default" if self.links & pair and pair not in self.enabled else ""


def disabled(source: str | Path) -> Disabled:
    """What an SRDF file, by path or text, disables.

    Raises:
        InvalidRobot: the file is missing or no SRDF.
    """
    text, label = _text(source)
    said = document.parse(text, label, _PAIRS)

    def pairs(kind: str) -> dict[frozenset[str], str]:
        return {
            frozenset((each.get("link1", ""), each.get("link2", ""))): each.get("reason", "disabled")
            for each in said.findall(kind)
        }

    links = frozenset(each.get("link", "") for each in said.findall("disable_default_collisions"))
    return Disabled(pairs("disable_collisions"), links, frozenset(pairs("enable_collisions")))


def _text(source: str | Path) -> tuple[str | bytes, str]:
    """An SRDF file, or the text of one, and how messages call it."""
    if isinstance(source, str) and is_xml(source):
        return source, "the SRDF text"
    return read(Path(source), str(source)), str(source)


def chain_of(source: str | Path, group: str | None, skeleton: Skeleton) -> tuple[str, str]:
    """Base and tip frame of one group, of the only one where none is named.

    Raises:
        InvalidRobot: the file is missing or no SRDF, has no such group, or several and none is named, or what the group
            lists is not in one line in the robot.
    """
    found = groups(source)
    names = list(found)
    label = "the SRDF" if isinstance(source, str) and is_xml(source) else str(source)
    if not names:
        raise InvalidRobot(f"{label} has no group of one chain or of seven joints; name base and tip instead", label)
    if group is None:
        if len(names) > 1:
            raise InvalidRobot(f"{label} has several groups, name one of them as the limb: {listed(names)}", label)
        group = names[0]
    if group not in found:
        hint = did_you_mean(group, names)
        raise InvalidRobot(f"{label} has no chain {group!r}{hint}; its chains are {listed(names)}", label)
    ends, parts = found[group]
    ends = ends or skeleton.ends_of(parts)
    if ends is None:
        raise InvalidRobot(f"{label}: what group {group!r} lists is not in one line in the robot", label)
    return ends
