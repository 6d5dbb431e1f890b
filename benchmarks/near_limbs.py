"""Whether intervals of near limbs hold what there is: known postures in them, arm angles inside them that are met.

Run: python benchmarks/near_limbs.py [--pattern oblique] [--miss 0.02] [--limbs 40] [--poses 50] [--inside 5]

Random limbs whose axes miss by up to so much of their lengths; those that recognition refuses are left out. For each
pose of a random configuration inside the limits it asks for the intervals, looks whether one holds the branch and arm
angle of that configuration, and solves at random arm angles inside them. Every failure is printed with what it takes to
see it again.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from oracles import random_limb

import srs_ik

CLOSE = 1e-9
"""Arm angles this close to an end, rad, are in the interval."""


def ahead(interval: srs_ik.Interval, psi: float) -> float:
    """How far an arm angle is outside an interval, rad."""
    beyond = (psi - interval.lower) % (2.0 * np.pi)
    return max(0.0, min(beyond - interval.width, 2.0 * np.pi - beyond))


def main() -> int:
    """Measure, and print a line a failure; the exit status says whether there were any."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--pattern", default="oblique", choices=("oblique", "tilted", "coordinate"))
    parser.add_argument("--miss", type=float, default=0.02, help="of the length shoulder-elbow-wrist (default 0.02)")
    parser.add_argument("--limbs", type=int, default=40)
    parser.add_argument("--poses", type=int, default=50, help="poses a limb (default 50)")
    parser.add_argument("--inside", type=int, default=5, help="arm angles a pose (default 5)")
    parser.add_argument("--first", type=int, default=0, help="seed of the first limb (default 0)")
    chosen = parser.parse_args()
    known = missing = asked = unmet = tried = 0
    begin = time.process_time()
    for seed in range(chosen.first, chosen.first + chosen.limbs):
        elbow, limits = ("straight", "offset")[seed % 2], ("usual", "mixed")[seed // 2 % 2]
        limb = random_limb(seed, chosen.pattern, elbow, limits, chosen.miss)
        try:
            arm = srs_ik.load(limb.model, base="base", tip="tool")
        except srs_ik.NotAnSrsLimb:
            continue
        tried += 1
        which = f"limb {seed} ({elbow}, {limits})"
        rng = np.random.default_rng(seed)
        for number in range(chosen.poses):
            q = limb.configuration()
            pose = arm.forward_kinematics(q)
            intervals = arm.intervals(pose)
            branch, psi = arm.branch(q), arm.arm_angle(q)
            known += 1
            off = min((ahead(i, psi) for i in intervals if i.branch == branch), default=np.inf)
            if off > CLOSE:
                missing += 1
                print(f"{which}, pose {number}: branch {branch}, {psi:.6f} rad in none, {off:.1e} rad off")
            for _ in range(chosen.inside if intervals else 0):
                i = intervals[rng.integers(len(intervals))]
                angle = i.lower + i.width * rng.uniform(0.001, 0.999)
                asked += 1
                if not arm.solve(pose, arm_angle=angle, branch=i.branch):
                    unmet += 1
                    print(f"{which}, pose {number}: branch {i.branch}, {angle:.6f} rad unmet in {i}")
    print(
        f"{tried} {chosen.pattern} limbs, axes off by up to {100.0 * chosen.miss:g} %: {missing} of {known} known "
        f"postures in no interval, {unmet} of {asked} arm angles inside intervals not met "
        f"({time.process_time() - begin:.0f} s)"
    )
    return int(missing + unmet > 0)


if __name__ == "__main__":
    sys.exit(main())
