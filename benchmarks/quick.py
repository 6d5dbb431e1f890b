"""Times this package and its peers side by side, in one run on one machine.

Run: python benchmarks/quick.py [--poses N] [--json FILE]

Prints Markdown: the wall time from a new process to the first answer, and the time of single calls from Python. Peers
are timed where they are installed (extra "bench"). Figures of different runs or machines are not to be compared.
"""

from __future__ import annotations

import argparse
import gc
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from importlib import metadata, util
from pathlib import Path
from typing import Any

import numpy as np

import srs_ik

ROBOTS = ("iiwa14", "gen3")
SEED_SPREAD = 0.3
"""Seeds are this near to the configuration whose pose is asked for, rad a joint."""
LOCKED = 0.4
"""Angle at which joint 3 is held for a solver of six joints, rad."""
START = """
import srs_ik
arm = srs_ik.load("iiwa14")
assert arm.solve(arm.forward_kinematics([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2]))
"""
ROOT = Path(__file__).resolve().parents[1]
WARM_STARTS = 5
WARM_UP = 20


@dataclass(frozen=True)
class Timed:
    """Single calls of one function, one for each pose.

    Attributes:
        robot: name of the robot.
        package: name and version.
        call: what was called.
        median_us: median time of a call, microseconds.
        p99_us: 99th percentile.
        worst_us: slowest call.
        solved: poses with an answer.
        poses: poses asked for.
        error: largest error of an answer by its own package: the larger of m and rad, or the largest entry of the
            difference of two pose matrices; None where a call returns no posture.
    """

    robot: str
    package: str
    call: str
    median_us: float
    p99_us: float
    worst_us: float
    solved: int
    poses: int
    error: float | None


@dataclass(frozen=True)
class Work:
    """Poses of random configurations inside the limits, and what the calls take along.

    Attributes:
        q: (N, 7) configurations, rad.
        seeds: (N, 7) configurations near them, rad.
    """

    q: np.ndarray
    seeds: np.ndarray

    @staticmethod
    def of(arm: srs_ik.Arm, count: int) -> Work:
        rng = np.random.default_rng(0)
        lower = np.where(np.isfinite(arm.lower), arm.lower, -np.pi)
        upper = np.where(np.isfinite(arm.upper), arm.upper, np.pi)
        q = rng.uniform(lower, upper, (count, 7))
        seeds = np.clip(q + rng.uniform(-SEED_SPREAD, SEED_SPREAD, q.shape), arm.lower, arm.upper)
        return Work(q, seeds)


def time_calls(call: Callable[..., Any], arguments: Sequence[tuple[Any, ...]]) -> tuple[np.ndarray, list[Any]]:
    """Time of each call, microseconds, and what each returned; first calls, which compile or allocate, come before."""
    for given in arguments[:WARM_UP]:
        call(*given)
    times, answers = np.empty(len(arguments)), []
    gc.disable()
    try:
        for i, given in enumerate(arguments):
            begin = time.perf_counter_ns()
            answer = call(*given)
            times[i] = 1e-3 * (time.perf_counter_ns() - begin)
            answers.append(answer)
    finally:
        gc.enable()
    return times, answers


def timed(
    robot: str,
    package: str,
    name: str,
    call: Callable[..., Any],
    arguments: Sequence[tuple[Any, ...]],
    error_of: Callable[..., float | None] | None,
    is_answer: Callable[[Any], bool] = bool,
) -> Timed:
    """Time a function on the arguments of each call; `error_of` gets the answer and the pose."""
    times, answers = time_calls(call, arguments)
    answered = [(answer, given[0]) for answer, given in zip(answers, arguments, strict=True) if is_answer(answer)]
    errors = [error_of(answer, pose) for answer, pose in answered] if error_of else []
    return Timed(
        robot,
        f"{package} {metadata.version(package)}",
        name,
        float(np.median(times)),
        float(np.percentile(times, 99.0)),
        float(times.max()),
        len(answered),
        len(answers),
        max((error for error in errors if error is not None), default=None),
    )


def own(robot: str, count: int) -> Iterator[Timed]:
    """The calls of this package."""
    arm = srs_ik.load(robot)
    work = Work.of(arm, count)
    poses = [arm.forward_kinematics(q).homogeneous for q in work.q]
    at_angle = [(pose, arm.arm_angle(q)) for pose, q in zip(poses, work.q, strict=True)]
    seeded = [(pose, None, seed) for pose, seed in zip(poses, work.seeds, strict=True)]
    alone = [(pose,) for pose in poses]
    free = [(pose, angle, False) for pose, angle in at_angle]

    def error_of(answer: Any, pose: np.ndarray) -> float:
        return float(max(np.max(answer.position_error), np.max(answer.orientation_error)))

    package = "srs-ik"
    yield timed(robot, package, "solve(pose, arm_angle)", arm.solve, at_angle, error_of)
    yield timed(robot, package, "solve_all(pose, arm_angle)", arm.solve_all, at_angle, error_of)
    yield timed(robot, package, "solve_all(pose, arm_angle), no limits", arm.solve_all, free, error_of)
    yield timed(robot, package, "solve(pose, seed)", arm.solve, seeded, error_of)
    yield timed(robot, package, "solve(pose)", arm.solve, alone, error_of)
    yield timed(robot, package, "intervals(pose)", arm.intervals, alone, None)


