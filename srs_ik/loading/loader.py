"""`load` and `find_limbs`: the way from a robot to its arms."""

from __future__ import annotations

import warnings
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from srs_ik.errors import AmbiguousLimb, FrameNotFound, InvalidRobot, InvalidTask, NotAnSrsLimb, listed, quoted
from srs_ik.inputs.numbers import real_array
from srs_ik.robot import changes
from srs_ik.robot.arguments import check_path, check_texts
from srs_ik.robot.candidates import Candidate, LimbReport, examine, explained, weigh, with_oddities_noted
from srs_ik.robot.card import Placement
from srs_ik.robot.chain import Chain, build_chain, refuse_followers
from srs_ik.robot.description.srdf import chain_of, disabled
from srs_ik.robot.limb import Hand, SrsLimb, Vector
from srs_ik.robot.locked import as_locked, configuration_of, with_followers
from srs_ik.robot.oddities import odd_limits, odd_size, out_of_range, still_beyond, tied_between
from srs_ik.robot.recognition import default_reference, recognise
from srs_ik.robot.sides import is_meant
from srs_ik.robot.skeleton import Skeleton
from srs_ik.robot.sources import Description, describe
from srs_ik.system.forks import whole

if TYPE_CHECKING:
    from srs_ik.arm import Arm

_ELSEWHERE = "; other arms are for packages such as ssik, or Pinocchio with Pink (docs/peers.md)"
"""Follows where a robot has no limb at all."""


