"""Tasks by the clock: postures, and postures with inverse kinematics, one at a time and in batches.

Run: python benchmarks/task.py [--tasks 1000] [--batch 20000]

Prints a Markdown table. The tasks are those of the source paper's experiments: targets in the sphere of the arm's
reach, velocity and force orthogonal, grasp along the velocity, pronosupination along the force. Its figures, in MATLAB:
30 us for a posture, 78 us for a posture with inverse kinematics; it knows no joint limits. Where limits count, which
takes longer, a batch is a twentieth of the others.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import srs_ik

ROBOTS = ("human_arm", "iiwa14", "gen3")
REPEATS = 3


def unit(a: np.ndarray) -> np.ndarray:
    return a / np.linalg.norm(a, axis=-1, keepdims=True)


def paper_tasks(arm: srs_ik.Arm, count: int) -> dict[str, np.ndarray]:
    """Arguments of `Task`, (count, 3) each."""
    rng = np.random.default_rng(0)
    limb = arm.limb
    reach = limb.upper_arm + limb.forearm + limb.hand
    v = unit(rng.normal(size=(count, 3)))
    f = unit(np.cross(v, rng.normal(size=(count, 3))))
    offset = unit(rng.normal(size=(count, 3))) * (reach * rng.uniform(size=count) ** (1 / 3))[:, None]
    return {"position": limb.shoulder + offset, "velocity": v, "force": f, "grasp": v, "pronosupination": f}


def single_us(call: Callable[[srs_ik.Task], Any], tasks: list[srs_ik.Task]) -> float:
    """Median time of a call, microseconds."""
    times = []
    warm_up = tasks[:20]
    for task in warm_up + tasks:
        begin = time.perf_counter_ns()
        call(task)
        times.append(1e-3 * (time.perf_counter_ns() - begin))
    return float(np.median(times[len(warm_up) :]))


def batch_us(call: Callable[[], Any], count: int) -> float:
    """Time a task of the fastest of some calls on a whole batch, microseconds."""
    times = []
    for _ in range(REPEATS + 1):
        begin = time.perf_counter_ns()
        call()
        times.append(1e-3 * (time.perf_counter_ns() - begin) / count)
    return min(times)


def row(arm: srs_ik.Arm, name: str, given: dict[str, np.ndarray], singles: int, call: Callable[..., Any]) -> str:
    """One line of the table; `call` takes a `Task`, and gives something that says how many it reached."""
    batch = srs_ik.Task(**given)
    alone = [srs_ik.Task(**{key: values[i] for key, values in given.items()}) for i in range(singles)]
    answer = call(batch)
    reached = float(np.mean(answer.reached if isinstance(answer, srs_ik.Posture) else answer.ok))
    one, many = single_us(call, alone), batch_us(lambda: call(batch), len(given["position"]))
    return f"| {arm.name} | {name} | {one:.2f} | {many:.2f} | {100.0 * reached:.0f} % |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tasks", type=int, default=1000, help="tasks of the single calls (default 1000)")
    parser.add_argument("--batch", type=int, default=20000, help="tasks of a batch (default 20000)")
    chosen = parser.parse_args()
    if not 1 <= chosen.tasks <= chosen.batch:
        parser.error("--tasks must be at least 1 and no more than --batch")
    print("| robot | call | one at a time (us) | in a batch (us) | reached |")
    print("|---|---|--:|--:|--:|")
    for robot in ROBOTS:
        arm = srs_ik.load(robot)
        given = paper_tasks(arm, chosen.batch)
        free = {key: values for key, values in given.items() if key != "pronosupination"}
        ungrasped = {key: values for key, values in free.items() if key != "grasp"}

        def solve(task: srs_ik.Task, arm: srs_ik.Arm = arm) -> Any:
            return arm.solve_task(task, respect_limits=False)

        print(row(arm, "posture, no grasp", ungrasped, chosen.tasks, arm.posture))
        print(row(arm, "posture", given, chosen.tasks, arm.posture))
        print(row(arm, "solve_task, no limits", given, chosen.tasks, solve))
        few = max(chosen.batch // 20, 1)
        for name, fields in (("solve_task", given), ("solve_task, free roll", free)):
            part = {key: values[:few] for key, values in fields.items()}
            print(row(arm, name, part, min(chosen.tasks, few), arm.solve_task))


if __name__ == "__main__":
    main()
