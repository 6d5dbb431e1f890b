"""Energy that controllers put in, what it costs to project nothing, and the time of a tick."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from srs_ik.control import ForceProfile
from srs_ik.control.profile import Law
from srs_ik.paper.experiments.control.setting import ELBOW, PUBLISHED_TIP, TIP, fractal, home, make, near_home
from srs_ik.paper.experiments.setting import SEED, Outcome, Progress, directions
from srs_ik.plots.figure import new_figure
from srs_ik.sim import Plant, simulate
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from srs_ik.arm import Arm


class Audit(NamedTuple):
    """What is audited."""

    tip: ForceProfile = TIP
    law: Law = "A"
    rate: float = 4000.0
    delay: float = 0.0
    per_axis: bool = False


AUDITED = {
    "tanh, law A, 4 kHz": Audit(),
    "tanh, law A, per axis, 4 kHz": Audit(per_axis=True),
    "tanh, law A, 1 kHz": Audit(rate=1000.0),
    "tanh, law A, 250 Hz": Audit(rate=250.0),
    "tanh, law A, 4 kHz, 5 ms late": Audit(delay=0.005),
    "tanh, law B, 4 kHz": Audit(law="B"),
    "published, law A, 4 kHz": Audit(PUBLISHED_TIP),
    "published, law B, 4 kHz": Audit(PUBLISHED_TIP, "B"),
    "bare spring, 4 kHz": Audit(law="spring"),
}

STARTED = 0.062
"""Distance of the target at the start, m: just beyond the knee of the published profile."""

STIFFNESSES = (0.0, 100.0, 300.0, 1000.0, 3000.0)
"""Of the elbow, N/m."""

MISPLACED = 0.03
"""How far the elbow's target is off its circle, m: a conflict that no posture resolves."""

JUMPS = 10
"""Postures in which the arm angle jumps."""

TICKS = 5000


def passivity(arm: Arm, progress: Progress, short: bool = False) -> Outcome:
    """Energy beyond that of the profiles at the start, of an arm without damping let go 62 mm from its target.

    Injected at a time: kinetic energy, and that of the profiles, less that of the profiles U0 at the start; its largest
    value is given as a share of U0. The weight is held, and takes no part. A passive controller injects nothing.
    """
    count = 2 if short else 20
    figures: dict[str, Any] = {"injected_share_of_U0": {}}
    curves: dict[str, tuple[Array, Array]] = {}
    for i, (name, audit) in enumerate(AUDITED.items()):
        shares, curves[name] = _audit(arm, audit, count, 0.2 if short else 1.5)
        figures["injected_share_of_U0"][name] = {"mean": float(shares.mean()), "worst": float(shares.max())}
        progress(0.6 * (i + 1) / len(AUDITED))
    figures["price"] = _price(arm, 0.5 if short else 3.0)
    progress(0.9)
    figures["microseconds_a_tick"] = {
        kind: _tick(arm, make(kind, arm), 50 if short else TICKS)
        for kind in ("per_axis", "radial", "operational", "linear", "joint")
    }
    figures["processor_seconds_for_10_s_at_4_kHz"] = _ten_seconds(arm, 0.1 if short else 10.0)
    progress(1.0)
    return Outcome(figures, lambda: _draw(figures, curves))


def _audit(arm: Arm, audit: Audit, count: int, seconds: float) -> tuple[Array, tuple[Array, Array]]:
    rng = np.random.default_rng(SEED)
    plant = Plant(arm, damping=0.0, effort_limits=False)
    controller = fractal(arm, audit.per_axis, audit.law, tip=audit.tip, limits=False)
    shares = np.empty(count)
    example = (np.zeros(1), np.zeros(1))
    for i in range(count):
        q = near_home(arm, rng)
        plant.reset(q)
        T = arm.forward_kinematics(q).homogeneous
        T[:3, 3] += STARTED * directions(rng, 1)[0]
        controller.set_target(T, seed=q)
        record = simulate(plant, controller, seconds, rate=audit.rate, delay=audit.delay)
        injected = (record.kinetic + record.stored) / record.stored[0] - 1.0
        shares[i] = max(0.0, float(injected.max()))
        if i == 0:
            example = (record.t, injected)
    return shares, example


def _price(arm: Arm, seconds: float) -> dict[str, Any]:
    """Tip error against the stiffness of the elbow: at rest in a conflict, and while the arm angle is told to jump.

    Beside it the largest tip error of operational space for the same jumps of the arm angle, in its null space; of
    jumps the median over some postures.
    """
    q = home(arm)
    rows = []
    for stiffness in STIFFNESSES:
        elbow = ForceProfile.tanh(stiffness, ELBOW.largest) if stiffness else None
        rows.append(
            {
                "elbow_N_m": stiffness,
                "misplaced_tip_error_m": _misplaced(arm, elbow, q, seconds),
                "largest_tip_error_in_a_jump_m": _jump(arm, fractal(arm, elbow=elbow), seconds, elbow is not None),
            }
        )
    projected = _jump(arm, make("operational", arm), seconds, True)
    return {"superposed": rows, "operational_space_largest_tip_error_in_a_jump_m": projected}


