"""Whether another posture is closer to a pose out of reach in both errors: bounded SciPy against the answers.

python benchmarks/closest.py [--count 1000] [--seed 0] [--robot iiwa14]

A target is a random orientation at a random place out of reach. The answer's position and orientation errors are what
SciPy (SLSQP, bounded by the limits) tries to better at once: it lowers t, where neither error exceeds the answer's by
more than t, from random postures and from the answer itself.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin
from scipy.optimize import minimize
from singular import Known, anywhere
from subjects import arms_of, finish, parser, say

import srs_ik

BETTER = 1e-4
"""An answer fails if both errors, m and rad, can be lowered by more than this."""

STARTS = 20


def targets(arm: srs_ik.Arm, count: int, rng: np.random.Generator) -> np.ndarray:
    """Poses (count, 4, 4) that no configuration reaches, limits aside: half of them just out of reach."""
    found = []
    home = arm.limb.shoulder
    span = np.linalg.norm(arm.limb.elbow - arm.limb.shoulder) + np.linalg.norm(arm.limb.wrist - arm.limb.elbow)
    while len(found) < count:
        way = rng.normal(size=3)
        way *= span * (rng.uniform(0.9, 1.5) if len(found) % 2 else rng.uniform(1.5, 5.0)) / np.linalg.norm(way)
        pose = pin.SE3(pin.Quaternion(*pin.Quaternion(rng.normal(size=4)).normalized().coeffs()).matrix(), home + way)
        if arm.solve(pose, respect_limits=False).status == srs_ik.Status.UNREACHABLE:
            found.append(pose.homogeneous)
    return np.array(found)


def sizes(known: Known, q: np.ndarray, pose: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(2,) squared position and orientation errors, and their (2, 7) derivatives."""
    e, J = known.errors_of_one(q, pose)
    halves = slice(0, 3), slice(3, 6)
    return np.array([e[h] @ e[h] for h in halves]), np.array([-2.0 * e[h] @ J[h] for h in halves])


def bettered(arm: srs_ik.Arm, known: Known, pose: np.ndarray, rng: np.random.Generator) -> float:
    """By how much, m and rad, both errors of the answer can be lowered at once, as far as SciPy finds."""
    solution = arm.solve(pose)
    best = 0.0
    own, _ = sizes(known, solution.q, pose)
    own = np.sqrt(own)
    bounds = [(-np.inf, np.inf), *zip(arm.lower, arm.upper, strict=True)]
    last: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []

    def left(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What both errors are below the answer's by t or more, x[0] being t; and the derivatives of it."""
        if not last or (last[0][0] != x).any():
            size, rates = sizes(known, x[1:], pose)
            room = np.maximum(own + x[0], 0.0)
            last[:] = [(x.copy(), room**2 - size, np.hstack([2.0 * room[:, None], -rates]))]
        return last[0][1:]

    constraint = {"type": "ineq", "fun": lambda x: left(x)[0], "jac": lambda x: left(x)[1]}
    slope = np.eye(8)[0]
    for start in [solution.q, *(anywhere(arm, rng) for _ in range(STARTS - 1))]:
        errors = np.sqrt(sizes(known, start, pose)[0])
        found = minimize(
            lambda x: x[0],
            np.concatenate([[float((errors - own).max())], start]),
            jac=lambda x: slope,
            bounds=bounds,
            constraints=[constraint],
            method="SLSQP",
            options={"maxiter": 100, "ftol": 1e-9},
        ).x[1:]
        if np.isfinite(found).all():
            errors = np.sqrt(sizes(known, np.clip(found, arm.lower, arm.upper), pose)[0])
            best = max(best, float((own - errors).min()))
    return best


def main(arguments: Sequence[str] | None = None) -> None:
    given = parser(__doc__.splitlines()[0], "targets").parse_args(arguments)
    most, failed, tried = 0.0, 0, 0
    for arm, count in arms_of(given.robot, given.count, given.seed):
        known, rng = Known(arm), np.random.default_rng([given.seed, tried])
        for pose in targets(arm, count, rng):
            tried, gain = tried + 1, bettered(arm, known, pose, rng)
            most = max(most, gain)
            if gain > BETTER:
                failed += 1
                say(f"{arm.name}: {gain:.2e} (m and rad) better than {arm.solve(pose)!r}; pose = {pose.tolist()}")
    figures = f"{tried} far targets, {failed} bettered in both errors (1e-4 m and rad), at most by {most:.1e}"
    finish(given.robot, given.seed, figures, failed)


if __name__ == "__main__":
    main()
