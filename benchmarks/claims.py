"""Claims of the source paper beside its five experiments, each measured in a way that could refute it.

Run: python benchmarks/claims.py [--robot human_arm] [--tasks 300] [--scipy 10]

Prints JSON; docs/what_holds.py makes a page of it. Joint limits play no part, as they play none in the paper.
"""

from __future__ import annotations

import argparse
import json
from typing import Any

import numpy as np
import pinocchio as pin

import srs_ik
from srs_ik.paper.experiments.ik_accuracy import reached_tasks
from srs_ik.paper.experiments.measure import jacobians, points, solve
from srs_ik.paper.experiments.setting import SEED, ball, directions, reach, task_directions, unit
from srs_ik.system.arrays import plain

ELBOWS = 36
"""Elbow positions around the circle that a posture is compared with."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robot", default="human_arm")
    parser.add_argument("--tasks", type=int, default=300, help="tasks of each comparison (default 300)")
    parser.add_argument("--scipy", type=int, default=10, help="tasks that SciPy optimises (default 10)")
    chosen = parser.parse_args()
    if not 1 <= chosen.scipy <= chosen.tasks:
        parser.error("--scipy must be at least 1 and no more than --tasks")
    print(json.dumps(plain(claims(srs_ik.load(chosen.robot), chosen.tasks, chosen.scipy)), indent=1, allow_nan=False))


def claims(arm: srs_ik.Arm, tasks: int, scipy_tasks: int) -> dict[str, Any]:
    """All measurements by name."""
    return {
        "robustness": robustness(arm, 100 * tasks),
        "optimality": {
            "random": optimality(arm, random_tasks(arm, tasks)),
            "in_the_plane": optimality(arm, planar_tasks(arm, tasks)),
        },
        "printed_optimisation": printed_optimisation(arm, random_tasks(arm, scipy_tasks)),
        "planar_arm": planar_arm(arm, planar_tasks(arm, tasks)),
        "null_space": null_space(arm, random_tasks(arm, tasks)),
        "duality": duality(arm, tasks),
        "polytope": polytope(arm, tasks),
    }


# Tasks ------------------------------------------------------------------------------------------------------------


def random_tasks(arm: srs_ik.Arm, count: int) -> srs_ik.Task:
    """Those of the paper's experiment on accuracy: g = v, phi = f."""
    x_d, v, f = reached_tasks(arm, count)
    return srs_ik.Task(x_d, v, f, v, f)


def planar_tasks(arm: srs_ik.Arm, count: int) -> srs_ik.Task:
    """The same with targets in the task's plane through the shoulder, where the whole arm can lie in it."""
    rng = np.random.default_rng(SEED)
    v, f = task_directions(rng, 4 * count)
    angle, length = rng.uniform(0.0, 2.0 * np.pi, (4 * count, 1)), rng.uniform(0.3, 1.0, (4 * count, 1))
    x_d = arm.limb.shoulder + reach(arm) * length * (np.cos(angle) * v + np.sin(angle) * f)
    ok = np.flatnonzero(arm.posture(srs_ik.Task(x_d, v, f, v)).reached)[:count]
    return srs_ik.Task(x_d[ok], v[ok], f[ok], v[ok], f[ok])


def spread(values: np.ndarray) -> dict[str, Any]:
    """Median, 90th percentile and largest."""
    median, most, worst = np.quantile(values, [0.5, 0.9, 1.0])
    return {"count": len(values), "median": median, "most": most, "worst": worst}


# Robustness ---------------------------------------------------------------------------------------------------------


def robustness(arm: srs_ik.Arm, count: int) -> dict[str, Any]:
    """Random tasks, half of them degenerate: parallel v and f, targets at the shoulder, along n, or at full stretch."""
    rng = np.random.default_rng(SEED)
    v, f = task_directions(rng, count)
    g = directions(rng, count)
    offset = ball(rng, count, 1.2 * reach(arm))
    eighth = count // 8
    f[:eighth] = -v[:eighth]
    offset[eighth : 2 * eighth] = 0.0
    offset[2 * eighth : 3 * eighth] = 0.5 * reach(arm) * np.cross(v, f)[2 * eighth : 3 * eighth]
    straight = directions(rng, eighth)
    offset[3 * eighth : 4 * eighth] = reach(arm) * straight
    g[3 * eighth : 4 * eighth] = straight
    bad, angles = 0, 0
    for grasp in (g, None):
        task = srs_ik.Task(arm.limb.shoulder + offset, v, f, grasp, np.cross(g, directions(rng, count)))
        for side in ("left", "right"):
            posture = arm.posture(task, side)
            points_of_it = np.concatenate([posture.elbow, posture.wrist, posture.hand, posture.normal], axis=1)
            bad += int((~np.isfinite(points_of_it).all(axis=1)).sum())
            angles += int((~np.isfinite(solve(arm, task, side).q).all(axis=1)).sum())
    return {"postures": 4 * count, "postures_not_finite": bad, "joint_angles_not_finite": angles}


# Optimality ---------------------------------------------------------------------------------------------------------