@whole
def load(
    source: Any,
    base: str | None = None,
    tip: str | None = None,
    *,
    name: str | None = None,
    reference: Any = None,
    hand: Any = None,
    limb: str | None = None,
    limits: Mapping[str, Mapping[str, float]] | None = None,
    locked: Mapping[str, float] | None = None,
    urdf: Any = None,
    srdf: str | Path | None = None,
    xacro_args: Mapping[str, str] | None = None,
    allow_xacro: bool = False,
) -> Arm:
    """Load an S-R-S arm.

    Seven consecutive revolute joints are taken, every other joint of the robot is locked, at zero if not said. With
    `base` and `tip` they are sought on the way between them, with `tip` alone on the way to it from the root of the
    robot, with `base` alone in what hangs on it, without either in the whole robot.

    Args:
        source: a name (see `robots`; a name of robot_descriptions), the path of a URDF, xacro or MJCF file or of an
            adapter (``robot.toml``), an address (``package://NAME/FILE``, ``example-robot-data://FILE``), URDF text, a
            ``pinocchio.Model``, or a ``yourdfpy.URDF``. It is not changed; meshes are not needed.
        base: name of the base frame, any frame that the arm does not move; by default the link that carries joint 1.
        tip: name of the tip frame, anything that joint 7 moves; by default the outermost link fixed to it, up to where
            links fork or move.
        name: name of the arm; by default the name under which it was loaded, or that of the robot.
        reference: (3,) direction in the base frame towards which the elbow lies at arm angle zero, of any length; by
            default that of the built-in robot, or axis 1.
        hand: (2, 3) grasp direction and pronosupination direction in the tip frame, of any length, not parallel; the
            second is taken perpendicular to the first. By default those of the built-in robot.
        limb: which of several limbs: "left", "right", or a part of one of its names; with `srdf`, a group.
        limits: limits that are not as described: for each joint in question those of "lower", "upper" (rad), "velocity"
            (rad/s), "effort" (N m) and "acceleration" (rad/s^2) that change; infinite for none. Those for other joints
            of the robot are left out. Trackers, and paths of the least time, keep the accelerations.
        locked: where other joints of the robot stand, rad or m, such as ``{"lift": 0.3}``; those that are not named are
            at zero. They count where they lie between base and tip.
        urdf: the description of a robot with a name or an adapter, where it is not at one of their places.
        srdf: path or text of a MoveIt SRDF file; base and tip are those of one of its groups, and are not given then.
            Pairs of links that it disables are not watched for collisions.
        xacro_args: arguments of a xacro file. Such a file is a program, with what the user may do: load those that you
            trust.
        allow_xacro: whether to run a xacro file that an adapter names. One that you name yourself is run in any case.

    Returns:
        The arm.

    Raises:
        InvalidRobot: the description is missing or faulty, `limits`, `locked`, `srdf` or `xacro_args` do not fit it, or
            an argument is of the wrong kind.
        FrameNotFound: the robot has no frame `base` or `tip`.
        NotAnSrsLimb: there are no seven such joints, or their axes miss common points by too much.
        AmbiguousLimb: several arms fit.
        MissingExtra: `source` needs a package that is not installed.
        InvalidTask: `reference` or `hand` is no direction.
    """
    from srs_ik.arm import Arm

    check_texts(base=base, tip=tip, name=name, limb=limb)
    if srdf is not None:
        check_path("srdf", srdf)
        if base is not None or tip is not None:
            raise InvalidRobot("srdf names a chain, with its base and tip: it goes with neither base nor tip")
    asked_reference = None if reference is None else _direction(reference, "reference")
    asked_hand = None if hand is None else _hand(hand)
    told = describe(source, urdf, xacro_args, allow_xacro)
    description = _standing(told, locked)
    if srdf is not None:
        base, tip = chain_of(srdf, limb, _skeleton(description))
        limb = None
    joints, base, tip = _choose(description, base, tip, limb)
    chain = build_chain(description.robot.model, joints, base, tip, description.locked)
    refuse_followers(told.robot, chain, {*told.locked, *(locked or ())})
    described = chain
    for changed in (description.limits, limits):
        others = set(description.robot.model.names) - set(chain.joint_names)
        chain = changes.within_limits(chain, changed, others) if changed is not None else chain
    reference = asked_reference if asked_reference is not None else _meant_reference(description, chain)
    axes = asked_hand if asked_hand is not None else _meant_hand(description, chain)
    chain, reference, axes = _furnished(description, chain, reference, axes)
    recognised = _recognised(description, chain, reference, f"{base} -> {tip}")
    given = [
        name for each in (description.limits, limits or {}) for name in each if {"lower", "upper"} & each[name].keys()
    ]
    _warn_of_oddities(description, described, recognised, given)
    hand_axes = None if axes is None else Hand(*(tuple(axis.tolist()) for axis in axes))
    arm = Arm(chain, recognised, name or description.name, hand=hand_axes, drawing=description.robot.drawing)
    # A file of groups alone says nothing of collisions.
    return arm.with_bodies(srdf=srdf) if srdf is not None and disabled(srdf).names else arm


def _furnished(
    description: Description, chain: Chain, reference: Vector, hand: Vector | None
) -> tuple[Chain, Vector, Vector | None]:
    """A chain with the tool and the mount of its description; reference and hand are turned along."""
    tool, mount = description.tool, description.mount
    base, tip = chain.base, chain.tip
    if tool is not None and tip == description.tip:
        T_tip_tool = _matrix(tool)
        chain = changes.with_tool(chain, T_tip_tool, tool.name)
        hand = None if hand is None else hand @ T_tip_tool[:3, :3]
    if mount is not None and base == description.base:
        T_mount_base = _matrix(mount)
        gravity = None if mount.gravity is None else np.array(mount.gravity)
        chain = changes.on_base(chain, T_mount_base, mount.name, gravity)
        reference = T_mount_base[:3, :3] @ reference
    return chain, reference, hand


def _recognised(description: Description, chain: Chain, reference: Vector, where: str) -> SrsLimb:
    """The limb of a chain; raises NotAnSrsLimb, naming where it was looked for, if it is none."""
    found = recognise(chain.axes, chain.points, chain.T_base_tip_zero, reference)
    if found.limb is None:
        misses_mm, allowed_mm = 1e3 * found.misses, 1e3 * found.allowed
        clause = explained(found.reason, chain.joint_names, misses_mm, allowed_mm)
        message = f"{description.robot.source}: {where} is no S-R-S limb: {clause}"
        raise NotAnSrsLimb(message, chain.joint_names, misses_mm.tolist(), allowed_mm)
    return found.limb


