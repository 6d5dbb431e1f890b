"""Human-likeness: one hundred movements of the paper's limb, told at once or planned in three ways."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from srs_ik.control import TorqueController
from srs_ik.control.planners import between, harmonic, minimum_jerk, passive_motion
from srs_ik.loading import load
from srs_ik.paper.experiments.control.setting import (
    DAMPING,
    fractal,
    home,
    moving,
    near_home,
    sparc,
    speed_peaks,
    straightness,
)
from srs_ik.paper.experiments.setting import SEED, Outcome, Progress
from srs_ik.plots.figure import new_figure
from srs_ik.sim import Plant, Record, simulate
from srs_ik.sim.plant import TIMESTEP
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from srs_ik.arm import Arm

LIMB = "human_arm"

ARMATURE = 0.005
"""Of each joint, kg m^2: two links of the shoulder have no mass of their own, and tables of segments leave out what
muscles add. Without it the mass matrix is singular where axes 1 and 3 are in line."""

MOVEMENTS, DURATION, SECONDS = 100, 0.8, 1.2
EVERY = 4
PLANS = {
    "none": "told at once",
    "minimum_jerk": "minimum jerk",
    "harmonic": "harmonic",
    "passive_motion": "passive motion",
}
COLOURS = {"none": "#e64c33", "minimum_jerk": "#16456e", "harmonic": "#e9a23b", "passive_motion": "#3f8f6b"}
DIRECTIONS = 12


def human(arm: Arm, progress: Progress, short: bool = False) -> Outcome:
    """Random movements of the human limb under fractal impedances; the arm named plays no part.

    One speed peak, a straight path, a peak speed of 1.875 times the mean (minimum jerk; 1.571 for the harmonic), R^2 of
    the speed against minimum jerk, the spectral arc length; and how much the arm angle at one target depends on where
    the hand came from.
    """
    limb = load(LIMB)
    rng = np.random.default_rng(SEED)
    pairs = [(near_home(limb, rng, 0.5), near_home(limb, rng, 0.5)) for _ in range(3 if short else MOVEMENTS)]
    figures: dict[str, Any] = {"plans": {}}
    speeds: dict[str, tuple[Array, Array]] = {}
    for i, plan in enumerate(PLANS):
        rows = []
        for start, end in pairs:
            record = _move(limb, start, end, plan)
            rows.append(_measures(limb, record, start, end))
            speeds.setdefault(plan, (record.t, record.speed))
        figures["plans"][plan] = {
            name: {
                "median": float(np.median([r[name] for r in rows])),
                "p90": float(np.quantile([r[name] for r in rows], 0.9)),
            }
            for name in rows[0]
        }
        figures["plans"][plan]["with_one_speed_peak"] = int(sum(row["speed_peaks"] == 1 for row in rows))
        progress(0.9 * (i + 1) / len(PLANS))
    s = np.linspace(0.0, 1.0, 1001)
    figures["R2_of_the_harmonic_itself"] = _r2(np.gradient(harmonic(s), s), np.gradient(minimum_jerk(s), s))
    figures["arm_angle_spread_deg"] = _donders(limb, 2 if short else DIRECTIONS)
    progress(1.0)
    return Outcome(figures, lambda: _draw(figures, speeds))


def _plant(limb: Arm) -> Plant:
    return Plant(limb, damping=DAMPING, armature=ARMATURE, effort_limits=False)


def _move(limb: Arm, start: Array, end: Array, plan: str) -> Record:
    plant, controller = _plant(limb), fractal(limb)
    controller = TorqueController(limb, controller.ports, limits=True, max_torque=np.inf)
    plant.reset(start)
    if plan == "none":
        controller.set_posture(end)
        return simulate(plant, controller, SECONDS, every=EVERY)
    controller.set_posture(start)
    count = round(DURATION * 250.0) + 1
    if plan == "passive_motion":
        postures = passive_motion(limb, start, limb.forward_kinematics(end), count)
    else:
        way = {"minimum_jerk": minimum_jerk, "harmonic": harmonic}[plan](np.linspace(0.0, 1.0, count))
        poses = between(limb.forward_kinematics(start), limb.forward_kinematics(end), way)
        first, last = limb.arm_angle(start), limb.arm_angle(end)
        turn = (last - first + np.pi) % (2.0 * np.pi) - np.pi
        postures, seed = np.empty((count, 7)), start
        for k, (T, s) in enumerate(zip(poses, way, strict=True)):
            seed = limb.solve(T, arm_angle=first + s * turn, seed=seed, respect_limits=False).q
            postures[k] = seed
    last_index = -1

    def follow(t: float) -> None:
        nonlocal last_index
        index = min(round(t * 250.0), count - 1)
        if index != last_index:
            controller.set_posture(postures[index], restart=False)
            last_index = index

    return simulate(plant, controller, SECONDS, target=follow, every=EVERY)


def _measures(limb: Arm, record: Record, start: Array, end: Array) -> dict[str, float]:
    dt = EVERY * TIMESTEP
    go = moving(record.speed)
    speed = record.speed[go]
    s = np.linspace(0.0, 1.0, len(speed))
    ideal = np.gradient(minimum_jerk(s), s)
    first, last = (limb.forward_kinematics(q) for q in (start, end))
    return {
        "speed_peaks": float(speed_peaks(record.speed, dt)),
        "off_the_line": straightness(record.tip, first.translation, last.translation),
        "peak_over_mean_speed": float(speed.max() / speed.mean()),
        "R2_with_minimum_jerk": _r2(speed / speed.mean(), ideal),
        "spectral_arc_length": sparc(speed, dt),
        "final_tip_error_m": float(record.errors(last.homogeneous)[0][-1]),
        "largest_torque_N_m": float(np.abs(record.torque).max()),
    }


def _r2(found: Array, ideal: Array) -> float:
    return float(1.0 - np.sum((found - ideal) ** 2) / np.sum((ideal - ideal.mean()) ** 2))


def _donders(limb: Arm, count: int) -> dict[str, float]:
    """Standard deviation of the arm angle at one target from many starts, with a port on the elbow and without."""
    rng = np.random.default_rng(SEED + 1)
    q = home(limb)
    spread = {}
    for name, ports in (("with_elbow", fractal(limb).ports), ("without_elbow", fractal(limb, elbow=None).ports)):
        angles = []
        for _ in range(count):
            plant = _plant(limb)
            controller = TorqueController(limb, ports, limits=True, max_torque=np.inf)
            plant.reset(near_home(limb, rng, 0.5))
            controller.set_posture(q)
            angles.append(limb.arm_angle(simulate(plant, controller, 2.0, every=100).q[-1]))
        spread[name] = float(np.rad2deg(np.std(np.unwrap(angles))))
    return spread


def _draw(figures: dict[str, Any], speeds: dict[str, tuple[Array, Array]]) -> Figure:
    figure = new_figure(12.0, 4.4)
    axes = figure.add_subplot(1, 2, 1)
    for plan, (t, speed) in speeds.items():
        axes.plot(t, speed, color=COLOURS[plan], linewidth=1.3, label=PLANS[plan])
    axes.set(xlabel="time (s)", ylabel="speed of the hand (m/s)")
    axes.set_title("one of the movements", fontsize=10)
    axes.legend(fontsize=8)
    axes = figure.add_subplot(1, 2, 2)
    names = ("speed_peaks", "peak_over_mean_speed", "R2_with_minimum_jerk", "off_the_line")
    labels = ("speed peaks", "peak over mean speed", "R² with\nminimum jerk", "off the line,\nshare of the way")
    for i, plan in enumerate(PLANS):
        values = [figures["plans"][plan][name]["median"] for name in names]
        axes.bar(np.arange(len(names)) + 0.2 * (i - 1.5), values, 0.18, color=COLOURS[plan], label=PLANS[plan])
    axes.set_xticks(range(len(names)), labels, fontsize=8)
    axes.axhline(1.0, color="0.7", linewidth=0.8, zorder=0)
    axes.set_ylabel("median of the movements (1)")
    axes.legend(fontsize=8)
    return figure
