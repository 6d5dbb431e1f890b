"""Any robot file: which of its joints make an S-R-S arm, and a pose that each of these arms solves.

Run: python examples/any_urdf.py [FILE.urdf]
"""

import argparse
from pathlib import Path

import numpy as np

import srs_ik

GEN3 = Path(__file__).resolve().parents[1] / "robots" / "gen3" / "gen3.urdf"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", nargs="?", type=Path, default=GEN3, help="a URDF file; by default the Gen3's")
    urdf = parser.parse_args().file
    try:
        reports = srs_ik.find_limbs(urdf)
    except srs_ik.SrsIkError as error:
        parser.error(str(error))
    if not reports:
        print(f"{urdf.name} has no chain of seven consecutive revolute joints.")
    for report in reports:
        print(report.describe())
        if report.limb is not None:
            show(srs_ik.load(urdf, base=report.base, tip=report.tip))


def show(arm: srs_ik.Arm) -> None:
    """Solve the pose of a random configuration, and compare with Pinocchio."""
    lower, upper = (np.where(np.isfinite(limit), limit, turn) for limit, turn in ((arm.lower, -3.0), (arm.upper, 3.0)))
    q = np.random.default_rng(0).uniform(lower, upper)
    pose = arm.forward_kinematics(q)
    solution = arm.solve(pose)
    error = arm.verify(pose, solution.q)
    intervals, postures = arm.intervals(pose), arm.solve_all(pose, arm_angle=arm.arm_angle(q))
    batch = arm.solve_batch([pose, pose], seed=q)
    print(f"  pose of q = {np.round(q, 3)}")
    print(f"  {solution.status.name}: q = {np.round(solution.q, 3)}, off by {error.position:.1e} m by Pinocchio")
    print(f"  intervals of arm angles: {len(intervals)}; postures at the arm angle of q: {len(postures)}")
    print(f"  nearest to q itself: {np.abs(batch.q[0] - q).max():.1e} rad away")


if __name__ == "__main__":
    main()
