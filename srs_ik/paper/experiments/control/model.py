"""Whether the plant is the arm: MuJoCo's mass matrix, bias torques and free fall against Pinocchio's."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from srs_ik.loading import load
from srs_ik.paper.experiments.control.setting import home
from srs_ik.paper.experiments.setting import SEED, Outcome, Progress
from srs_ik.plots.figure import new_figure
from srs_ik.sim import Plant
from srs_ik.sim.plant import TIMESTEP
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from srs_ik.arm import Arm

OTHERS = ("iiwa14", "gen3", "human_arm")
LINES = ("-", "--", ":", "-.")


def model(arm: Arm, progress: Progress, short: bool = False) -> Outcome:
    """M and h at random states, relative to their largest entry, and the difference after a second of free fall.

    The fall is without damping and joint limits, by the method of Runge and Kutta of order 4 in both programs. An arm
    with links of no mass has no acceleration where the axes about them are in line, and no fall to compare there.
    """
    arms = {arm.name: arm} | {name: load(name) for name in OTHERS if name != arm.name}
    figures: dict[str, Any] = {}
    falls: dict[str, Array] = {}
    for i, (name, one) in enumerate(arms.items()):
        figures[name] = _agreement(one, 10 if short else 200)
        falls[name] = _fall(one, 0.1 if short else 1.0)
        figures[name]["fall_difference_rad"] = float(falls[name][:, 1].max())
        figures[name]["fallen_rad"] = float(falls[name][-1, 2])
        progress((i + 1) / len(arms))
    return Outcome(figures, lambda: _draw(falls))


def _agreement(arm: Arm, count: int) -> dict[str, Any]:
    rng, plant, data = np.random.default_rng(SEED), Plant(arm), arm.model.createData()
    worst = np.zeros(2)
    for _ in range(count):
        q, v = rng.uniform(-2.0, 2.0, 7), rng.normal(size=7)
        plant.reset(q, v)
        c = arm.configuration(q)
        M = pin.crba(arm.model, data, c)
        M = np.triu(M) + np.triu(M, 1).T
        h = pin.nonLinearEffects(arm.model, data, c, v)
        off = np.abs(plant.mass_matrix - M).max() / np.abs(M).max(), np.abs(plant.bias - h).max() / np.abs(h).max()
        worst = np.maximum(worst, off)
    return {"read_from": plant.source, "states": count, "M": worst[0], "h": worst[1]}


def _fall(arm: Arm, seconds: float) -> Array:
    """(n, 3) time, largest difference and largest way of a joint, rad."""
    plant = Plant(arm, damping=0.0, friction=0.0, joint_limits=False)
    plant.fall_exactly()
    q, v = home(arm), np.zeros(7)
    plant.reset(q)
    data, start, dt = arm.model.createData(), q.copy(), TIMESTEP
    rows = []
    zero = np.zeros(7)

    def acceleration(q: Array, v: Array) -> Array:
        return np.array(pin.aba(arm.model, data, arm.configuration(q), v, zero))

    for k in range(round(seconds / dt)):
        a1 = acceleration(q, v)
        a2 = acceleration(q + 0.5 * dt * v, v + 0.5 * dt * a1)
        a3 = acceleration(q + 0.5 * dt * (v + 0.5 * dt * a1), v + 0.5 * dt * a2)
        a4 = acceleration(q + dt * (v + 0.5 * dt * a2), v + dt * a3)
        q = q + dt * v + dt**2 / 6.0 * (a1 + a2 + a3)
        v = v + dt / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
        plant.step(zero)
        if k % 20 == 19:
            rows.append([(k + 1) * dt, np.abs(plant.q - q).max(), np.abs(q - start).max()])
    return np.array(rows)


def _draw(falls: dict[str, Array]) -> Figure:
    figure = new_figure(8.0, 4.2)
    axes = figure.add_subplot()
    for (name, fall), style in zip(falls.items(), LINES, strict=False):
        axes.semilogy(fall[:, 0], np.maximum(fall[:, 1], 1e-17), style, label=name)
    axes.axhline(1e-6, color="black", linewidth=0.8, label="1e-6 rad")
    axes.set_xlabel("time of a free fall (s)")
    axes.set_ylabel("largest difference of a joint angle (rad)")
    axes.legend(fontsize=8)
    return figure
