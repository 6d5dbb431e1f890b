"""Whether another posture is closer to a pose out of reach in both errors: bounded SciPy against the answers.

python benchmarks/closest.py [--targets 1000] [--robots iiwa14 gen3 human_arm] [--urdf FILE:BASE:TIP]

A target is a random orientation at a random place out of reach. The answer's position and orientation errors are what
SciPy (SLSQP, bounded by the limits) tries to better at once: it lowers t, where neither error exceeds the answer's by
more than t, from random postures and from the answer itself.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

import numpy as np
import pinocchio as pin
from rich.progress import track
from scipy.optimize import minimize
from singular import Known, anywhere

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
    e, J = known.errors(q[None], pose)
    e, J = e[0], J[0]
    halves = slice(0, 3), slice(3, 6)
    return np.array([e[h] @ e[h] for h in halves]), np.array([-2.0 * e[h] @ J[h] for h in halves])


def bettered(arm: srs_ik.Arm, known: Known, pose: np.ndarray, rng: np.random.Generator) -> float:
    """By how much, m and rad, both errors of the answer can be lowered at once, as far as SciPy finds."""
    solution = arm.solve(pose)
    best = 0.0
    own, _ = sizes(known, solution.q, pose)
    own = np.sqrt(own)
    bounds = [(-np.inf, np.inf), *zip(arm.lower, arm.upper, strict=True)]
    constraint = {
        "type": "ineq",
        "fun": lambda x: np.maximum(own + x[0], 0.0) ** 2 - sizes(known, x[1:], pose)[0],
        "jac": lambda x: np.hstack([2.0 * np.maximum(own + x[0], 0.0)[:, None], -sizes(known, x[1:], pose)[1]]),
    }
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
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--targets", type=int, default=1000, help="targets for each robot")
    parser.add_argument("--robots", nargs="*", default=["iiwa14", "gen3", "human_arm"])
    parser.add_argument("--urdf", nargs="*", default=[], help="FILE:BASE:TIP")
    given = parser.parse_args(arguments)
    arms = [srs_ik.load(name) for name in given.robots]
    for text in given.urdf:
        file, base, tip = text.split(":")
        arms.append(srs_ik.load(file, base=base, tip=tip))
    rng = np.random.default_rng(0)
    failed = 0
    print("| arm | targets | bettered in both errors | by at most (m and rad) |\n|---|--:|--:|--:|")
    for arm in arms:
        known = Known(arm)
        poses = targets(arm, given.targets, rng)
        gains = np.array([bettered(arm, known, pose, rng) for pose in track(poses, arm.name)])
        print(f"| `{arm.name}` | {len(gains)} | {(gains > BETTER).sum()} | {gains.max():.1e} |")
        for i in np.argsort(-gains)[:5]:
            if gains[i] > BETTER:
                print(f"  {gains[i]:.2e}: {arm.solve(poses[i])}\n  {poses[i].tolist()}")
        failed += int((gains > BETTER).sum())
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
