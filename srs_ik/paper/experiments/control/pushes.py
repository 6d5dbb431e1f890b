"""Pushes of 30 N for 0.3 s on tip and elbow: whether the arm comes back, and how far it went."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from srs_ik.paper.experiments.control.setting import COLOURS, DAMPING, NAMES, make, near_home, settled
from srs_ik.paper.experiments.setting import SEED, Outcome, Progress, directions
from srs_ik.plots.figure import new_figure
from srs_ik.sim import Plant, Push, Record, simulate
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from srs_ik.arm import Arm

FORCE, START, LENGTH, AFTER = 30.0, 0.1, 0.3, 2.0
BACK_M, BACK_DEG = 1e-3, 0.5

RUNS = {"per_axis": 100, "radial": 100, "spring": 20, "linear": 10, "operational": 10, "joint": 10}
"""Pushes of each controller, half on the tip and half on the elbow."""


def pushes(arm: Arm, progress: Progress, short: bool = False) -> Outcome:
    """Random directions, random postures around home; with the joint damping of the maker's file, and without any."""
    figures: dict[str, Any] = {"back_within": {"tip_m": BACK_M, "turn_deg": BACK_DEG, "s": AFTER}}
    shown: dict[str, tuple[Array, Array]] = {}
    done, total = 0, 2 * len(RUNS)
    for damping in (DAMPING, 0.0):
        for kind, count in RUNS.items():
            found, example = _pushed(arm, kind, damping, 2 if short else count, 0.05 if short else AFTER)
            figures[f"{kind}, damping {damping:g}"] = found
            shown[f"{kind} {damping:g}"] = example
            done += 1
            progress(done / total)
    return Outcome(figures, lambda: _draw(figures, shown))


def _pushed(
    arm: Arm, kind: str, damping: float, count: int, after: float
) -> tuple[dict[str, Any], tuple[Array, Array]]:
    rng = np.random.default_rng(SEED)
    plant, controller = Plant(arm, damping=damping), make(kind, arm)
    rows: list[dict[str, float]] = []
    example = (np.zeros(1), np.zeros(1))
    for i in range(count):
        q = near_home(arm, rng)
        plant.reset(q)
        controller.set_posture(q)
        push = Push(("tip", "elbow")[i % 2], FORCE * directions(rng, 1)[0], START, LENGTH)
        record: Record = simulate(plant, controller, START + LENGTH + after, pushes=[push], every=4)
        T = arm.forward_kinematics(q).homogeneous
        rows.append(settled(record, T))
        if i == 0:
            example = (record.t, record.errors(T)[0])
    table = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    back = (table["final_tip_error_m"] < BACK_M) & (table["final_turn_error_deg"] < BACK_DEG)
    return {
        "pushes": count,
        "back": int(back.sum()),
        **{name: {"median": float(np.median(v)), "worst": float(v.max())} for name, v in table.items()},
    }, example


def _draw(figures: dict[str, Any], shown: dict[str, tuple[Array, Array]]) -> Figure:
    figure = new_figure(12.0, 4.8)
    for column, damping in enumerate((DAMPING, 0.0), 1):
        axes = figure.add_subplot(1, 2, column)
        for kind in RUNS:
            found = figures[f"{kind}, damping {damping:g}"]
            t, away = shown[f"{kind} {damping:g}"]
            label = f"{NAMES[kind]}: {found['back']} of {found['pushes']} back"
            axes.semilogy(t, 1e3 * np.maximum(away, 1e-7), color=COLOURS[kind], linewidth=1.2, label=label)
        axes.axhline(1e3 * BACK_M, color="black", linewidth=0.8, linestyle=":")
        axes.axvspan(START, START + LENGTH, color="0.92")
        axes.set_title(f"joint damping {damping:g} N m s/rad; one push on the tip", fontsize=10)
        axes.set_xlabel("time (s)")
        axes.set_ylabel("distance of the tip from its target (mm)")
        axes.legend(fontsize=7)
    return figure
