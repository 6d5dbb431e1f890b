"""The law on one axis: its free response, the energy that reversals inject, and what rate and delay do."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from srs_ik.control import ForceProfile
from srs_ik.control.one_axis import free_response, sampled_response
from srs_ik.control.profile import Law
from srs_ik.paper.experiments.control.setting import PUBLISHED_ELBOW, PUBLISHED_TIP, SIMULATED_ELBOW, SIMULATED_TIP
from srs_ik.paper.experiments.setting import Outcome, Progress
from srs_ik.plots.figure import new_figure
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from srs_ik.arm import Arm

MASS, START = 3.0, 0.05
PROFILE = ForceProfile.tanh(1000.0, 50.0)
PROFILES = {
    "tanh": PROFILE,
    "published, tip": PUBLISHED_TIP,
    "published, elbow": PUBLISHED_ELBOW,
    "published simulation, tip": SIMULATED_TIP,
    "published simulation, elbow": SIMULATED_ELBOW,
}
LAWS: tuple[Law, Law] = ("A", "B")

RULE = 0.3
"""Largest w (T/2 + delay) at which the mass is expected to come to rest, rad."""

AT_REST = 1e-3
"""A mass that stays this close to its target, m, is at rest."""


def law(arm: Arm, progress: Progress, short: bool = False) -> Outcome:
    """A mass of 3 kg on a spring of 1,000 N/m that saturates at 50 N, 50 mm from its target; the arm plays no part."""
    stiffness, n = 1000.0, 2001
    w = np.sqrt(2.0 * stiffness / MASS)
    dt = float(np.pi / w / (n - 1))
    found = free_response(ForceProfile.saturated(stiffness, 1e6), MASS, START, dt, n)
    closed = 0.5 * START * (1.0 + np.cos(w * dt * np.arange(n)))
    speed = np.abs(np.diff(found)) / dt
    progress(0.1)
    periods = np.geomspace(2.5e-4, 0.05, 6 if short else 28)
    delays = np.linspace(0.0, 0.05, 6 if short else 26)
    rest, largest = np.empty((len(delays), len(periods))), np.empty((len(delays), len(periods)))
    for i, delay in enumerate(delays):
        for j, period in enumerate(periods):
            way = sampled_response(PROFILE, MASS, START, period, delay, 4.0 if short else 20.0)[:, 0]
            rest[i, j] = np.abs(way[-round(1.0 / period) :]).max()
            largest[i, j] = np.abs(way).max()
        progress(0.1 + 0.9 * (i + 1) / len(delays))
    allowed = w * (0.5 * periods[None] + delays[:, None]) <= RULE
    figures: dict[str, Any] = {
        "free_response_error_m": float(np.abs(found - closed).max()),
        "peak_over_mean_speed": float(speed.max() / speed.mean()),
        "injected_share": {
            name: {each: profile.injection(each) for each in LAWS} for name, profile in PROFILES.items()
        },
        "steepest_N_m": {name: profile.steepest for name, profile in PROFILES.items()},
        "rule": {
            "w_rad_s": float(w),
            "cases_within": int(allowed.sum()),
            "at_rest_within": int((rest[allowed] < AT_REST).sum()),
            "cases_beyond": int((~allowed).sum()),
            "at_rest_beyond": int((rest[~allowed] < AT_REST).sum()),
            "largest_way_m": float(largest.max()),
        },
        "period_s": periods,
        "delay_s": delays,
        "way_after_20_s_m": rest,
    }
    return Outcome(figures, lambda: _draw(found, closed, dt, periods, delays, rest, w))


def _draw(found: Array, closed: Array, dt: float, periods: Array, delays: Array, rest: Array, w: float) -> Figure:
    figure = new_figure(12.0, 7.6)
    axes = figure.add_subplot(2, 2, 1)
    t = 1e3 * dt * np.arange(len(found))
    axes.plot(t, 1e3 * found, color="#16456e", linewidth=3.0, label="law A on a linear spring")
    axes.plot(t, 1e3 * closed, color="#e9a23b", linestyle="--", label="half a cosine")
    axes.set_xlabel("time (ms)")
    axes.set_ylabel("error (mm)")
    axes.legend(fontsize=8)
    for column, (name, peak) in enumerate((("tanh", 0.08), ("published, tip", 0.0625)), 2):
        axes = figure.add_subplot(2, 2, column)
        e = np.linspace(0.0, peak, 400)
        profile = PROFILES[name]
        axes.plot(1e3 * e, profile.force(e), color="black", label="diverging")
        for each, style, colour in (("A", "-", "#16456e"), ("B", "--", "#b5541c")):
            axes.plot(1e3 * e, profile.converging_force(peak, e, each), style, color=colour, label=f"law {each}")  # type: ignore[arg-type]
        share = {each: 100.0 * profile.injection(each) for each in LAWS}
        axes.set_title(f"{name}: at most {share['A']:.3g} % injected with A, {share['B']:.3g} % with B", fontsize=10)
        axes.axhline(0.0, color="0.7", linewidth=0.8)
        axes.set_xlabel("error (mm)")
        axes.set_ylabel("force to the target (N)")
        axes.legend(fontsize=8)
    axes = figure.add_subplot(2, 2, 4)
    shown = axes.pcolormesh(
        1e3 * periods, 1e3 * delays, np.log10(np.maximum(1e3 * rest, 1e-3)), cmap="cividis", vmin=-3.0, vmax=3.0
    )
    figure.colorbar(shown, ax=axes, label="way in the last second, log10 (mm)")
    axes.plot(1e3 * periods, 1e3 * (RULE / w - 0.5 * periods), color="white", label="w (T/2 + delay) = 0.3")
    axes.set(xscale="log", xlabel="period (ms)", ylabel="delay (ms)", ylim=(0.0, 50.0))
    axes.legend(fontsize=8, facecolor="0.2", labelcolor="white")
    return figure
