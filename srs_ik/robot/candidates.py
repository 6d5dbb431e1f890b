"""Which chains of a robot are limbs: every run of seven revolute joints, recognised, measured and weighed."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np

from srs_ik.robot.limb import EXACT_MISS, SrsLimb, Vector, WristKind
from srs_ik.robot.oddities import odd_limits, odd_size, out_of_range
from srs_ik.robot.recognition import recognise
from srs_ik.robot.sides import Side, side_of
from srs_ik.robot.skeleton import Skeleton
from srs_ik.robot.sources import Description

_NOT_SHOWN_MM = 1e-3
"""Misses below a micrometre are rounding of a file's figures, not worth a line of a message."""

_SHORTEST_ARM = 4
"""Joints before a fork that are rather an arm with a hand to come than a trunk with arms to come."""


@dataclass(frozen=True, eq=False)
class LimbReport:
    """One chain of seven consecutive revolute joints, and what it is.

    Attributes:
        base: name of the base frame: the link that carries joint 1, unless the robot is known to be meant otherwise.
        tip: name of the tip frame: the outermost link fixed to joint 7 before a fork or a moving joint, or as above.
        joint_names: the seven names, from the base outwards.
        kind: "exact", "near", or "refused".
        misses_mm: (7,) distance of each axis from the shoulder centre (1 to 3) or wrist centre (5 to 7), millimetres;
            NaN where it was refused before there was a centre to measure from.
        allowed_mm: largest miss that is accepted, millimetres; NaN as above.
        elbow_offset: larger distance of the elbow centre from axes 3 and 5 where these run along the arm, metres; NaN
            as above.
        wrist_kind: "XYX" or "XYZ"; None if refused.
        limb: the limb between `base` and `tip`; None if refused.
        reason: one clause that says why it is refused, with axes numbered from 1; empty otherwise.
        locked: names of the other moving joints between the root of the robot and the tip, from the root outwards; an
            arm has them fixed.
        locked_at: where those are that are not fixed at their neutral position, rad or m.
        carried_by: those of `locked` that are not between base and tip: poses do not depend on where they stand.
        frames: names of other frames that joint 7 carries, links and MJCF sites, each of which may be the tip.
        note: which chains that share joints with it were set aside in its favour or, if refused, where it forks on its
            way, as an arm of six joints does with the fingers of its gripper; which limits look like degrees, or let a
            joint not move; which joints are locked where they cannot be; that
            lengths look like millimetres; empty if there is nothing to say.
    """

    base: str
    tip: str
    joint_names: tuple[str, ...]
    kind: Literal["exact", "near", "refused"]
    misses_mm: Vector
    allowed_mm: float
    elbow_offset: float
    wrist_kind: WristKind | None
    limb: SrsLimb | None
    reason: str
    locked: tuple[str, ...] = ()
    note: str = ""
    locked_at: Mapping[str, float] = field(default_factory=dict)
    frames: tuple[str, ...] = ()
    carried_by: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Every name by which it may be meant: base, tip and joints."""
        return (self.base, self.tip, *self.joint_names)

    @property
    def side(self) -> Side:
        """Either "left" or "right" where most of its names say so, else "either"."""
        return side_of(self.names)

    def describe(self) -> str:
        """One sentence for people: between which frames, what it is, and its lengths or what is wrong with it."""
        ends = f"{self.base} -> {self.tip}"
        if self.limb is None:
            return f"{ends} is no S-R-S limb: {self.explain()}."
        lengths = [f"upper arm {1e3 * self.limb.upper_arm:.1f} mm", f"forearm {1e3 * self.limb.forearm:.1f} mm"]
        if self.elbow_offset >= EXACT_MISS:
            lengths.append(f"elbow offset {1e3 * self.elbow_offset:.1f} mm")
        if self.kind == "near":
            lengths.append(f"axes miss their centres by up to {self.misses_mm.max():.3f} mm")
        article = "an exact" if self.kind == "exact" else "a near"
        locked = told_of_locked(self.locked, self.locked_at, self.carried_by)
        more = "".join(f"; {clause}" for clause in (*locked, *[self.note] * bool(self.note)))
        return f"{ends} is {article} S-R-S limb with {self.wrist_kind} wrist, {', '.join(lengths)}{more}."

    def explain(self) -> str:
        """The reason of a refusal with the joints' names and millimetres in it; empty if it is a limb."""
        clause = explained(self.reason, self.joint_names, self.misses_mm, self.allowed_mm)
        return f"{clause}; {self.note}" if self.limb is None and self.note else clause


