"""Free arm angles against Pinocchio's collision check on the shapes of the robot's own file: one line.

Run: python benchmarks/collision_truth.py --robot iiwa14 [--count 100000] [--poses 500] [--seed 0] [--objects] [--held]

Random arm angles inside the limits, of random poses, each with its posture by `pinocchio.computeCollisions`, the same
pairs watched: how many are called free by the closed form and by the exact mode, how many of these collide, and which
share of the truly free ones that is. `--objects` puts six boxes, balls and cylinders within reach, `--held` a box into
the hand, `--other` puts another arm of the same robot to a random posture. Robots are those of `tests/arms.py` and
those that `srs_ik.load` knows by name. Exits 1 where one collides.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import coal
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

import arms
from collision_oracle import Truth, file_of
from scene_sets import boxes_and_balls

import srs_ik

HELD = (0.2, 0.2, 0.2)
"""Edges of the box in the hand, m."""


def loaded(name: str) -> srs_ik.Arm:
    return arms.load(name) if name in arms.PLACES else srs_ik.load(name)


def with_box(arm: srs_ik.Arm) -> tuple[srs_ik.Arm, srs_ik.Arm, np.ndarray]:
    """The arm, the same with a box in its hand, and the pose of that in the tip frame."""
    T = np.eye(4)
    grasp = arm.hand.grasp if getattr(arm, "hand", None) is not None else np.array([0.0, 0.0, 1.0])
    T[:3, 3] = 0.2 * np.asarray(grasp)
    return arm, arm.with_object("box in the hand", T, HELD), T


def beside(arm: srs_ik.Arm, other: srs_ik.Arm, truth: Truth, scenes: list[srs_ik.Scene], seed: int) -> None:
    """Put another arm of the robot to a random posture inside its limits, the same for all."""
    rng = arms.generator(other.name + "beside", seed)
    q = rng.uniform(np.maximum(other.lower, -np.pi), np.minimum(other.upper, np.pi))
    truth.put_beside(other, q)
    for scene in scenes:
        scene.add_arm("other", other, q, beside=arm)


def counted(arm: srs_ik.Arm, truth: Truth, scenes: list[srs_ik.Scene], given: argparse.Namespace) -> list[list[int]]:
    """For each scene: truly free angles, those called free, and those of them that collide."""
    rng = arms.generator(arm.name, given.seed)
    lower = np.where(np.isfinite(arm.lower), arm.lower, -np.pi)
    upper = np.where(np.isfinite(arm.upper), arm.upper, np.pi)
    totals = [[0, 0, 0] for _ in scenes]
    each_pose = -(-given.count // given.poses)
    for _ in range(given.poses):
        T = arm.forward_kinematics(rng.uniform(lower, upper)).homogeneous
        every = arm.intervals(T)
        widths = np.array([each.width for each in every])
        if not widths.sum() > 0.0:
            continue
        left = [arm.intervals(T, scene=scene) for scene in scenes]
        for k in rng.choice(len(every), each_pose, p=widths / widths.sum()).tolist():
            branch, psi = every[k].branch, float(rng.uniform(every[k].lower, every[k].upper))
            posture = arm.solve(T, arm_angle=psi, branch=branch)
            if not posture:
                continue
            is_free = not truth.collides(posture.q)
            for total, free in zip(totals, left, strict=True):
                is_called = any(each.branch == branch and psi in each for each in free)
                total[0] += is_free
                total[1] += is_called
                total[2] += is_called and not is_free
    return totals


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robot", default="iiwa14")
    parser.add_argument("--count", type=int, default=100_000)
    parser.add_argument("--poses", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--objects", action="store_true")
    parser.add_argument("--held", action="store_true")
    parser.add_argument("--other", help="the other arm of the same robot, put at a random posture")
    parser.add_argument("--modes", nargs="+", default=["closed", "exact"], choices=["closed", "exact"])
    given = parser.parse_args()
    given.poses = min(given.poses, given.count)
    begin = time.process_time()
    arm = loaded(given.robot)
    file, folders = file_of(arm)
    truth = Truth(file, arm, folders)
    if given.held:
        bare, arm, T = with_box(arm)
        truth.hold("box in the hand", bare, arm, T, coal.Box(*HELD))
    scenes = [srs_ik.Scene(exact=mode == "exact") for mode in given.modes]
    for k, scene in enumerate(scenes):
        if given.objects:
            boxes_and_balls(arm, truth if k == 0 else None, scene)
    if given.other:
        beside(arm, loaded(given.other), truth, scenes, given.seed)
    totals = counted(arm, truth, scenes, given)
    asked = given.robot + ", objects" * given.objects + ", held" * given.held
    words = [f"{asked}{', beside ' + given.other if given.other else ''}, seed {given.seed}"]
    words.append(f"{totals[0][0]} of {given.count} angles of {given.poses} poses truly free")
    for mode, (free, called, false) in zip(given.modes, totals, strict=True):
        share = 100.0 * (called - false) / max(free, 1)
        words.append(f"{mode}: {called} called free ({share:.2f} %), {false} of these collide")
    print("; ".join([*words, f"{time.process_time() - begin:.0f} s"]))
    return int(any(false for _, _, false in totals))


if __name__ == "__main__":
    raise SystemExit(main())
