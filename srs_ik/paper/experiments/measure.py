"""How the experiments measure: by Pinocchio on the description itself, by brute force, and by the clock."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from srs_ik.analysis.ellipsoids import force_velocity_ratio, velocity_ellipsoid
from srs_ik.paper.experiments.setting import unit
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.arm import Arm
    from srs_ik.inputs.task import Task
    from srs_ik.solve.posture import Posture, Side
    from srs_ik.solve.task import BatchTaskSolution

_SWEEP = 720
_REPEATS = 5


def summary(values: Array) -> dict[str, Any]:
    """Count, mean, standard deviation and largest of some figures; None in place of those of no figures."""
    if not values.size:
        return {"count": 0, "mean": None, "deviation": None, "worst": None}
    return {
        "count": int(values.size),
        "mean": float(values.mean()),
        "deviation": float(values.std()),
        "worst": float(values.max()),
    }


def distance(a: Array, b: Array) -> Array:
    """(N,) distances between points (N, 3)."""
    return np.linalg.norm(a - b, axis=-1)


def angle_between(a: Array, b: Array) -> Array:
    """(N,) angles between unit vectors (N, 3), rad.

    Erratum 8: the paper takes the arc cosine of a.b, which cannot tell angles below 1.5e-8 rad from zero, and turns the
    rounding of a.b = 1 into them. Sine and cosine together can.
    """
    return np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), np.sum(a * b, axis=-1))


def printed_angle_between(a: Array, b: Array) -> Array:
    """(N,) the same angles as the paper's equation IKerror has them: by the arc cosine alone."""
    return np.arccos(np.clip(np.sum(a * b, axis=-1), -1.0, 1.0))


def points(arm: Arm, q: Array) -> tuple[Array, Array, Array]:
    """Elbow centres (N, 3), wrist centres (N, 3) and tip poses (N, 4, 4) at joint angles (N, 7), by Pinocchio.

    The elbow centre moves with joint 4, on whose axis it lies, and the wrist centre with the tip.
    """
    zero = np.zeros(7)
    elbow = np.linalg.solve(arm.joint_frames(zero)[4], np.append(arm.limb.elbow, 1.0))
    wrist = np.linalg.solve(arm.forward_kinematics(zero).homogeneous, np.append(arm.limb.wrist, 1.0))
    tips = np.array([arm.forward_kinematics(x).homogeneous for x in q]).reshape(-1, 4, 4)
    fours = np.array([arm.joint_frames(x)[4] for x in q]).reshape(-1, 4, 4)
    return (fours @ elbow)[:, :3], (tips @ wrist)[:, :3], tips


def task_ease(J: Array, v: Array, f: Array) -> dict[str, Any]:
    """How easily the tip moves along v and bears along f, unit vectors (3,), with a Jacobian (6, 7)."""
    linear = velocity_ellipsoid(J)
    return {
        "C": force_velocity_ratio(J, f, v),
        "f_JpJp_f_m2": float(np.sum((f @ J[:3]) ** 2)),
        "v_JpJp_v_m2": float(np.sum((v @ J[:3]) ** 2)),
        "rank_of_Jp": linear.rank,
        "smallest_singular_value_of_Jp_m": linear.radii[-1],
    }


def jacobians(arm: Arm, q: Array) -> Array:
    """(N, 6, 7) Jacobians by Pinocchio at joint angles (N, 7)."""
    return np.array([arm.jacobian(x) for x in q]).reshape(-1, 6, 7)


def solve(arm: Arm, tasks: Task, side: Side) -> BatchTaskSolution:
    """Joint angles for N tasks; limits play no part, as they play none in the paper."""
    from srs_ik.solve.task import BatchTaskSolution

    solution = arm.solve_task(tasks, side, respect_limits=False)
    assert isinstance(solution, BatchTaskSolution)
    return solution


def posture_figures(arm: Arm, posture: Posture, target: Array, side: Side, held: bool) -> dict[str, Any]:
    """What a batch of N postures is worth, measured from its points alone.

    `target` (N, 3) is where the hand had to be, metres; `side` that of the elbow, `held` whether there was a grasp.
    """
    S, E, W, H = posture.shoulder, posture.elbow, posture.wrist, posture.hand
    finite = np.isfinite(np.concatenate([E, W, H], axis=1)).all(axis=1)
    ok = posture.reached
    line = unit((W if held else H) - S)
    offset = (E - S) - np.sum((E - S) * line, axis=1, keepdims=True) * line
    towards = offset[:, 1] if side == "left" else -offset[:, 1]
    n = posture.task_normal
    aligned = np.abs(np.sum(unit(np.cross(line, unit(np.where(ok[:, None], offset, 1.0)))) * n, axis=1))
    return {
        "postures": len(finite),
        "not_finite": int((~finite).sum()),
        "reached": int(ok.sum()),
        "stretched": int((~ok & (posture.miss > 0.0)).sum()),
        "folded": int((~ok & (posture.miss < 0.0)).sum()),
        "elbow_on_the_other_side": int((towards[ok] < -1e-9).sum()),
        "upper_arm_error_m": summary(np.abs(distance(E, S) - arm.limb.upper_arm)),
        "forearm_error_m": summary(np.abs(distance(W, E) - arm.limb.forearm)),
        "target_error_m": summary(distance(H, target)[ok]),
        "alignment_of_elbow_axis_and_n": summary(aligned[ok]),
        "alignment_gained_by_a_sweep": summary(_best_alignment(line[ok], n[ok]) - aligned[ok]),
    }


def _best_alignment(line: Array, n: Array) -> Array:
    """(N,) largest |elbow axis . n| among 720 elbows around the line from the shoulder."""
    across = unit(np.cross(line, np.eye(3)[np.abs(line).argmin(axis=1)]))
    up = np.cross(line, across)
    turn = np.linspace(0.0, np.pi, _SWEEP)
    return np.abs(
        np.outer(np.sum(across * n, axis=1), np.cos(turn)) + np.outer(np.sum(up * n, axis=1), np.sin(turn))
    ).max(axis=1, initial=0.0)


def microseconds(call: Callable[[Any], object], one: list[Any], many: Any, count: int) -> dict[str, float]:
    """Median time of single calls, and time a task of the fastest of five batches, both after a warm-up."""
    for argument in (*one[:20], many):
        call(argument)
    single = [_taken(call, argument) for argument in one]
    batch = [_taken(call, many) for _ in range(_REPEATS)]
    return {"single": float(np.median(single)), "batch": min(batch) / count}


def _taken(call: Callable[[Any], object], argument: Any) -> float:
    begin = time.perf_counter_ns()
    call(argument)
    return 1e-3 * (time.perf_counter_ns() - begin)
