"""Free axes: poses that are met are met again, and no posture of a dense grid that SciPy polishes is nearer.

python benchmarks/free_axis.py [--count 1000] [--seed 0] [--robot iiwa14] [--grid 0]

A case is the pose of a random posture, a third of them with joints on their limits, turned by what is free: the roll
about a random axis, a cone of 1e-6 to 2 rad, or all. It is asked without a seed and with a random one. Of so many cases
as --grid says, the answer to the seed is compared with a grid of 48 turns (rolls, or turns of the cone) by 36 arm
angles whose six best dips SciPy polishes (SLSQP). Times are those of single calls.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence

import numpy as np
import pinocchio as pin
from scipy.optimize import minimize
from subjects import arms_of, finish, parser, say

import srs_ik
from srs_ik import FreeAxis

MET = 1e-9
"""An answer that misses its pose by more, m or rad, or its limits, rad, is none."""

FARTHER = 1e-6
"""An answer is farther than the grid's best by more than this, rad."""

CONES = (0.0, 0.0, 1e-6, 0.05, 0.3, 0.5, 1.0, 2.0, math.pi)
TURNS, ANGLES, DIPS, APART = 48, 36, 6, 0.4
"""The grid, and how many of its dips are polished, so far apart, rad."""


def case(arm: srs_ik.Arm, rng: np.random.Generator) -> tuple[FreeAxis, np.ndarray, np.ndarray]:
    """What is free, a pose that can be met, and a random seed."""
    axis = rng.normal(size=3) if rng.random() < 0.5 else np.eye(3)[rng.integers(3)]
    free = FreeAxis(axis, cone=rng.choice(CONES))
    lower, upper = np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi)
    q, seed = rng.uniform(lower, upper, (2, 7))
    if rng.random() < 1 / 3:
        ends = np.where(rng.random(7) < 0.5, arm.lower, arm.upper)
        q = np.where((rng.random(7) < 0.3) & np.isfinite(ends), ends, q)
    T = arm.forward_kinematics(q).homogeneous
    across = np.cross(free.axis, rng.normal(size=3))
    lean = 0.999 * free.cone * rng.random() ** 0.3 * across / np.linalg.norm(across)
    T[:3, :3] = T[:3, :3] @ pin.exp3(free.axis * rng.uniform(-np.pi, np.pi)) @ pin.exp3(lean)
    return free, T, seed


def off(arm: srs_ik.Arm, free: FreeAxis, T: np.ndarray, q: np.ndarray) -> float:
    """By how much a posture misses a pose, m or rad, or the limits, rad."""
    tip = arm.forward_kinematics(q)
    outside = max(0.0, (arm.lower - q).max(), (q - arm.upper).max())
    return max(float(np.linalg.norm(tip.translation - T[:3, 3])), free.lean(tip.rotation, T[:3, :3]), outside)


def on_grid(arm: srs_ik.Arm, free: FreeAxis, T: np.ndarray, seed: np.ndarray) -> np.ndarray:
    """(n, 7) postures of the grid inside the limits, nearest to the seed first, and apart."""
    turned = np.repeat(T[None], TURNS * ANGLES, axis=0)
    turned[:, :3, :3] = np.repeat(T[:3, :3] @ free.sampled(TURNS), ANGLES, axis=0)
    psis = np.tile(2.0 * np.pi * np.arange(ANGLES) / ANGLES, TURNS)
    found = arm.solve_batch(turned, arm_angle=psis, all_branches=True)
    q = found.q.reshape(-1, 7)[np.asarray(found.ok).ravel()]
    turns = 2.0 * np.pi * np.arange(-2, 3)[:, None, None]
    every = q + turns
    away = np.where((every < arm.lower - MET) | (every > arm.upper + MET), np.inf, abs(every - seed))
    q = np.take_along_axis(every, away.argmin(axis=0)[None], axis=0)[0]
    q = q[np.argsort(((q - seed) ** 2).sum(axis=1))][:400]
    dips: list[np.ndarray] = []
    for each in q:
        if len(dips) < DIPS and all(np.abs(each - dip).max() > APART for dip in dips):
            dips.append(each)
    return np.array(dips).reshape(-1, 7)


