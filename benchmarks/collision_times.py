"""What bodies cost on iiwa14: free intervals and postures with and without a scene, in one run, turn about.

Run: python benchmarks/collision_times.py [--robot iiwa14] [--poses 200] [--rounds 5] [--seed 0]

Processor time of each call, mean over random poses, the least of some rounds: those of all cases follow one another, so
that a loaded machine slows all of them. Batches are timed by the clock: two threads need two free processors.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from arms import generator

import srs_ik

ROLL = (0.0, 0.0, 1.0)
"""An axis of the tip whose roll is free."""


def mixed(arm: srs_ik.Arm, rng: np.random.Generator, count: int = 20) -> srs_ik.Scene:
    """Spheres, boxes, cylinders and capsules in turn, about the reach of an arm."""
    scene = srs_ik.Scene()
    for k in range(count):
        p = rng.uniform(-1.0, 1.0, 3)
        p = arm.limb.shoulder + (0.5 + 0.4 * rng.random()) * p / np.linalg.norm(p)
        T = srs_ik.pose_from_xyz_rpy(p, rng.uniform(-2, 2, 3))
        if k % 4 == 0:
            scene.add_sphere(f"ball {k}", p, 0.06)
        elif k % 4 == 1:
            scene.add_box(f"box {k}", T, rng.uniform(0.05, 0.2, 3))
        elif k % 4 == 2:
            scene.add_cylinder(f"can {k}", T, 0.04, 0.2)
        else:
            scene.add_capsule(f"rod {k}", T, 0.03, 0.2)
    return scene


def cloud(arm: srs_ik.Arm, rng: np.random.Generator, count: int = 10_000) -> srs_ik.Scene:
    """Points of a table top and of a wall."""
    scene = srs_ik.Scene()
    half = count // 2
    table = np.column_stack([rng.uniform(0.3, 1.0, half), rng.uniform(-0.7, 0.7, half), np.full(half, -0.15)])
    wall = np.column_stack([np.full(count - half, 0.75), rng.uniform(-0.7, 0.7, count - half), rng.uniform(0, 1, half)])
    scene.add_points("cloud", np.vstack([table, wall]), radius=0.01)
    return scene


def timed(call: Callable[[np.ndarray], object], poses: np.ndarray) -> float:
    """Processor time of a call, s, its tables made: an arm keeps those of the last scene."""
    for T in poses:
        call(T)
    begin = time.process_time()
    for T in poses:
        call(T)
    return (time.process_time() - begin) / len(poses)


def timed_batch(call: Callable[[int], object], threads: int) -> float:
    """Time of a batch by the clock, s."""
    begin = time.perf_counter()
    call(threads)
    return time.perf_counter() - begin


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robot", default="iiwa14")
    parser.add_argument("--poses", type=int, default=200)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    arm = srs_ik.load(given.robot)
    rng = generator(given.robot, given.seed)
    lower = np.where(np.isfinite(arm.lower), arm.lower, -np.pi)
    upper = np.where(np.isfinite(arm.upper), arm.upper, np.pi)
    poses = np.array([arm.forward_kinematics(rng.uniform(lower, upper)).homogeneous for _ in range(given.poses)])
    alone, twenty, points = srs_ik.Scene(), mixed(arm, rng), cloud(arm, rng)
    real, real_twenty = srs_ik.Scene(exact=True), mixed(arm, generator(given.robot, given.seed))
    real_twenty.exact = True
    free = np.array([T for T in poses if arm.solve(T, scene=twenty)])
    blocked = np.array([T for T in poses if arm.solve(T, scene=twenty).status == srs_ik.Status.COLLISION])
    calls: dict[str, Callable[[np.ndarray], object]] = {
        "intervals, no scene": arm.intervals,
        "intervals, own body": lambda T: arm.intervals(T, scene=alone),
        "intervals, own body and 20 mixed bodies": lambda T: arm.intervals(T, scene=twenty),
        "intervals, own body and 10,000 points": lambda T: arm.intervals(T, scene=points),
        "solve, no scene": arm.solve,
        "solve, own body": lambda T: arm.solve(T, scene=alone),
        "solve, own body and 20 mixed bodies": lambda T: arm.solve(T, scene=twenty),
        "solve to a seed, own body and 20 mixed bodies": lambda T: arm.solve(T, seed=np.zeros(7), scene=twenty),
        "solve, a roll free, no scene": lambda T: arm.solve(T, free_axis=ROLL),
        "solve, a roll free, own body and 20 mixed bodies": lambda T: arm.solve(T, free_axis=ROLL, scene=twenty),
        "intervals, real shapes, own body": lambda T: arm.intervals(T, scene=real),
        "intervals, real shapes, own body and 20 mixed bodies": lambda T: arm.intervals(T, scene=real_twenty),
    }
    asked = [(name, call, free if name.startswith("solve") else poses) for name, call in calls.items()]
    asked.append(("solve, own body and 20 mixed bodies, nothing free", lambda T: arm.solve(T, scene=twenty), blocked))
    for _, call, own in asked:
        timed(call, own)
    times = [[timed(call, own) for _, call, own in asked] for _ in range(given.rounds)]
    print(f"of {len(poses)} poses {len(free)} have a free posture among 20 mixed bodies: those are solved")
    for (name, _, _), took in zip(asked, np.min(times, axis=0), strict=True):
        print(f"{1e6 * took:9.1f} us  {name}", flush=True)
    many = np.concatenate([poses] * 20)
    for name, batch in (
        ("intervals_batch", lambda threads: arm.intervals_batch(many, threads=threads, scene=twenty)),
        ("solve_batch", lambda threads: arm.solve_batch(many, threads=threads, scene=twenty)),
    ):
        batch(2)
        one, two = (min(timed_batch(batch, threads) for _ in range(given.rounds)) for threads in (1, 2))
        print(f"{1e6 * one / len(many):9.1f} us  {name}, 20 mixed bodies, one thread")
        print(f"{1e6 * two / len(many):9.1f} us  the same, two threads: {two / one:.2f} of it")


if __name__ == "__main__":
    main()