def ease(J: np.ndarray, u: np.ndarray) -> np.ndarray:
    """u'JpJp'u of Jacobians (N, 6, 7) and directions (N, 3), m^2."""
    return np.sum(np.einsum("ni,nij->nj", u, J[:, :3]) ** 2, axis=1)


def optimality(arm: srs_ik.Arm, task: srs_ik.Task) -> dict[str, Any]:
    """The geometrical posture beside the best one over branches and arm angles, and beside other elbow positions.

    Ratios are 1 where the posture is the best; C, f'JpJp'f and v'JpJp'v each against its own optimum.
    """
    solution = solve(arm, task, "left")
    v, f = task.velocity, task.force
    J = jacobians(arm, solution.q)
    C = srs_ik.force_velocity_ratio(J, f, v)
    other_side = srs_ik.force_velocity_ratio(jacobians(arm, solve(arm, task, "right").q), f, v)
    best = {name: [] for name in ("force_velocity_ratio", "force_then_velocity", "velocity_then_force")}
    better = []
    for i in range(len(C)):
        T = solution.T_base_tip[i]
        for name, values in best.items():
            exact = {} if name == "force_velocity_ratio" else {"tolerance": 0.0}
            found = arm.optimise(T, name, respect_limits=False, force=f[i], velocity=v[i], **exact)
            values.append(found.value)
        psi = solution.arm_angle[i] + 2.0 * np.pi * np.arange(1, ELBOWS) / ELBOWS
        others = arm.solve_batch(np.repeat(T[None], ELBOWS - 1, axis=0), arm_angle=psi, respect_limits=False)
        better.append(np.mean(srs_ik.force_velocity_ratio(jacobians(arm, others.q), f[i], v[i]) < C[i] * (1 - 1e-9)))
    best_C = np.array(best["force_velocity_ratio"])
    ratio = C / best_C
    return {
        "C_over_best": spread(ratio),
        "C_of_the_better_side_over_best": spread(np.minimum(C, other_side) / best_C),
        "within_one_percent": float(np.mean(ratio < 1.01)),
        "force_term_over_best": spread(ease(J, f) / np.array(best["force_then_velocity"])),
        "best_over_velocity_term": spread(np.array(best["velocity_then_force"]) / ease(J, v)),
        "share_of_other_elbows_that_are_better": float(np.mean(better)),
    }


def printed_optimisation(arm: srs_ik.Arm, task: srs_ik.Task, starts: int = 20) -> dict[str, Any]:
    """The geometrical posture beside the paper's numerical optimisation by SciPy, and that beside `Arm.optimise`."""
    solution = solve(arm, task, "left")
    over_scipy, gain = [], []
    for i, q in enumerate(solution.q):
        T, v, f = solution.T_base_tip[i], task.velocity[i], task.force[i]
        words: dict[str, Any] = {"force": f, "velocity": v, "respect_limits": False}
        printed = srs_ik.paper.printed_optimum(arm, T, "force_velocity_ratio", accuracy=1e-9, starts=starts, **words)
        exact = arm.optimise(T, "force_velocity_ratio", **words)
        if printed:
            over_scipy.append(srs_ik.force_velocity_ratio(arm.jacobian(q), f, v) / printed.value)
            gain.append(exact.value / printed.value - 1.0)
    return {
        "C_over_scipy": spread(np.array(over_scipy)),
        "starts": starts,
        "most_that_scipy_gains_on_optimise": max(gain),
        "most_that_scipy_loses": -min(gain),
    }


def planar_arm(arm: srs_ik.Arm, task: srs_ik.Task) -> dict[str, Any]:
    """C beside that of three parallel joints at shoulder, elbow and wrist, arm and task in one plane.

    `expected` corrects the three joints for the angles at which shoulder and wrist axes stand on the plane.
    """
    solution = solve(arm, task, "left")
    v, f, n = task.velocity, task.force, solution.posture.task_normal
    elbow, wrist, tips = points(arm, solution.q)
    hand = tips[:, :3, 3]
    joints = np.stack([np.broadcast_to(arm.limb.shoulder, elbow.shape), elbow, wrist])
    turns = np.cross(n, hand - joints)
    J = jacobians(arm, solution.q)
    share = np.einsum("nij,ni->nj", J[:, 3:], n) ** 2
    weight = np.stack([share[:, :3].sum(axis=1), share[:, 3], share[:, 4:].sum(axis=1)])

    def c(weight: Any) -> np.ndarray:
        return np.sum(weight * np.sum(turns * f, axis=2) ** 2, axis=0) / np.sum(
            weight * np.sum(turns * v, axis=2) ** 2, axis=0
        )

    C = srs_ik.force_velocity_ratio(J, f, v)
    return {
        "relative_difference": spread(np.abs(C / c(1.0) - 1.0)),
        "with_the_axes_weighed": spread(np.abs(C / c(weight) - 1.0)),
        "least_and_largest_weight_of_the_shoulder": [weight[0].min(), weight[0].max()],
    }


# Theorem 1 ----------------------------------------------------------------------------------------------------------


