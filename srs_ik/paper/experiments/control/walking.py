"""The paper's walking leg in dynamics, and theorem 1 there: power in the null space along different postures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.interpolate import CubicSpline

from srs_ik.control import TorqueController
from srs_ik.control.planners import minimum_jerk
from srs_ik.inputs.task import Task
from srs_ik.loading import load
from srs_ik.paper.experiments.control.human import ARMATURE, LIMB
from srs_ik.paper.experiments.control.setting import DAMPING, fractal
from srs_ik.paper.experiments.setting import SEED, Outcome, Progress, ball, reach, task_directions
from srs_ik.paper.experiments.walking import SNAPSHOTS
from srs_ik.plots.figure import new_figure
from srs_ik.sim import Plant, Record, simulate
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from srs_ik.arm import Arm
    from srs_ik.solve.posture import Tie

CYCLE, CYCLES = 1.0, 3
OFFSETS = (0.0, 30.0, 60.0, 90.0, 180.0)
"""Arm angles from that of the geometrical posture, degrees."""

TASKS, WAY, LASTING = 20, 0.15, 1.0
"""Tasks of theorem 1, how far the hand goes along v, m, and in which time, s."""


def walking_in_dynamics(arm: Arm, progress: Progress, short: bool = False) -> Outcome:
    """The foot goes through the six snapshots in one second, the knee where the geometrical posture has it.

    No ground: the force direction shapes the posture alone. The arm named plays no part, the leg has the lengths and
    inertias of the paper's limb.
    """
    limb = load(LIMB)
    record, aims, knees = _walk(limb, 0.1 if short else CYCLE * CYCLES)
    off = np.linalg.norm(record.tip - aims, axis=1)
    later = record.t >= (0.0 if short else CYCLE)
    figures: dict[str, Any] = {
        "toe_error_m": {"rms": float(np.sqrt(np.mean(off[later] ** 2))), "largest": float(off[later].max())},
        "knee_error_m": {"largest": float(np.linalg.norm(record.elbow - knees, axis=1)[later].max())},
        "largest_joint_speed_rad_s": float(np.abs(record.v[later]).max()),
        "largest_torque_N_m": float(np.abs(record.torque[later]).max()),
        "least_knee_bend_deg": float(np.rad2deg(np.abs(record.q[later, 3] - limb.packed.elbow.straight).min())),
    }
    progress(0.4)
    rows = _null_power(limb, 1 if short else TASKS, progress)
    figures["null_space_share_of_power"] = {
        f"{offset:g} deg": {"median": float(np.median(values)), "least": float(values.min())}
        for offset, values in zip(OFFSETS, rows.T, strict=True)
    }
    figures["geometrical_is_least_in"] = int((rows.argmin(axis=1) == 0).sum())
    figures["tasks"] = len(rows)
    progress(1.0)
    return Outcome(figures, lambda: _draw(record, aims, knees, rows))


def _controller(limb: Arm) -> TorqueController:
    return TorqueController(limb, fractal(limb).ports, max_torque=np.inf)


def _plant(limb: Arm) -> Plant:
    return Plant(limb, damping=DAMPING, armature=ARMATURE, joint_limits=False, effort_limits=False)


def _walk(limb: Arm, seconds: float) -> tuple[Record, Array, Array]:
    """The motion, and where toes and knee ought to be at its samples."""
    phases = [*(s.phase for s in SNAPSHOTS), 1.0]
    table = np.array([[s.leg_angle_deg, s.extension, s.force_angle_deg] for s in SNAPSHOTS])
    cycle = CubicSpline(phases, np.vstack([table, table[:1]]), bc_type="periodic")
    longest = limb.limb.upper_arm + limb.limb.forearm

    def task(t: float) -> tuple[Task, Tie]:
        leg, extension, lean = cycle(t / CYCLE % 1.0)
        # Between two straight snapshots the curve would leave the reach.
        extension, leg, lean = min(float(extension), 1.0), np.deg2rad(leg), np.deg2rad(lean)
        f, v = np.array([-np.sin(lean), 0.0, np.cos(lean)]), np.array([np.cos(lean), 0.0, np.sin(lean)])
        ankle = limb.limb.shoulder + extension * longest * np.array([np.sin(leg), 0.0, -np.cos(leg)])
        return Task(ankle + limb.limb.hand * v, v, f, v, np.cross(v, f)), "upper" if leg >= 0.0 else "lower"

    plant, controller = _plant(limb), _controller(limb)
    first, tie = task(0.0)
    found = controller.set_task(first, respect_limits=False, tie=tie)
    plant.reset(found.q)
    aims, knees, ticks = [], [], 0

    def follow(t: float) -> None:
        nonlocal ticks
        if ticks % 4 == 0:
            now, tie = task(t)
            controller.set_task(now, restart=False, respect_limits=False, tie=tie)
            aims.append(now.position)
            knees.append(controller.elbow_target)
        ticks += 1

    record = simulate(plant, controller, seconds, target=follow, every=4)
    return record, np.array(aims), np.array(knees)


def _null_power(limb: Arm, count: int, progress: Progress) -> Array:
    """(tasks, offsets) share of the ports' power that is in the null space of the hand's velocity.

    The torque is split by the pseudo-inverse of the linear Jacobian Jp: what does work on the hand, and the rest.
    """
    rng = np.random.default_rng(SEED)
    rows: list[list[float]] = []
    while len(rows) < count:
        v, f = (d[0] for d in task_directions(rng, 1))
        middle = limb.limb.shoulder + ball(rng, 1, 0.7 * reach(limb))[0]
        tasks = [Task(middle + s * WAY * v, v, f) for s in (-0.5, 0.5)]
        solved = [limb.solve_task(task, respect_limits=False) for task in tasks]
        if all(solved):
            rows.append([_share(limb, tasks, offset) for offset in OFFSETS])
            progress(0.4 + 0.6 * len(rows) / count)
    return np.array(rows)


def _share(limb: Arm, tasks: list[Task], offset: float) -> float:
    plant, controller = _plant(limb), _controller(limb)
    first, last = (np.asarray(task.position) for task in tasks)
    v, f = np.asarray(tasks[0].velocity), np.asarray(tasks[0].force)

    def aim(s: float, restart: bool) -> Array:
        found = limb.solve_task(Task(first + s * (last - first), v, f), respect_limits=False)
        T = found.T_base_tip
        angle = limb.arm_angle(found.q) + np.deg2rad(offset)
        q = limb.solve(T, arm_angle=angle, seed=seed, respect_limits=False).q
        controller.set_posture(q, restart=restart)
        return q

    seed = np.zeros(7)
    seed = aim(0.0, True)
    plant.reset(seed)
    ticks = 0

    def follow(t: float) -> None:
        nonlocal seed, ticks
        if ticks % 16 == 0:
            seed = aim(float(minimum_jerk([t / LASTING])[0]), False)
        ticks += 1

    record = simulate(plant, controller, LASTING, target=follow, every=16)
    J = limb.jacobian_batch(record.q)[:, :3]
    along = np.einsum("nij,njk,nk->ni", np.linalg.pinv(J), J, record.v)
    torque = record.torque - record.weight
    in_task, rest = np.sum(torque * along, axis=1), np.sum(torque * (record.v - along), axis=1)
    return float(np.abs(rest).sum() / (np.abs(rest).sum() + np.abs(in_task).sum()))


def _draw(record: Record, aims: Array, knees: Array, rows: Array) -> Figure:
    figure = new_figure(12.0, 4.6)
    left, right = figure.subplots(1, 2)
    left.plot(*aims[:, ::2].T, color="0.6", linewidth=3.0, label="toes: target")
    left.plot(*record.tip[:, ::2].T, color="#16456e", linewidth=1.0, label="toes")
    left.plot(*knees[:, ::2].T, color="#ecc875", linewidth=3.0, label="knee: target")
    left.plot(*record.elbow[:, ::2].T, color="#b5541c", linewidth=1.0, label="knee")
    left.set(xlabel="x, forward (m)", ylabel="z (m)")
    left.set_aspect("equal")
    left.legend(fontsize=8)
    right.boxplot([100.0 * column for column in rows.T], tick_labels=[f"{offset:g}" for offset in OFFSETS])
    right.set_xlabel("arm angle from that of the geometrical posture (deg)")
    right.set_ylabel("share of the ports' power in the null space (%)")
    return figure
