"""The reaching clock: twelve targets around the hand, each told at once, for every controller."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from srs_ik.paper.experiments.control.setting import (
    COLOURS,
    DAMPING,
    NAMES,
    home,
    make,
    moving,
    settled,
    speed_peaks,
    straightness,
)
from srs_ik.paper.experiments.setting import Outcome, Progress
from srs_ik.plots.figure import new_figure
from srs_ik.sim import Plant, simulate
from srs_ik.sim.plant import TIMESTEP
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from srs_ik.arm import Arm

HOURS, DISTANCE, SECONDS = 12, 0.12, 2.0
KINDS = ("per_axis", "radial", "spring", "linear", "operational", "joint")
ARRIVED = 1e-3
"""Tip error, m, within which an arm has arrived for good."""


def reaching(arm: Arm, progress: Progress, short: bool = False) -> Outcome:
    """Targets 120 mm away in the plane across x, no plan between: what each law makes of a jump of its target."""
    hours = 2 if short else HOURS
    q = home(arm)
    T0 = arm.forward_kinematics(q).homogeneous
    figures: dict[str, Any] = {}
    paths: dict[str, list[Array]] = {}
    for i, kind in enumerate(KINDS):
        plant, controller = Plant(arm, damping=DAMPING), make(kind, arm)
        rows, paths[kind] = [], []
        for hour in range(hours):
            angle = 2.0 * np.pi * hour / HOURS
            T = T0.copy()
            T[:3, 3] += DISTANCE * np.array([0.0, np.cos(angle), np.sin(angle)])
            plant.reset(q)
            controller.set_target(T, seed=q)
            record = simulate(plant, controller, 0.3 if short else SECONDS, every=4)
            away = record.errors(T)[0]
            late = np.flatnonzero(away > ARRIVED)
            go = moving(record.speed)
            rows.append(
                {
                    **settled(record, T),
                    "arrival_s": float(record.t[late[-1]]) if late.size else 0.0,
                    "off_the_line": straightness(record.tip, T0[:3, 3], T[:3, 3]),
                    "speed_peaks": speed_peaks(record.speed, 4 * TIMESTEP),
                    "peak_over_mean_speed": float(record.speed.max() / record.speed[go].mean()),
                }
            )
            paths[kind].append(record.tip)
        figures[kind] = {
            name: {"median": float(np.median([r[name] for r in rows])), "worst": float(max(r[name] for r in rows))}
            for name in rows[0]
        }
        progress((i + 1) / len(KINDS))
    return Outcome(figures, lambda: _draw(paths, T0[:3, 3], figures))


def _draw(paths: dict[str, list[Array]], middle: Array, figures: dict[str, Any]) -> Figure:
    figure = new_figure(12.0, 8.0)
    for axes, kind in zip(figure.subplots(2, 3, sharex=True, sharey=True).flat, KINDS, strict=True):
        for path in paths[kind]:
            y, z = 1e3 * (path - middle)[:, 1:].T
            axes.plot(y, z, color=COLOURS[kind], linewidth=0.8)
        angle = 2.0 * np.pi * np.arange(len(paths[kind])) / HOURS
        axes.plot(1e3 * DISTANCE * np.cos(angle), 1e3 * DISTANCE * np.sin(angle), "k+", markersize=8)
        found = figures[kind]
        arrival = found["arrival_s"]["median"]
        when = f"within 1 mm after {arrival:.2f} s" if arrival < 0.99 * SECONDS else f"not there after {SECONDS:g} s"
        axes.set_title(
            f"{NAMES[kind]}\n{when}, {100.0 * found['off_the_line']['median']:.0f} % off the line", fontsize=9
        )
        axes.set_aspect("equal")
    for axes in figure.axes[3:]:
        axes.set_xlabel("y (mm)")
    for axes in figure.axes[::3]:
        axes.set_ylabel("z (mm)")
    return figure
