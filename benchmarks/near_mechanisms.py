"""Which mechanism answers for near limbs: the prediction by the nearest exact limb, or curves on the true chain.

Run: SRS_IK_JIT=1 python benchmarks/near_mechanisms.py [--poses N] [ARM ...] (its own kernels call those of the package)

Poses of random configurations inside the limits. For `intervals` and `solve(pose)` it prints the share that is
predicted, and why the others are not: the elbow is almost straight (or the axes are oblique), the elbow is about as far
from a limit as the prediction is uncertain, or shoulder or wrist come close to singular; and the processor time a pose
where the prediction decides, and where curves are followed.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numba
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

import arms

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.limb.limits import beyond, turn_to_middle
from srs_ik.kernels.limb.poses import read_pose
from srs_ik.kernels.limb.triangle import elbow_side, place
from srs_ik.kernels.near.band import band_of, may_predict
from srs_ik.kernels.near.intervals import true_intervals
from srs_ik.kernels.near.predicted import predicted_intervals
from srs_ik.kernels.near.predicted_best import predicted_best

PREDICTED, STRAIGHT, ELBOW_LIMIT, SINGULAR = range(4)
REASONS = ("predicted", "elbow straight or oblique axes", "elbow at a limit", "singular, or too close to tell")
ARMS = ("gen3", "j2s7s300", "iiwa14_experimental", "rm75", "h1_2_left")


@numba.njit(error_model="numpy")
def reason(P, place_):
    """Why a pose is not predicted, as far as this is known before."""
    band = band_of(P, place_)
    if not may_predict(P, place_, band):
        return STRAIGHT
    for elbow in range(2):
        if abs(beyond(P, 3, turn_to_middle(P, 3, elbow_side(P, place_, elbow)[0]))) < band:
            return ELBOW_LIMIT
    return SINGULAR


@numba.njit(error_model="numpy")
def decide(family, poses, J, A, out, how, best):
    """How the intervals of each pose are found, and whether its best posture is predicted."""
    for i in range(len(poses)):
        R, p, _ = read_pose(row(poses, i))
        P = row(family, 0)
        place_ = place(P, R, p)
        how[i] = PREDICTED if predicted_intervals(P, place_, R, p, out) >= 0 else reason(P, place_)
        _, _, best[i] = predicted_best(P, place_, R, p, -1)


@numba.njit(error_model="numpy")
def predict(family, poses, J, A, out):
    """The intervals of each pose, predicted."""
    for i in range(len(poses)):
        R, p, _ = read_pose(row(poses, i))
        predicted_intervals(row(family, 0), place(row(family, 0), R, p), R, p, out)


@numba.njit(error_model="numpy")
def follow(family, poses, J, A, out):
    """The intervals of each pose, from curves."""
    for i in range(len(poses)):
        R, p, _ = read_pose(row(poses, i))
        true_intervals(row(family, 0), place(row(family, 0), R, p), R, p, True, out, J, A)


def time_of(call, *arguments) -> float:
    """Processor time of a call, microseconds."""
    begin = time.process_time()
    call(*arguments)
    return 1e6 * (time.process_time() - begin)


def main() -> None:
    """Count, and print a line an arm and reason."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("arms", nargs="*", default=arms.here(*ARMS), metavar="ARM")
    parser.add_argument("--poses", type=int, default=2000)
    chosen = parser.parse_args()
    J, A, out = np.empty((6, 7)), np.empty((16, 9)), np.empty((288, 3))
    for name in chosen.arms:
        arm = arms.load(name)
        if arm.packed.closed:
            continue
        poses = np.array([arm.forward_kinematics(q).homogeneous for q in arms.configurations(name, chosen.poses, 5)])
        how, best = np.empty(len(poses), np.int64), np.empty(len(poses), np.bool_)
        family = arm.packed.family
        decide(family, poses, J, A, out, how, best)
        for code, why in enumerate(REASONS):
            print(f"{name:20s} intervals, {why:32s} {100.0 * (how == code).mean():5.1f} %")
        print(f"{name:20s} solve(pose), predicted {100.0 * best.mean():26.1f} %")
        for word, which, call in (("predicted", how == PREDICTED, predict), ("followed", how != PREDICTED, follow)):
            some = np.ascontiguousarray(poses[which][:200])
            if len(some):
                call(family, some[:1], J, A, out)
                print(
                    f"{name:20s} intervals {word}: {time_of(call, family, some, J, A, out) / len(some):.0f} us a pose"
                )


if __name__ == "__main__":
    main()
