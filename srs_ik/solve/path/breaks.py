"""Why a path breaks: where strips end, and between which poses a break cannot be avoided."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from srs_ik.kernels.layout.path import BY_CONTINUITY
from srs_ik.solve.path.problem import JUST_ABOVE, Problem, Wall, Way
from srs_ik.solve.path.search.blocks import find_way
from srs_ik.solve.pose import solve
from srs_ik.solve.solutions import BatchSolution
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.solve.packed import PackedArm

LOOKED_AT = 24
"""So many postures before a wall are asked at most what stops them."""

FAR = 0.1
"""Poses that are farther apart, m, are waypoints rather than a path."""


@dataclass(frozen=True, slots=True)
class PathBreak:
    """A place where a path is not continuous, or not on its pose.

    Attributes:
        sample: index of the pose at which it happens.
        jump: largest joint step from the sample before, rad; 0 at a pose that is not reached.
        joint: name of the joint that makes it.
        message: one sentence that says why, and a second one that says where a break cannot be avoided.
        earliest: first pose at which this break may happen in a path with so few breaks; None where not known.
        latest: last pose at which it may happen: beyond the pose before, nothing goes on.
        bodies: the two that are in the way, where they are the reason.
    """

    sample: int
    jump: float
    joint: str
    message: str
    earliest: int | None = None
    latest: int | None = None
    bodies: tuple[str, str] | None = None


def breaks_of(problem: Problem, way: Way | None, rows: Array, steps: Array) -> list[PathBreak]:
    """The breaks of a path, from the rows of its postures and its joint steps.

    Without a way, by which strips tell what cannot be, no more is said than that no other path was found.
    """
    arm = problem.arm
    longest = problem.settings[BY_CONTINUITY]
    hits = {} if problem.around is None else problem.around.hits_of(problem.T, rows)
    answers = BatchSolution(rows, arm.joint_names, arm.elbow, hits)
    jumps = np.append(False, (np.abs(steps) > JUST_ABOVE * longest).any(axis=1))
    # The move over poses that are not reached is no break of its own.
    after_gap = np.append(False, ~answers.ok[:-1])
    inner = np.flatnonzero(jumps & answers.ok & ~after_gap).tolist()
    windows = [] if way is None else _windows(problem, way, len(inner))
    none = "No path was found that goes on" if way is None else "No posture inside the limits continues the path"
    breaks = []
    for i in sorted([*inner, *np.flatnonzero(~answers.ok).tolist()]):
        if not answers.ok[i]:
            bodies = (hits[(i,)].first, hits[(i,)].second) if (i,) in hits else None
            why = f"Pose {i} is not reached: {answers.message(i)}"
            breaks.append(PathBreak(i, 0.0, "", why, bodies=bodies))
            continue
        joint = int(np.abs(steps[i - 1]).argmax())
        jump, name = float(abs(steps[i - 1, joint])), arm.joint_names[joint]
        message = f"{none} at pose {i}: joint {name} has to jump {jump:.3f} rad."
        earliest = latest = None
        if i in inner and windows:
            earliest, latest, why = windows[inner.index(i)]
            where = f"between poses {earliest - 1} and {latest}" if earliest < latest else f"before pose {latest}"
            message += f" A break {where} cannot be avoided: at pose {latest}, {why}."
        message += _far_apart(problem, i, float(longest[joint]))
        breaks.append(PathBreak(i, jump, name, message, earliest, latest))
    return breaks


def _far_apart(problem: Problem, i: int, longest: float) -> str:
    """That two poses in a row are far apart for the steps of a path, as a sentence; empty where they are not."""
    before, here = problem.T[i - 1], problem.T[i]
    distance = float(np.linalg.norm(here[:3, 3] - before[:3, 3]))
    turn = float(np.linalg.norm(pin.log3(before[:3, :3].T @ here[:3, :3])))
    if distance < FAR and turn < longest:
        return ""
    apart = f"Poses {i - 1} and {i} are {distance:.2f} m and {turn:.2f} rad apart"
    return f" {apart}, and a joint step above longest_step, {longest:g} rad, is a break: poses between may help."


def _windows(problem: Problem, way: Way, count: int) -> list[tuple[int, int, str]]:
    """First and last pose of each break, and what stops the path there; empty where these cannot be told apart."""
    walls = way.walls
    if count == 0 or len(walls) != count:
        return []
    n = len(problem.T)
    T, known, has_known = problem.T[::-1], problem.known[::-1], problem.has_known[::-1]
    strips = problem.reordered(np.arange(n)[::-1])
    if problem.seed is not None:
        # Backwards, the seed is one more pose at the end, with one posture.
        T = np.concatenate([T, T[-1:]])
        known, has_known = np.vstack([known, problem.seed]), np.append(has_known, True)
        if strips["free"] is not None:
            strips["free"].append(np.empty((0, 3)))
        if strips["held_alone"] is not None:
            strips["held_alone"] = np.append(strips["held_alone"], True)
    told = {"known": known.copy(), "has_known": has_known.copy(), "near": known.copy(), **strips}
    back = replace(problem, T=np.ascontiguousarray(T), seed=None, **told)
    backwards = find_way(back, np.arange(len(T)), False).walls
    if len(backwards) != count:
        return []
    firsts = [n - wall.sample for wall in reversed(backwards)]
    return [
        (max(1, min(first, wall.sample)), wall.sample, _reason(problem, wall))
        for first, wall in zip(firsts, walls, strict=True)
    ]


def _reason(problem: Problem, wall: Wall) -> str:
    """What stops the postures before a wall: a joint's limit, a step that is too long, or the reach."""
    arm = problem.arm
    chosen = wall.before[np.linspace(0, len(wall.before) - 1, min(len(wall.before), LOOKED_AT)).astype(int)]
    pose = problem.T[wall.sample]
    if problem.around is not None:
        hit = problem.around.in_the_way(pose, chosen, float(problem.settings[BY_CONTINUITY, 0]))
        if hit is not None:
            return f"{hit.first} would meet {hit.second}"
    longest = JUST_ABOVE * problem.settings[BY_CONTINUITY]
    anywhere = _nearest(arm, pose, chosen, False)
    if not anywhere:
        return "no posture reaches the pose"
    # A limit stops a posture that could go on without it; the others would have to leap all the same.
    near = [
        (float(np.maximum(arm.lower - q, q - arm.upper).max()), q) for step, q in anywhere if (step <= longest).all()
    ]
    beyond, q = min(near, key=lambda each: each[0], default=(0.0, chosen[0]))
    if beyond > 0.0:
        joint = int(np.maximum(arm.lower - q, q - arm.upper).argmax())
        side = "lower" if q[joint] < arm.lower[joint] else "upper"
        return f"joint {arm.joint_names[joint]} would have to pass its {side} limit by {beyond:.3f} rad"
    step = min((step for step, _ in _nearest(arm, pose, chosen, True) or anywhere), key=lambda step: float(step.max()))
    return f"joint {arm.joint_names[int(step.argmax())]} would have to move by {step.max():.3f} rad in one step"


def _nearest(arm: PackedArm, pose: Array, postures: Array, respect_limits: bool) -> list[tuple[Array, Array]]:
    """Joint steps (7,) from postures to the nearest ones that meet a pose, and these."""
    found = [(solve(arm, pose, seed=q, respect_limits=respect_limits), q) for q in postures]
    return [(np.abs(each.q - q), each.q) for each, q in found if each]