def eaik(robot: str, count: int) -> Iterator[Timed]:
    """EAIK with joint 3 locked: the branches at one value of the redundancy, without limits."""
    from eaik.IK_HP import HPRobot

    arm = srs_ik.load(robot)
    limb = arm.limb
    origins = np.vstack([np.zeros(3), limb.points, limb.T_base_tip_zero[:3, 3]])
    solver = HPRobot(limb.axes, np.diff(origins, axis=0), [(2, LOCKED)])
    if not solver.hasKnownDecomposition():
        return
    q = Work.of(arm, count).q
    q[:, 2] = LOCKED
    poses = [(solver.fwdKin(row),) for row in q]

    def is_answer(answer: Any) -> bool:
        # Near misses are among the answers, and marked as least-squares ones.
        return answer.num_solutions() > 0 and not all(answer.is_LS)

    def error_of(answer: Any, pose: np.ndarray) -> float:
        met = [row for row, nearly in zip(answer.Q, answer.is_LS, strict=True) if not nearly]
        return float(max(np.abs(solver.fwdKin(row) - pose).max() for row in met))

    yield timed(robot, "EAIK", "IK(pose), joint 3 locked, no limits", solver.IK, poses, error_of, is_answer)


def ssik(robot: str, count: int) -> Iterator[Timed]:
    """The prebuilt arm of ssik: the posture nearest to a seed, and the feasible arcs of all charts."""
    from ssik import Manipulator

    arm = Manipulator.from_prebuilt(robot)
    work = Work.of(srs_ik.load(robot), count)
    poses = [(arm.fk(q),) for q in work.q]

    def solve(pose: np.ndarray, seed: np.ndarray) -> Any:
        return arm.solve(pose, max_solutions=1, q_seed=seed, seed_metric="wrap_l2")

    def arcs(pose: np.ndarray) -> Any:
        return [arc for chart in arm.self_motion(pose).charts for arc in chart.in_limits()]

    def error_of(answer: Any, pose: np.ndarray) -> float:
        return float(max(solution.fk_residual for solution in answer))

    seeded = [(pose, seed) for (pose,), seed in zip(poses, work.seeds, strict=True)]
    yield timed(robot, "ssik", "solve(pose, seed), one answer", solve, seeded, error_of)
    yield timed(robot, "ssik", "solve(pose)", arm.solve, poses, error_of)
    try:
        arm.self_motion(poses[0][0])
    except NotImplementedError:
        return
    # Milliseconds a call: fewer poses tell as much.
    yield timed(robot, "ssik", "self_motion(pose), in_limits()", arcs, poses[: max(1, count // 10)], None)


def starts() -> dict[str, float]:
    """Wall time of a new process that imports, loads iiwa14 and solves once: with an empty cache, then a full one."""
    with tempfile.TemporaryDirectory() as cache:
        environment = {**os.environ, "NUMBA_CACHE_DIR": cache}

        def start() -> float:
            begin = time.perf_counter()
            subprocess.run([sys.executable, "-c", START], check=True, env=environment, cwd=ROOT)
            return time.perf_counter() - begin

        fresh = start()
        return {"fresh_cache_s": fresh, "warm_cache_s": statistics.median(start() for _ in range(WARM_STARTS))}


def machine() -> dict[str, str]:
    """What the figures belong to."""
    cpu = platform.processor() or platform.machine()
    details = Path("/proc/cpuinfo")
    if details.is_file():
        models = [line.partition(":")[2].strip() for line in details.read_text().splitlines() if "model name" in line]
        cpu = models[0] if models else cpu
    versions = {name: metadata.version(name) for name in ("srs-ik", "pin", "numpy", "numba")}
    return {"cpu": f"{cpu}, {os.cpu_count()} cores", "python": platform.python_version(), **versions}


def markdown(about: dict[str, str], start: dict[str, float], rows: Sequence[Timed]) -> str:
    """The report as Markdown."""
    lines = [", ".join(f"{name} {value}" for name, value in about.items() if name != "cpu") + f"; {about['cpu']}.", ""]
    if start:
        lines += [
            "| import, load iiwa14, first solve, in a new process | s |",
            "|---|--:|",
            f"| kernels not compiled yet | {start['fresh_cache_s']:.2f} |",
            f"| kernels in the cache, median of {WARM_STARTS} | {start['warm_cache_s']:.2f} |",
            "",
        ]
    lines += [
        "| robot | package | call | median (us) | 99 % (us) | worst (us) | answered | worst error |",
        "|---|---|---|--:|--:|--:|--:|--:|",
    ]
    for row in rows:
        error = "" if row.error is None else f"{row.error:.1e}"
        times = f"{row.median_us:.2f} | {row.p99_us:.2f} | {row.worst_us:.1f}"
        answered = f"{row.solved} of {row.poses}"
        lines.append(f"| {row.robot} | {row.package} | {row.call} | {times} | {answered} | {error} |")
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, print, and write the figures where they are wanted."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--poses", type=int, default=2000, help="poses a robot and call (default 2000)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures into this file too")
    parser.add_argument("--no-start", action="store_true", help="leave out the start of new processes")
    chosen = parser.parse_args(arguments)
    if chosen.poses < 1:
        parser.error("--poses must be at least 1")
    measures = [own]
    measures += [peer for name, peer in (("eaik", eaik), ("ssik", ssik)) if util.find_spec(name)]
    about, start = machine(), {} if chosen.no_start else starts()
    rows = [row for robot in ROBOTS for measure in measures for row in measure(robot, chosen.poses)]
    print(markdown(about, start, rows))
    if chosen.json:
        report = {"machine": about, "start": start, "calls": [asdict(row) for row in rows]}
        chosen.json.write_text(json.dumps(report, indent=2) + "\n")


if __name__ == "__main__":
    main()
