"""Which mechanism answers for near limbs: the prediction by the nearest exact limb, or curves on the true chain.

Run: SRS_IK_JIT=1 python benchmarks/near_mechanisms.py [--poses N] [ARM ...] (its own kernels call those of the package)

Poses of random configurations inside the limits. For `intervals` and `solve(pose)` it prints the share that is
predicted, with arcs next to singularities followed or without, and of those that are not, how many have an elbow that
is almost straight; and the processor time a pose.
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
from srs_ik.kernels.layout.asked import Target
from srs_ik.kernels.limb.poses import read_pose
from srs_ik.kernels.limb.triangle import place
from srs_ik.kernels.near.arcs import ARC, MOST_ARCS, find_arcs
from srs_ik.kernels.near.band import may_predict_limits
from srs_ik.kernels.near.intervals import true_intervals
from srs_ik.kernels.near.predicted import predicted_intervals
from srs_ik.kernels.near.predicted_best import predicted_best
from srs_ik.kernels.near.scan import view_of

PREDICTED, ON_ARCS, STRAIGHT, FAILED = range(4)
REASONS = ("predicted", "predicted, arcs followed", "followed: elbow may be straight", "followed: no certain prediction")
ARMS = ("gen3", "j2s7s300", "iiwa14_experimental", "rm75", "h1_2_left")


@numba.njit(error_model="numpy")
def target_of(P, pose):
    """A pose as kernels take it."""
    R, p, _ = read_pose(row(pose, 0))
    return Target(R, p, place(P, R, p))


@numba.njit(error_model="numpy")
def has_arcs(P, target):
    """Whether an arc next to a singularity is anywhere near."""
    return find_arcs(P, view_of(P, target), np.empty((MOST_ARCS, ARC))) != 0


@numba.njit(error_model="numpy")
def decide(family, poses, J, A, out, how, best):
    """How the intervals of each pose are found, and whether its best posture is predicted."""
    P = row(family, 0)
    for i in range(len(poses)):
        target = target_of(P, poses[i])
        n = predicted_intervals(P, target, out, J, A)
        if n >= 0:
            how[i] = ON_ARCS if has_arcs(P, target) else PREDICTED
        else:
            how[i] = FAILED if may_predict_limits(P, target.place, view_of(P, target).band) else STRAIGHT
        _, best[i] = predicted_best(P, target, -1, J, A)


@numba.njit(error_model="numpy")
def predict(family, poses, J, A, out):
    """The intervals of each pose, predicted."""
    for i in range(len(poses)):
        predicted_intervals(row(family, 0), target_of(row(family, 0), poses[i]), out, J, A)


@numba.njit(error_model="numpy")
def follow(family, poses, J, A, out):
    """The intervals of each pose, from curves."""
    for i in range(len(poses)):
        true_intervals(row(family, 0), target_of(row(family, 0), poses[i]), True, out, J, A)


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
        for word, which, call in (
            ("predicted", how == PREDICTED, predict),
            ("predicted, arcs followed", how == ON_ARCS, predict),
            ("followed", how >= STRAIGHT, follow),
        ):
            some = np.ascontiguousarray(poses[which][:200])
            if len(some):
                call(family, some[:1], J, A, out)
                print(
                    f"{name:20s} intervals {word}: {time_of(call, family, some, J, A, out) / len(some):.0f} us a pose"
                )


if __name__ == "__main__":
    main()
