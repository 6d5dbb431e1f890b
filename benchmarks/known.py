"""Whether postures at and next to singular ones are in an interval, and arm angles of intervals are met.

python benchmarks/known.py [--postures 1000] [--robots iiwa14 human_arm gen3] [--urdf FILE:BASE:TIP] [--random 100]

Poses are those of random configurations inside the limits, most of whose shoulder, elbow or wrist is singular, or
almost. The arm angle of each must lie in an interval of its branch; where a joint is singular, of either side of it.
Arm angles of all intervals are then asked for, and Pinocchio measures the answers.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence

import numpy as np
from rich.progress import track
from singular import TOGETHER, Case, anywhere, cases, random_arms, singular_angles
from swept import wrapped

import srs_ik

SIDE = 1e-5
"""A middle angle with a sine below this may count for either side of its singularity."""

BESIDE = 1e-6
"""A posture's arm angle may lie so far beside its interval, rad ..."""

ROUNDING = 1e-14
"""... and farther where it is told badly: by so much over the bend of the elbow."""

SHARES = (0.0, 1e-3, 0.2, 0.5, 0.8, 1.0 - 1e-3, 1.0)
"""Where in an interval its postures are asked for, as a part of its width."""

MET = 1e-9
"""Largest error of an answer, m and rad."""


def ordinary(arm: srs_ik.Arm, count: int, rng: np.random.Generator) -> Iterator[Case]:
    """Postures that are singular by chance alone."""
    for _ in range(count):
        q = anywhere(arm, rng)
        yield Case(q, arm.forward_kinematics(q).homogeneous, q, (), 1.0)


def beside(arm: srs_ik.Arm, case: Case, intervals: Sequence[srs_ik.Interval]) -> float:
    """How far a posture's arm angle is from the nearest interval of its branch, rad; inf if there is none."""
    singular = singular_angles(arm.limb)
    sides = {joint: np.sin(case.q[joint] - angle) for joint, angle in singular.items()}
    bits = {3: 4, 1: 2, 5: 1}
    either = sum(bits[joint] for joint, side in sides.items() if abs(side) < SIDE)
    psi, branch = arm.arm_angle(case.q), arm.branch(case.q)
    away = [
        max(abs(wrapped(psi - 0.5 * (i.lower + i.upper))) - 0.5 * i.width, 0.0)
        for i in intervals
        if (i.branch | either) == (branch | either)
    ]
    return float(min(away, default=np.inf))


def missed(arm: srs_ik.Arm, case: Case, intervals: Sequence[srs_ik.Interval]) -> Iterator[tuple[int, float, str]]:
    """Branch, arm angle and status of what is asked for inside an interval and not met."""
    for i in intervals:
        for share in SHARES:
            psi = i.lower + share * i.width
            solution = arm.solve(case.pose, arm_angle=psi, branch=i.branch)
            met = bool(solution) and max(arm.verify(case.pose, solution.q)) < MET
            if not met or (solution.q < arm.lower).any() or (solution.q > arm.upper).any():
                yield i.branch, psi, str(solution.status)


def judge(name: str, made: Iterator[tuple[srs_ik.Arm, Case]], count: int) -> int:
    """Print a row of the table; how many postures are in no interval, and arm angles of intervals are not met."""
    lost, unmet, asked, tried = 0, 0, 0, 0
    for arm, case in track(made, name, total=count):
        tried += 1
        intervals = arm.intervals(case.pose)
        asked += len(intervals) * len(SHARES)
        bend = abs(np.sin(case.q[3] - singular_angles(arm.limb)[3]))
        away = beside(arm, case, intervals)
        what = f"  {arm.name} no. {tried}: joints {[j + 1 for j in case.joints]} off by {case.offset:g}:"
        if away > BESIDE + ROUNDING / max(bend, 1e-300):
            lost += 1
            print(what, f"{away:.2g} rad beside {len(intervals)} intervals, q = {case.q.tolist()}")
        for branch, psi, status in missed(arm, case, intervals):
            unmet += 1
            print(what, f"branch {branch}, arm angle {psi!r}: {status}, q = {case.q.tolist()}")
    print(f"| `{name}` | {tried} | {lost} | {asked} | {unmet} |", flush=True)
    return lost + unmet


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--postures", type=int, default=1000, help="singular postures of each robot")
    parser.add_argument("--ordinary", type=int, default=0, help="postures of each robot that are singular by chance")
    parser.add_argument("--robots", nargs="*", default=["iiwa14", "human_arm", "gen3"])
    parser.add_argument("--urdf", nargs="*", default=[], help="FILE:BASE:TIP")
    parser.add_argument("--random", type=int, default=20, help="random arms, with 10 postures each")
    parser.add_argument("--misses", nargs="*", type=float, default=[0.0], help="by how much their joints miss, m")
    parser.add_argument("--no-elbow", action="store_true", help="no singular elbow")
    given = parser.parse_args(arguments)
    together = ((1,), (5,), (1, 5)) if given.no_elbow else TOGETHER
    arms = [srs_ik.load(name) for name in given.robots]
    for text in given.urdf:
        file, base, tip = text.split(":")
        arms.append(srs_ik.load(file, base=base, tip=tip))
    print("| arm | known postures | in no interval | arm angles of intervals | not met |\n|---|--:|--:|--:|--:|")
    rng = np.random.default_rng(0)
    failed = 0
    for arm in arms:
        if given.ordinary:
            failed += judge(f"{arm.name}, any", ((arm, c) for c in ordinary(arm, given.ordinary, rng)), given.ordinary)
        if given.postures:
            failed += judge(arm.name, ((arm, c) for c in cases(arm, given.postures, rng, together)), given.postures)
    made = random_arms(given.random, 1, tuple(given.misses))
    failed += judge("random", ((arm, c) for arm in made for c in cases(arm, 10, rng, together)), 10 * given.random)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