@whole
def find_limbs(
    source: Any,
    xacro_args: Mapping[str, str] | None = None,
    allow_xacro: bool = False,
    locked: Mapping[str, float] | None = None,
) -> list[LimbReport]:
    """Every chain of seven consecutive revolute joints in a robot, classified and measured.

    S-R-S limbs come first, then chains that are none. Of chains that share joints only the best is reported: see `note`
    of the report. What shares joints with a limb and is none is left out.

    Args:
        source: as for `load`.
        xacro_args: arguments of a xacro file.
        allow_xacro: as for `load`.
        locked: as for `load`.

    Raises:
        InvalidRobot: the description is missing or faulty, or `locked` does not fit it.
        MissingExtra: `source` needs a package that is not installed.
    """
    description = _standing(describe(source, xacro_args=xacro_args, allow_xacro=allow_xacro), locked)
    skeleton = _skeleton(description)
    candidates = [examine(description, skeleton, joints) for joints in skeleton.windows(_kept_out(description))]
    return [with_oddities_noted(description, skeleton, candidate) for candidate in weigh(candidates, skeleton)]


def _warn_of_oddities(description: Description, chain: Chain, limb: SrsLimb, given: Collection[str]) -> None:
    """Warn of what is odd in a description, but for the limits of joints for which others are given."""
    ranges = zip(chain.joint_names, chain.lower.tolist(), chain.upper.tolist(), strict=True)
    limits = {name: (lower, upper) for name, lower, upper in ranges if name not in given}
    model, locked = description.robot.model, description.locked
    elsewhere = [
        *out_of_range(model, chain.between, locked),
        *tied_between(chain.between, description.robot.ties, locked),
        *still_beyond(model, chain.joint_names[-1], chain.between, chain.tip, locked),
    ]
    for clause in (*odd_limits(limits), *odd_size(limb), *elsewhere):
        warnings.warn(f"{description.robot.source}: {clause}", UserWarning, stacklevel=4)


def _standing(description: Description, locked: Any) -> Description:
    """The description with other joints locked where somebody says, or where they follow those."""
    robot, given = description.robot, description.locked
    if locked is not None:
        together = {**given, **locked} if isinstance(locked, Mapping) else locked
        given = as_locked(together, robot.model, robot.followers)
    return replace(description, locked=with_followers(robot.model, given, robot.followers))


def _skeleton(description: Description) -> Skeleton:
    return Skeleton(description.robot.model, configuration_of(description.robot.model, description.locked))


def _kept_out(description: Description) -> dict[str, str]:
    """Joints that are none of a limb, each with a clause that says why."""
    return {**dict.fromkeys(description.locked, "is locked"), **description.robot.mimic_joints}


def _choose(
    description: Description, base: str | None, tip: str | None, limb: str | None
) -> tuple[tuple[int, ...], str, str]:
    """Joints and frames of the one limb that fits."""
    skeleton = _skeleton(description)
    base, tip = base or description.base, tip or description.tip
    for frame in (base, tip):
        if frame is not None and not skeleton.has_frame(frame):
            source = description.robot.source
            raise FrameNotFound(frame, skeleton.frame_names(), robot=description.robot.name, source=source)
    every = skeleton.windows(_kept_out(description))
    fitting = [joints for joints in every if _fits(skeleton, joints, base, tip)]
    if not fitting and base is not None and tip is None:
        movers = skeleton.path(skeleton.joint_of(base))
        fitting = [joints for joints in every if set(joints).isdisjoint(movers)]
    if not fitting:
        raise _no_chain(description, skeleton, base, tip)
    candidates = weigh([examine(description, skeleton, joints, base, tip) for joints in fitting], skeleton)
    limbs = [candidate for candidate in candidates if candidate.report.limb is not None]
    if not limbs:
        raise _refused(description, candidates)
    if limb is not None:
        limbs = _meant(description, limbs, limb)
    if len(limbs) > 1:
        raise _ambiguous(skeleton, description, limbs)
    return limbs[0].joints, limbs[0].report.base, limbs[0].report.tip