def null_space(arm: srs_ik.Arm, task: srs_ik.Task) -> dict[str, Any]:
    """Null-space power of gravity's torque: in any elbow position, and as the posture follows its target along v.

    P is the projector on the null space of J. The least joint velocity for the task has none of it whatever the
    posture; that of the moving posture comes from differences of its joint angles 1e-6 m before and behind.
    """
    step = 1e-6
    v = task.velocity
    here = solve(arm, task, "left")
    ahead, behind = (
        beside(arm, srs_ik.Task(task.position + s * step * v, v, task.force, v, task.force), here.q)
        for s in (1.0, -1.0)
    )
    rate = (ahead.q - behind.q) / (2.0 * step)
    smooth = (np.abs(ahead.q - behind.q).max(axis=1) < 1e-3) & ahead.ok & behind.ok
    data, rng = arm.model.createData(), np.random.default_rng(SEED)
    least_power, power, share, stillness = [], [], [], []
    for i in np.flatnonzero(smooth):
        twist = np.append(v[i], np.zeros(3))
        elsewhere = arm.solve(here.T_base_tip[i], arm_angle=rng.uniform(-np.pi, np.pi), respect_limits=False).q
        for q in (here.q[i], elsewhere):
            J = arm.jacobian(q)
            torque = pin.computeGeneralizedGravity(arm.model, data, arm.configuration(q)).copy()
            P = np.eye(7) - np.linalg.pinv(J) @ J
            least_power.append(abs(torque @ P @ np.linalg.pinv(J) @ twist) / np.linalg.norm(torque))
            if q is not elsewhere:
                power.append(abs(torque @ P @ rate[i]) / abs(torque @ rate[i]))
                share.append(np.linalg.norm(P @ rate[i]) / np.linalg.norm(rate[i]))
                stillness.append(np.linalg.norm(P @ torque) / np.linalg.norm(torque))
    return {
        "tasks": int(smooth.sum()),
        "largest_for_the_least_joint_velocity": max(least_power),
        "share_of_the_joint_velocity": spread(np.array(share)),
        "share_of_the_power": spread(np.array(power)),
        "share_of_gravity_torque_in_the_null_space": spread(np.array(stillness)),
    }


def beside(arm: srs_ik.Arm, task: srs_ik.Task, q: np.ndarray) -> srs_ik.BatchSolution:
    """Joint angles for the postures of tasks, in the branches of other joint angles (N, 7)."""
    wanted = solve(arm, task, "left")
    psi = wanted.posture.arm_angle
    return arm.solve_batch(wanted.T_base_tip, arm_angle=psi, seed=q, respect_limits=False)


# Ellipsoids ---------------------------------------------------------------------------------------------------------


def random_postures(arm: srs_ik.Arm, count: int) -> np.ndarray:
    """(count, 6, 7) Jacobians at joint angles drawn uniformly from the whole turn."""
    return jacobians(arm, np.random.default_rng(SEED).uniform(-np.pi, np.pi, (count, 7)))


def duality(arm: srs_ik.Arm, count: int) -> dict[str, Any]:
    """Eigenvalues of (JJ')^-1 and JJ', by NumPy alone, beside the semi-axes of the ellipsoids."""
    J = random_postures(arm, count)
    velocity, force = srs_ik.velocity_ellipsoid(J), srs_ik.force_ellipsoid(J)
    A = J[:, :3] @ J[:, :3].swapaxes(1, 2)
    of_velocity, of_force = np.linalg.eigvalsh(np.linalg.inv(A)), np.linalg.eigvalsh(A)[:, ::-1]
    along = np.abs(np.einsum("nij,nij->nj", velocity.axes, force.axes))
    return {
        "product_of_eigenvalues_minus_1": float(np.abs(of_velocity * of_force - 1.0).max()),
        "product_of_semi_axes_minus_1": float(np.abs(velocity.radii * force.radii - 1.0).max()),
        "semi_axis_times_root_of_eigenvalue_minus_1": float(np.abs(velocity.radii * np.sqrt(of_velocity) - 1.0).max()),
        "semi_axis_times_eigenvalue": spread((velocity.radii * of_velocity).ravel()),
        "axes_apart": float(np.abs(along - 1.0).max()),
    }


def polytope(arm: srs_ik.Arm, count: int) -> dict[str, Any]:
    """How far the tip's velocities with |qdot_i| <= 1 reach along the ellipsoid's axes, in its semi-axes, by SciPy."""
    from scipy.optimize import linprog

    J = random_postures(arm, max(count // 3, 1))
    ellipsoids = srs_ik.velocity_ellipsoid(J)
    ratios = []
    for Jp, axes, radii in zip(J[:, :3], ellipsoids.axes, ellipsoids.radii, strict=True):
        for u, radius in zip(unit(axes.T), radii, strict=True):
            equal = np.column_stack([Jp, -u])
            found = linprog([0.0] * 7 + [-1.0], A_eq=equal, b_eq=np.zeros(3), bounds=[(-1, 1)] * 7 + [(0, None)])
            ratios.append(-found.fun / radius)
    return {**spread(np.array(ratios)), "least": min(ratios)}


if __name__ == "__main__":
    main()