@dataclass(frozen=True, eq=False)
class Candidate:
    """A report and the joints, as indices into the robot's model, that it is about."""

    joints: tuple[int, ...]
    report: LimbReport


def examine(
    description: Description,
    skeleton: Skeleton,
    joints: Sequence[int],
    base: str | None = None,
    tip: str | None = None,
) -> Candidate:
    """Recognise seven revolute joints of a robot, given by their indices from the base outwards.

    Where base or tip are not named, they are those of the description if the joints do not move the base, and joint 7
    is the last that moves the tip; else the link of joint 1, and the default tip.
    """
    base = base or _meant_base(description, skeleton, joints) or skeleton.default_base(joints[0])
    tip = tip or _meant_tip(description, skeleton, joints) or skeleton.default_tip(joints[-1])
    lines = skeleton.measure(joints, base, tip)
    reference = description.reference if base == description.base else None
    found = recognise(lines.axes, lines.points, lines.T_base_tip_zero, reference)
    locked = [k for k in skeleton.path(skeleton.joint_of(tip)) if k not in joints]
    between = skeleton.joints_between(base, tip)
    report = LimbReport(
        base=base,
        tip=tip,
        joint_names=tuple(skeleton.joint_names[joint] for joint in joints),
        kind=found.kind,
        misses_mm=1e3 * found.misses,
        allowed_mm=1e3 * found.allowed,
        elbow_offset=found.elbow_offset,
        wrist_kind=found.limb.wrist_kind if found.limb is not None else None,
        limb=found.limb,
        reason=found.reason,
        locked=tuple(skeleton.joint_names[k] for k in locked),
        note=_fork(skeleton, joints) if found.limb is None else "",
        locked_at={
            name: x for name in map(skeleton.joint_names.__getitem__, locked) if (x := description.locked.get(name))
        },
        frames=tuple(name for name in skeleton.frames_on(joints[-1]) if name != tip),
        carried_by=tuple(skeleton.joint_names[k] for k in locked if k not in between),
    )
    return Candidate(tuple(joints), report)


def weigh(candidates: Collection[Candidate], skeleton: Skeleton) -> list[Candidate]:
    """Of candidates that share joints keep the best: limbs without a joint in common, then others; in joint order.

    An exact limb goes before a near one, then the smaller miss, then the smaller elbow offset (three joints of a trunk
    and a shoulder can be a limb of their own, with the collar for an elbow), then the chain farther out. A refused
    chain that shares joints with a limb, reported or not (trunk and arm, arm and finger), says nothing and is left out;
    of refused chains along one way from the root to an end, the one stays that lies most like a limb, and then whose
    axes miss least.
    """
    accepted = [candidate for candidate in candidates if candidate.report.limb is not None]
    refused = [candidate for candidate in candidates if candidate.report.limb is None]
    limbs: list[Candidate] = []
    for candidate in sorted(accepted, key=_rank_of_limb):
        rivals = [k for k, limb in enumerate(limbs) if set(limb.joints) & set(candidate.joints)]
        if not rivals:
            limbs.append(candidate)
        for k in rivals:
            limbs[k] = _noted(limbs[k], candidate)
    used = {joint for candidate in accepted for joint in candidate.joints}
    chains: list[Candidate] = []
    for candidate in sorted(refused, key=lambda candidate: _rank_of_refused(skeleton, candidate)):
        if used.isdisjoint(candidate.joints) and not any(_in_line(skeleton, candidate, chain) for chain in chains):
            chains.append(candidate)
    return [*sorted(limbs, key=_place), *sorted(chains, key=_place)]


def with_oddities_noted(description: Description, skeleton: Skeleton, candidate: Candidate) -> LimbReport:
    """The report of a candidate, whose note says what of the description was probably meant otherwise."""
    names = {joint: skeleton.joint_names[joint] for joint in candidate.joints}
    limits = {name: skeleton.limits(joint) for joint, name in names.items() if name not in description.limits}
    report = candidate.report
    # Joints below the base carry the arm about, and do not change it.
    between = [skeleton.joint_names[k] for k in skeleton.joints_between(report.base, report.tip) if k not in names]
    said = [
        *odd_limits(limits),
        *odd_size(report.limb),
        *out_of_range(description.robot.model, between, description.locked),
    ]
    return replace(report, note="; ".join([report.note] * bool(report.note) + said))


