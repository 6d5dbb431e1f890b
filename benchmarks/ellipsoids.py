"""Times ellipsoids and polytopes, and measures polytopes against linear programmes, beside pycapacity used by itself.

Run: python benchmarks/ellipsoids.py [--postures N]

Prints Markdown. Needs the extra "polytopes". Postures are random inside the limits of iiwa14; "next to a singularity"
means that joints 4 and 6 are at 0.001 rad, so that the arm is stretched but for that.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable

import numpy as np
import pinocchio as pin
from pycapacity import robot
from scipy.optimize import linprog

import srs_ik

DIRECTIONS = 5
MANY = 1000
STRETCHED = 1e-3


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--postures", type=int, default=200, metavar="N")
    count = parser.parse_args(arguments).postures
    if count < 1:
        parser.error("--postures takes a number of at least 1")
    arm = srs_ik.load("iiwa14")
    rng = np.random.default_rng(1)
    usual = rng.uniform(arm.lower, arm.upper, (count, 7))
    stretched = usual.copy()
    stretched[:, [3, 5]] = STRETCHED
    print_times(arm, usual)
    print()
    print_errors(arm, {"random": usual, "next to a singularity": stretched}, rng)


def print_times(arm: srs_ik.Arm, postures: np.ndarray) -> None:
    J = [arm.jacobian(q) for q in postures]
    many = np.array([arm.jacobian(q) for q in np.resize(postures, (MANY, 7))])
    vmax, tmax = arm.velocity_limit, arm.effort_limit
    load = gravity(arm, postures[0])
    calls: dict[str, list[Callable[[], object]]] = {
        "`velocity_ellipsoid(J)`": [lambda j=j: srs_ik.velocity_ellipsoid(j) for j in J],
        "`force_ellipsoid(J, limit)`": [lambda j=j: srs_ik.force_ellipsoid(j, tmax) for j in J],
        f"`velocity_ellipsoid` of {MANY:,} Jacobians": [lambda: srs_ik.velocity_ellipsoid(many)] * 10,
        "`velocity_polytope(arm, q)`": [lambda q=q: srs_ik.velocity_polytope(arm, q) for q in postures],
        "`force_polytope(arm, q)`": [lambda q=q: srs_ik.force_polytope(arm, q) for q in postures],
        "pycapacity `velocity_polytope`": [lambda j=j: robot.velocity_polytope(j[:3], vmax, -vmax) for j in J],
        "pycapacity `force_polytope`": [lambda j=j: robot.force_polytope(j[:3], tmax, -tmax, load) for j in J],
    }
    print("| call | median, microseconds |")
    print("|---|--:|")
    for name, functions in calls.items():
        functions[0]()
        print(f"| {name} | {statistics.median(elapsed(call) for call in functions):.0f} |")


def print_errors(arm: srs_ik.Arm, groups: dict[str, np.ndarray], rng: np.random.Generator) -> None:
    print("| postures | velocity, this package | pycapacity | force, this package | pycapacity |")
    print("|---|--:|--:|--:|--:|")
    for name, postures in groups.items():
        errors = np.array([differences(arm, q, rng) for q in postures])
        print(f"| {name} | {' | '.join(column(e) for e in errors.T)} |")


def differences(arm: srs_ik.Arm, q: np.ndarray, rng: np.random.Generator) -> list[float]:
    """Largest relative difference of each polytope from the linear programmes; inf where there is no polytope."""
    Jp, load = arm.jacobian(q)[:3], gravity(arm, q)
    vmax, tmax = arm.velocity_limit, arm.effort_limit
    rows, bounds = np.vstack([Jp.T, -Jp.T]), np.concatenate([tmax - load, tmax + load])
    u = rng.normal(size=(DIRECTIONS, 3))
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    fast = np.array([-linprog(-v @ Jp, bounds=np.column_stack([-vmax, vmax])).fun for v in u])
    strong = np.array([-linprog(-v, rows, bounds, bounds=(None, None)).fun for v in u])
    return [
        error(lambda: srs_ik.velocity_polytope(arm, q).vertices, u, fast),
        error(lambda: robot.velocity_polytope(Jp, vmax, -vmax).vertices.T, u, fast),
        error(lambda: srs_ik.force_polytope(arm, q).vertices, u, strong),
        error(lambda: robot.force_polytope(Jp, tmax, -tmax, load).vertices.T, u, strong),
    ]


def error(polytope: Callable[[], np.ndarray], u: np.ndarray, extents: np.ndarray) -> float:
    try:
        vertices = polytope()
    except Exception:
        return np.inf
    return float(np.max(np.abs((u @ vertices.T).max(axis=1) / extents - 1.0)))


def column(errors: np.ndarray) -> str:
    failed = int(np.isinf(errors).sum())
    worst = f"{errors[np.isfinite(errors)].max():.0e}" if failed < len(errors) else "-"
    return f"{worst}, {failed} of {len(errors)} fail" if failed else worst


def gravity(arm: srs_ik.Arm, q: np.ndarray) -> np.ndarray:
    return pin.computeGeneralizedGravity(arm.model, arm.model.createData(), arm.configuration(q)).copy()


def elapsed(call: Callable[[], object]) -> float:
    start = time.perf_counter()
    call()
    return 1e6 * (time.perf_counter() - start)


if __name__ == "__main__":
    main()