def _meant(description: Description, limbs: Sequence[Candidate], word: str) -> list[Candidate]:
    """The limbs that a word means."""
    found = [limb for limb in limbs if is_meant(word, limb.report.names)]
    if not found:
        tips = listed([candidate.report.tip for candidate in limbs])
        none = f"{description.robot.source}: no arm of {description.name!r} has {quoted(word)} in its names"
        raise NotAnSrsLimb(f"{none}; the arms end at {tips}{_locked_clause(description)}")
    return found


def _locked_clause(description: Description) -> str:
    return f"; {listed(list(description.locked))} cannot be of it, as locked" if description.locked else ""


def _fits(skeleton: Skeleton, joints: Sequence[int], base: str | None, tip: str | None) -> bool:
    if tip is not None:
        return set(joints) <= set(_way(skeleton, base, tip))
    return base is None or skeleton.carries(base, joints[0])


def _way(skeleton: Skeleton, base: str | None, tip: str) -> list[int]:
    return skeleton.path(skeleton.joint_of(tip)) if base is None else skeleton.joints_between(base, tip)


def _no_chain(description: Description, skeleton: Skeleton, base: str | None, tip: str | None) -> NotAnSrsLimb:
    """The error for a robot or a way through it that has no seven consecutive revolute joints."""
    mimic, source = _kept_out(description), description.robot.source
    if tip is None:
        where = f"{description.name!r}" if base is None else f"what hangs on {base!r}"
        run = skeleton.longest_run(mimic) if base is None else ()
        names = [skeleton.joint_names[joint] for joint in run]
        longest = f"; the longest has {len(run)}: {listed(names)}{_interrupted(skeleton, mimic, run)}" if run else ""
        locked = _locked_clause(description)
        none = f"{source}: {where} has no chain of 7 consecutive revolute joints"
        return NotAnSrsLimb(f"{none}{longest}{locked}{'' if base or locked else _ELSEWHERE}", names)
    joints = _way(skeleton, base, tip)
    names = [skeleton.joint_names[joint] for joint in joints]
    where = f"between base {base!r} and tip {tip!r}" if base is not None else f"on the way to the tip {tip!r}"
    moving = [name for name in names if name not in description.locked]
    found = f"{len(moving) or 'no'} moving joint{'s' if len(moving) > 1 else ''}"
    message = f"{where} there are no 7 consecutive revolute joints, but {found}"
    others = [
        f"{name} {mimic.get(name) or skeleton.what_is(joint)}"
        for name, joint in zip(names, joints, strict=True)
        if name in mimic or not skeleton.is_revolute(joint)
    ]
    if names:
        message += (f": {listed(moving)}" if moving else "") + (f" ({', '.join(others)})" if others else "")
    own = [name for name in names if name in description.locked]
    if own and any(all(skeleton.is_revolute(k) for k in joints[i : i + 7]) for i in range(len(joints) - 6)):
        message += f"; to hold {own[0]!r} of seven joints, load all seven and give it limits: Arm.with_limits"
    if base is not None and len(skeleton.joints_between(tip, base)) >= 7:
        message += "; base and tip are perhaps swapped"
    return NotAnSrsLimb(f"{source}: {message}", names)


def _interrupted(skeleton: Skeleton, mimic: Mapping[str, str], run: Sequence[int]) -> str:
    """What keeps revolute joints in a row from going on, at either end, as a clause; empty if the robot ends there."""
    before, after = skeleton.path(run[0])[-2:-1], skeleton.hanging_on(run[-1])
    said = ""
    # Several after them are a hand.
    for joint, where in [*((k, "before") for k in before), *((k, "after") for k in after if len(after) == 1)]:
        name = skeleton.joint_names[joint]
        said += f"; {listed([name])} {where} them {mimic.get(name) or skeleton.what_is(joint)}"
    return said


