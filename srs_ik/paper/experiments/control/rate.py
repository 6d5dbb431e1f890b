"""Rate and delay on the arm: where it comes to rest, with fractal impedances and with dampers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from srs_ik.paper.experiments.control.setting import DAMPING, ELBOW, NAMES, TIP, TURN, home, make
from srs_ik.paper.experiments.setting import Outcome, Progress
from srs_ik.plots.figure import new_figure
from srs_ik.sim import Plant, simulate
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from srs_ik.arm import Arm

RATES = (4000.0, 2000.0, 1000.0, 500.0, 250.0, 100.0, 50.0, 20.0)
DELAYS = (0.0, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05)
KINDS = ("per_axis", "radial", "linear", "joint")
RULE = 0.3
AT_REST = 1e-3
"""Tip error, m, in the last half second."""


def rate(arm: Arm, progress: Progress, short: bool = False) -> Outcome:
    """The target jumps by 50 mm, three seconds; the fastest frequency of the arm on its ports sets the rule."""
    rates, delays = (RATES[:3:2], DELAYS[:4:3]) if short else (RATES, DELAYS)
    w = fastest(arm)
    rest = {kind: np.full((len(delays), len(rates)), np.nan) for kind in KINDS}
    speed = {kind: np.full((len(delays), len(rates)), np.nan) for kind in KINDS}
    total, done = len(KINDS) * len(rates) * len(delays), 0
    for kind in KINDS:
        for i, delay in enumerate(delays):
            for j, hertz in enumerate(rates):
                rest[kind][i, j], speed[kind][i, j] = _run(arm, kind, hertz, delay, 0.5 if short else 3.0)
                done += 1
                progress(done / total)
    within = w * (0.5 / np.array(rates)[None] + np.array(delays)[:, None]) <= RULE
    figures: dict[str, Any] = {
        "w_rad_s": w,
        "rate_Hz": rates,
        "delay_s": delays,
        "cases_within_the_rule": int(within.sum()),
        **{
            kind: {
                "at_rest_within": int((rest[kind][within] < AT_REST).sum()),
                "at_rest": int((rest[kind] < AT_REST).sum()),
                "largest_joint_speed_rad_s": float(np.nanmax(speed[kind])),
                "tip_error_m": rest[kind],
            }
            for kind in KINDS
        },
    }
    return Outcome(figures, lambda: _draw(rest, rates, delays, w))


def fastest(arm: Arm) -> float:
    """Largest frequency of law A on the arm at home, rad/s: twice the stiffness of all ports on the mass matrix."""
    q = home(arm)
    J = arm.jacobian(q)
    step = 1e-6 * np.eye(7)
    elbow = np.stack([(_elbow(arm, q + s) - _elbow(arm, q - s)) / 2e-6 for s in step], axis=1)
    K = TIP.stiffness * J[:3].T @ J[:3] + TURN.stiffness * J[3:].T @ J[3:] + ELBOW.stiffness * elbow.T @ elbow
    M = pin.crba(arm.model, arm.model.createData(), arm.configuration(q))
    M = np.triu(M) + np.triu(M, 1).T
    return float(np.sqrt(2.0 * np.linalg.eigvals(np.linalg.solve(M, K)).real.max()))


def _elbow(arm: Arm, q: Array) -> Array:
    T = arm.joint_frames(q)[3] @ np.linalg.inv(arm.joint_frames(np.zeros(7))[3])
    return np.asarray(T[:3, :3] @ arm.limb.elbow + T[:3, 3])


def _run(arm: Arm, kind: str, hertz: float, delay: float, seconds: float) -> tuple[float, float]:
    """Largest tip error in the last half second, m, and largest joint speed, rad/s."""
    plant, controller = Plant(arm, damping=DAMPING), make(kind, arm)
    q = home(arm)
    plant.reset(q)
    T = arm.forward_kinematics(q).homogeneous
    T[1, 3] += 0.05
    controller.set_target(T, seed=q)
    record = simulate(plant, controller, seconds, rate=hertz, delay=delay)
    away = record.errors(T)[0]
    return float(away[record.t > record.t[-1] - 0.5].max()), float(np.abs(record.v).max())


def _draw(rest: dict[str, Array], rates: tuple[float, ...], delays: tuple[float, ...], w: float) -> Figure:
    figure = new_figure(12.0, 8.4)
    for place, kind in enumerate(KINDS, 1):
        axes = figure.add_subplot(2, 2, place)
        shown = axes.imshow(
            np.log10(np.maximum(1e3 * rest[kind], 1e-4)), cmap="cividis", vmin=-3, vmax=3, origin="lower", aspect="auto"
        )
        for (i, j), value in np.ndenumerate(rest[kind]):
            inside = w * (0.5 / rates[j] + delays[i]) <= RULE
            axes.text(
                j,
                i,
                f"{1e3 * value:.2g}",
                ha="center",
                va="center",
                fontsize=6,
                color="white" if value < 1e-3 else "black",
                weight="bold" if inside else "normal",
            )
        axes.set_xticks(range(len(rates)), [f"{hertz:g}" for hertz in rates], fontsize=7)
        axes.set_yticks(range(len(delays)), [f"{1e3 * delay:g}" for delay in delays], fontsize=7)
        axes.set_xlabel("rate (Hz)")
        axes.set_ylabel("delay (ms)")
        axes.set_title(NAMES[kind], fontsize=10)
    figure.colorbar(shown, ax=figure.axes, label="tip error after 3 s, log10 (mm)")
    return figure