def polished(arm: srs_ik.Arm, free: FreeAxis, T: np.ndarray, seed: np.ndarray, q: np.ndarray) -> float:
    """How far the nearest posture around one is from the seed, rad, by SciPy; inf where it meets no pose."""
    ought = T[:3, :3] @ free.axis
    across = np.linalg.svd(ought[None])[2][1:] if free.cone == 0.0 else np.empty((0, 3))

    def missed(x: np.ndarray) -> np.ndarray:
        tip = arm.forward_kinematics(x)
        return np.r_[tip.translation - T[:3, 3], across @ tip.rotation @ free.axis]

    def room(x: np.ndarray) -> float:
        return float((arm.forward_kinematics(x).rotation @ free.axis) @ ought - math.cos(free.cone))

    limits = list(zip(np.maximum(arm.lower, -30.0), np.minimum(arm.upper, 30.0), strict=True))
    rules = [{"type": "eq", "fun": missed}, *([{"type": "ineq", "fun": room}] if free.cone > 0.0 else [])]
    best = minimize(
        lambda x: ((x - seed) ** 2).sum(),
        q,
        jac=lambda x: 2.0 * (x - seed),
        bounds=limits,
        constraints=rules,
        method="SLSQP",
        options={"ftol": 1e-13, "maxiter": 100},
    )
    return math.sqrt(best.fun) if off(arm, free, T, best.x) < MET else math.inf


def timed(arm: srs_ik.Arm, T: np.ndarray, free: FreeAxis, seed: np.ndarray | None) -> tuple[srs_ik.Solution, float]:
    """An answer, and the time of a call, s: the lesser of two."""
    times = []
    for _ in range(2):
        begin = time.perf_counter()
        solution = arm.solve(T, free_axis=free, seed=seed)
        times.append(time.perf_counter() - begin)
    return solution, min(times)


def compared(arm: srs_ik.Arm, free: FreeAxis, T: np.ndarray, seed: np.ndarray, q: np.ndarray) -> float:
    """By how much an answer is farther from the seed than the best of the grid, rad; -inf where that has none."""
    best = min((polished(arm, free, T, seed, dip) for dip in on_grid(arm, free, T, seed)), default=math.inf)
    return float(np.linalg.norm(q - seed)) - best


def main(arguments: Sequence[str] | None = None) -> None:
    command = parser(__doc__.splitlines()[0], "poses, each asked twice")
    command.add_argument("--grid", type=int, default=0, help="poses at which the answer is compared with a grid (0)")
    given = command.parse_args(arguments)
    rng = np.random.default_rng([given.seed, 17])
    missed, worst = 0, 0.0
    spent: list[float] = []
    behind: list[float] = []
    for arm, cases in arms_of(given.robot, given.count, given.seed):
        for _ in range(cases):
            free, T, seed = case(arm, rng)
            for near in (None, seed):
                solution, seconds = timed(arm, T, free, near)
                spent.append(seconds)
                error = off(arm, free, T, solution.q)
                worst = max(worst, error if solution else 0.0)
                if not solution or error > MET:
                    missed += 1
                    say(f"{arm.name}, {free}: {solution!r}; pose = {T.tolist()}, seed = {near}")
            if len(behind) < given.grid and solution:
                behind.append(compared(arm, free, T, seed, solution.q))
                if behind[-1] > FARTHER:
                    say(
                        f"{arm.name}, {free}: {behind[-1]:.2e} rad farther; pose = {T.tolist()}, seed = {seed.tolist()}"
                    )
    figures = f"{len(spent)} questions with a free axis, {missed} missed, off by {worst:.1e} at most; "
    if behind:
        farther = sum(each > FARTHER for each in behind)
        figures += f"{farther} of {len(behind)} farther than a grid's best, by {max(0.0, *behind):.1e} rad at most; "
    finish(given.robot, given.seed, figures + f"{1e6 * np.mean(spent):.0f} us in the mean", missed)


if __name__ == "__main__":
    main()
