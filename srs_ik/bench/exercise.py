"""Every question to an arm, asked once in each way: what compiles all kernels, and what times their first calls.

python -m srs_ik.bench.exercise ROBOT asks them all, and prints a line behind each: its name and the seconds it took.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import srs_ik
from srs_ik.bench.floor import floor_us
from srs_ik.bench.work import Work

POSES = 24
STEP = 0.02
"""Joint steps along the path, rad."""

Call = Callable[[], Any]


def calls(arm: srs_ik.Arm, count: int = POSES) -> dict[str, Call]:
    """Calls without arguments, by name; the first is the first that most programs make.

    Batches and the path have `count` poses; all begin at the posture (0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2).
    """
    q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    pose = arm.forward_kinematics(q)
    work = Work.of(arm, count)
    way = np.array([arm.forward_kinematics(q + STEP * i).homogeneous for i in range(count)])
    # Outer axes of shoulder and wrist in line: a surface of postures.
    surface = arm.forward_kinematics([0.3, 0.0, 0.2, -1.1, 0.4, 0.0, 0.1])
    task = srs_ik.Task([0.4, 0.2, 0.5], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0])
    target = pose.translation + np.linspace(0.0, 0.05, count)[:, None]
    tasks = srs_ik.Task(target, np.tile([1.0, 0.0, 0.0], (count, 1)), np.tile([0.0, 0.0, 1.0], (count, 1)))
    tracker = arm.tracker(q, 0.01, np.full(7, 1.0), np.full(7, 10.0))
    return {
        "solve": lambda: arm.solve(pose),
        "solve, seed": lambda: arm.solve(pose, seed=q),
        "solve, arm angle": lambda: arm.solve(pose, arm_angle=0.2),
        "solve, arm angle and seed": lambda: arm.solve(pose, arm_angle=0.2, seed=q),
        "all postures": lambda: arm.solve_all(pose),
        "all branches": lambda: arm.solve_all(pose, arm_angle=0.2),
        "intervals": lambda: arm.intervals(pose),
        "batch": lambda: arm.solve_batch(work.poses),
        "batch, seeds": lambda: arm.solve_batch(work.poses, seed=work.seeds),
        "batch, arm angles": lambda: arm.solve_batch(work.poses, arm_angle=work.arm_angles),
        "batch, arm angles and seeds": lambda: arm.solve_batch(work.poses, work.arm_angles, seed=work.seeds),
        "batch, all branches": lambda: arm.solve_batch(work.poses, work.arm_angles, all_branches=True),
        "batch of intervals": lambda: arm.intervals_batch(work.poses),
        "self motion": lambda: arm.self_motion(pose),
        "free splits": lambda: arm.free_splits(pose),
        "optimise": lambda: arm.optimise(pose, "manipulability"),
        "optimise, two objectives": lambda: arm.optimise(
            pose, "force_then_velocity", force=[0.0, 0.0, 1.0], velocity=[1.0, 0.0, 0.0]
        ),
        "optimise, a function": lambda: arm.optimise(surface, lambda q: float(q @ q)),
        "path": lambda: arm.solve_path(way),
        "path, seed": lambda: arm.solve_path(way, seed=q),
        "path, least largest step": lambda: arm.solve_path(way, seed=q, objective="largest_step"),
        "posture for a task": lambda: arm.posture(task),
        "postures for tasks": lambda: arm.posture(tasks),
        "task": lambda: arm.solve_task(task),
        "task, seed": lambda: arm.solve_task(task, seed=q),
        "tasks": lambda: arm.solve_task(tasks),
        "forward kinematics, batch": lambda: arm.forward_kinematics_batch(work.q),
        "Jacobian, batch": lambda: arm.jacobian_batch(work.q),
        "reachable, batch": lambda: arm.reachable_batch(work.poses),
        "tracker": lambda: tracker.update(pose),
        "arm angle": lambda: arm.arm_angle(q),
        "arm angle's Jacobian": lambda: arm.arm_angle_jacobian(q),
        "self-motion tangent": lambda: arm.self_motion_tangent(q),
        "yardstick": floor_us,
    }


def first_calls(robot: str) -> dict[str, float]:
    """Seconds that each call takes, in this order; `load` is the first."""
    begin = time.perf_counter()
    arm = srs_ik.load(robot)
    took = {"load": time.perf_counter() - begin}
    _tell("load", took)
    for name, call in calls(arm).items():
        begin = time.perf_counter()
        call()
        took[name] = time.perf_counter() - begin
        _tell(name, took)
    return took


def _tell(name: str, took: dict[str, float]) -> None:
    print(f"{name}: {took[name]:.6f}", flush=True)


if __name__ == "__main__":
    first_calls(*sys.argv[1:])