def told_of_locked(locked: Sequence[str], positions: Mapping[str, float], carried_by: Collection[str]) -> list[str]:
    """Clauses on locked joints, each with where it is locked, unless that is its neutral position."""
    between = [name for name in locked if name not in carried_by]
    clauses = []
    for words, names in (
        ("locked between base and tip: ", between),
        ("carried by joints on which no pose depends: ", [name for name in locked if name in carried_by]),
    ):
        places = ", ".join(f"{name} at {positions[name]:g}" if positions.get(name) else name for name in names)
        clauses += [words + places] if names else []
    return clauses


def explained(reason: str, joint_names: Sequence[str], misses_mm: Vector, allowed_mm: float) -> str:
    """A reason of the recognition with the joints' names in it, every miss worth a word, and what is allowed."""

    def with_name(match: re.Match[str]) -> str:
        return f"{match[0]} ({joint_names[int(match[0]) - 1]})"

    clause = re.sub(r"(?<=axis )[1-7]\b|(?<=axes )[1-7]\b|(?<=and )[1-7]\b", with_name, reason)
    misses = [
        f"{name} {miss:.3f} mm" for name, miss in zip(joint_names, misses_mm, strict=True) if miss > _NOT_SHOWN_MM
    ]
    if not misses:
        return clause
    return f"{clause} (distance of each axis from its centre: {', '.join(misses)}; {allowed_mm:.1f} mm are allowed)"


def _fork(skeleton: Skeleton, joints: Sequence[int]) -> str:
    """Where a run of joints forks on its way, as a clause; empty if it does not."""
    for number, joint in enumerate(joints[:-1], 1):
        hanging = skeleton.hanging_on(joint)
        if len(hanging) > 1:
            part = "a hand" if number >= _SHORTEST_ARM else "an arm"
            where = f"axis {number} ({skeleton.joint_names[joint]})"
            return f"it forks after {where}, on which {len(hanging)} joints hang: {part} may begin there"
    return ""


def _meant_base(description: Description, skeleton: Skeleton, joints: Sequence[int]) -> str | None:
    if description.base is None:
        return None
    movers = skeleton.path(skeleton.joint_of(description.base))
    return description.base if set(movers).isdisjoint(joints) else None


def _meant_tip(description: Description, skeleton: Skeleton, joints: Sequence[int]) -> str | None:
    if description.tip is None:
        return None
    return description.tip if skeleton.joint_of(description.tip) == joints[-1] else None


def _rank_of_limb(candidate: Candidate) -> tuple[Any, ...]:
    report = candidate.report
    exact = report.kind == "exact"
    miss = 0.0 if exact else float(report.misses_mm.max())
    # Rounded, so that figures which are equal but for noise leave the decision to the next one.
    return (not exact, round(miss, 3), round(1e3 * report.elbow_offset, 3), -candidate.joints[-1])


def _rank_of_refused(skeleton: Skeleton, candidate: Candidate) -> tuple[Any, ...]:
    worst = float(np.max(candidate.report.misses_mm))
    miss = math.inf if math.isnan(worst) else round(worst, 3)
    return (skeleton.oddity(candidate.joints), miss, candidate.joints[-1])


def _place(candidate: Candidate) -> tuple[int, ...]:
    return candidate.joints


def _noted(kept: Candidate, other: Candidate) -> Candidate:
    report = kept.report
    chain = f"{other.report.base} -> {other.report.tip}"
    note = f"{report.note}, {chain}" if report.note else f"preferred to chains that share joints with it: {chain}"
    return Candidate(kept.joints, replace(report, note=note))


def _in_line(skeleton: Skeleton, one: Candidate, other: Candidate) -> bool:
    """True if both chains lie on one way from the root of the robot outwards, or share a joint."""
    a, b = one.joints[-1], other.joints[-1]
    return a in skeleton.path(b) or b in skeleton.path(a) or not set(one.joints).isdisjoint(other.joints)