def _misplaced(arm: Arm, elbow: ForceProfile | None, q: Array, seconds: float) -> float:
    """Tip error at rest with the target of the elbow 30 mm farther from the shoulder than it can be."""
    plant, controller = Plant(arm, damping=1.0), fractal(arm, elbow=elbow)
    plant.reset(q)
    controller.set_posture(q)
    if elbow is not None:
        away = controller.elbow_target - arm.limb.shoulder
        controller.set_elbow(controller.elbow_target + MISPLACED * away / np.linalg.norm(away) + [0.0, MISPLACED, 0.0])
    record = simulate(plant, controller, seconds, every=40)
    return float(record.errors(arm.forward_kinematics(q).homogeneous)[0][-1])


def _jump(arm: Arm, controller: Any, seconds: float, holds_arm_angle: bool) -> float:
    rng, plant, largest = np.random.default_rng(SEED), Plant(arm, damping=0.5), []
    for _ in range(JUMPS if seconds > 1.0 else 1):
        q = near_home(arm, rng)
        T = arm.forward_kinematics(q).homogeneous
        plant.reset(q)
        controller.set_target(T, arm_angle=arm.arm_angle(q) + 0.5 if holds_arm_angle else None, seed=q)
        largest.append(float(simulate(plant, controller, seconds / 3.0, every=4).errors(T)[0].max()))
    return float(np.median(largest))


def _tick(arm: Arm, controller: Any, count: int) -> float:
    """Median time of `torque` over random states."""
    rng = np.random.default_rng(SEED)
    q, v = rng.uniform(-1.0, 1.0, (count, 7)), rng.normal(size=(count, 7))
    taken = np.empty(count)
    for i in range(count):
        begin = time.perf_counter_ns()
        controller.torque(q[i], v[i])
        taken[i] = 1e-3 * (time.perf_counter_ns() - begin)
    return float(np.median(taken))


def _ten_seconds(arm: Arm, seconds: float) -> float:
    """Processor time of a simulation that records every tick."""
    plant, controller = Plant(arm), fractal(arm)
    plant.reset(home(arm))
    controller.set_posture(home(arm) + 0.1)
    begin = time.process_time()
    simulate(plant, controller, seconds)
    return time.process_time() - begin


_DRAWN = {
    "tanh, law A, 4 kHz": "#16456e",
    "tanh, law A, 4 kHz, 5 ms late": "#6fa8d6",
    "published, law A, 4 kHz": "#e64c33",
    "published, law B, 4 kHz": "#e9a23b",
    "bare spring, 4 kHz": "0.5",
}


def _draw(figures: dict[str, Any], curves: dict[str, tuple[Array, Array]]) -> Figure:
    figure = new_figure(12.0, 4.4)
    axes = figure.add_subplot(1, 2, 1)
    for name, colour in _DRAWN.items():
        t, injected = curves[name]
        axes.semilogy(t, 100.0 * (1.0 + injected), color=colour, linewidth=1.2, label=name)
    axes.set_ylim(bottom=0.1)
    axes.axhline(100.0, color="black", linewidth=0.8, linestyle=":")
    axes.set_xlabel("time (s)")
    axes.set_ylabel("kinetic energy and that of the profiles (% of U0)")
    axes.legend(fontsize=7)
    axes = figure.add_subplot(1, 2, 2)
    rows = figures["price"]["superposed"]
    x = [row["elbow_N_m"] for row in rows]
    for key, style, label in (
        ("misplaced_tip_error_m", "o-", "at rest, elbow's target 30 mm off its circle and aside"),
        ("largest_tip_error_in_a_jump_m", "s--", "largest while the arm angle jumps by 0.5 rad"),
    ):
        axes.plot(x, [1e3 * row[key] for row in rows], style, label=label)
    projected = figures["price"]["operational_space_largest_tip_error_in_a_jump_m"]
    axes.axhline(
        1e3 * projected, color="#b5541c", linestyle=":", label="the jump in the null space of operational space"
    )
    axes.set_xscale("symlog", linthresh=100.0)
    axes.set_xlim(left=-5.0)
    axes.set_xlabel("stiffness of the elbow (N/m)")
    axes.set_ylabel("tip error (mm)")
    axes.legend(fontsize=7)
    return figure