def _refused(description: Description, candidates: Sequence[Candidate]) -> NotAnSrsLimb:
    """The error for chains that are all no limbs; it speaks of the one that is nearest to being one."""
    # Rounded: of mirrored arms with the same misses but for noise, the first.
    worst = [np.nan_to_num(candidate.report.misses_mm, nan=np.inf).max().round(3) for candidate in candidates]
    report = candidates[int(np.argmin(worst))].report
    message = report.describe().removesuffix(".")
    if len(candidates) > 1:
        message = (
            f"none of {len(candidates)} chains of 7 revolute joints is an S-R-S limb; nearest to one is "
            f"{report.base} -> {report.tip}: {report.explain()}"
        )
    message = f"{description.robot.source}: {message}{_ELSEWHERE}"
    return NotAnSrsLimb(message, report.joint_names, report.misses_mm.tolist(), report.allowed_mm)


def _ambiguous(skeleton: Skeleton, description: Description, limbs: Sequence[Candidate]) -> AmbiguousLimb:
    ends = [(skeleton.default_base(limb.joints[0]), skeleton.default_tip(limb.joints[-1])) for limb in limbs]
    choices = ", ".join(f"base={base!r} tip={tip!r}" for base, tip in ends)
    sides = {limb.report.side for limb in limbs}
    how = "its base and tip, or by limb='left' or limb='right'" if sides == {"left", "right"} else "its base and tip"
    fit = f"{len(ends)} arms of {description.name!r} fit"
    return AmbiguousLimb(f"{description.robot.source}: {fit}, choose one by {how}: {choices}", ends)


def _meant_reference(description: Description, chain: Chain) -> Vector:
    """The reference of the description, turned from its own base frame into that of the chain, or the default one."""
    if description.reference is None:
        return default_reference(chain.axes[0])
    if description.base is None or chain.base == description.base:
        return description.reference
    return Skeleton(chain.model).transform(chain.base, description.base)[:3, :3] @ description.reference


def _meant_hand(description: Description, chain: Chain) -> Vector | None:
    """The hand of the description, turned from its own tip frame into that of the chain; None if apart from it."""
    if description.hand is None or description.tip is None or chain.tip == description.tip:
        return description.hand
    skeleton = Skeleton(chain.model)
    if skeleton.joint_of(description.tip) != 7:
        return None
    return description.hand @ skeleton.transform(chain.tip, description.tip)[:3, :3].T


def _matrix(placement: Placement) -> Vector:
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = pin.rpy.rpyToMatrix(*placement.rpy), placement.xyz
    return T


def _direction(value: Any, what: str) -> Vector:
    try:
        vector = real_array(value)
    except (TypeError, ValueError, OverflowError):
        raise InvalidTask(f"{what} is not an array of 3 numbers") from None
    if vector.shape != (3,):
        raise InvalidTask(f"{what} has the shape {vector.shape}, not (3,)")
    largest = float(np.abs(vector).max())
    if not (np.isfinite(largest) and largest > 1e-9):
        raise InvalidTask(f"{what} is {vector.tolist()}, which has no direction")
    # Squares of large figures would pass what a float can hold.
    vector /= largest
    return vector / np.linalg.norm(vector)


def _hand(value: Any) -> Vector:
    try:
        grasp, pronosupination = value
    except (TypeError, ValueError):
        raise InvalidTask("hand is not a pair of directions, grasp and pronosupination") from None
    g, phi = _direction(grasp, "grasp direction of hand"), _direction(pronosupination, "pronosupination of hand")
    across = phi - g * (g @ phi)
    if np.linalg.norm(across) < 1e-6:
        raise InvalidTask("grasp and pronosupination direction of hand are parallel")
    return np.array([g, across / np.linalg.norm(across)])
