"""A wall in the way of the target, a peg in the way of the arm, and payloads that no controller knows of."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from srs_ik.paper.experiments.control.setting import COLOURS, DAMPING, NAMES, home, make, near_home, settled
from srs_ik.paper.experiments.setting import SEED, Outcome, Progress
from srs_ik.plots.figure import new_figure
from srs_ik.sim import Payload, Peg, Plant, Record, Wall, World, simulate
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from srs_ik.arm import Arm

KINDS = ("per_axis", "braked", "linear", "operational", "joint")
BEHIND = 0.05
"""How far behind the wall the target lies, m."""

GAP = 0.05
"""From the ball at the tip to the wall at the start, m."""

POSTURES = 5
"""At which the arm begins: home, and around it."""

MASSES = (0.5, 1.0, 2.0, 3.0)
"""kg."""

TURN = 0.7
"""Of joint 1 to the target behind the peg, rad."""


def contact(arm: Arm, progress: Progress, short: bool = False) -> Outcome:
    """Peak and lasting force, where the tip stays, and how it goes back (medians); the sag under a payload."""
    seconds = 0.3 if short else 2.0
    rng = np.random.default_rng(SEED)
    postures = [home(arm), *(near_home(arm, rng) for _ in range(0 if short else POSTURES - 1))]
    figures: dict[str, Any] = {"postures": len(postures), "wall": {}, "peg": {}, "payload": {}}
    forces: dict[str, tuple[Array, Array]] = {}
    for i, kind in enumerate(KINDS):
        runs = [_wall(arm, kind, q, seconds) for q in postures]
        forces[kind] = (runs[0][0].t, np.linalg.norm(runs[0][0].contact, axis=1))
        figures["wall"][kind] = _medians([found for _, found in runs])
        progress((i + 0.4) / len(KINDS))
        figures["peg"][kind] = _medians([_peg(arm, kind, q, seconds) for q in postures])
        progress((i + 0.8) / len(KINDS))
        masses = MASSES[:1] if short else MASSES
        figures["payload"][kind] = {f"{mass:g} kg": _payload(arm, kind, mass, seconds) for mass in masses}
        progress((i + 1) / len(KINDS))
    return Outcome(figures, lambda: _draw(forces, figures))


def _medians(rows: list[dict[str, float]]) -> dict[str, float]:
    return {name: float(np.median([row[name] for row in rows])) for name in rows[0]}


def _wall(arm: Arm, kind: str, q: Array, seconds: float) -> tuple[Record, dict[str, float]]:
    T = arm.forward_kinematics(q).homogeneous
    world = World(walls=(Wall(T[:3, 3] - [0.0, 0.0, GAP + World().tip_radius], [0.0, 0.0, 1.0]),))
    plant, controller = Plant(arm, world, damping=DAMPING), make(kind, arm)
    plant.reset(q)
    target = T.copy()
    target[2, 3] -= GAP + BEHIND
    controller.set_target(target, seed=q)
    record = simulate(plant, controller, seconds)
    force = np.linalg.norm(record.contact, axis=1)
    last = record.t > record.t[-1] - 0.2
    controller.set_target(T, seed=q)
    back = simulate(plant, controller, seconds, every=4)
    return record, {
        "peak_N": float(force.max()),
        "lasting_N": float(force[last].mean()),
        "change_while_lasting_N": float(np.ptp(force[last])),
        "tip_above_the_wall_m": float((record.tip[last, 2] - (T[2, 3] - GAP)).mean()),
        "tip_error_after_return_m": float(back.errors(T)[0][-1]),
    }


def _peg(arm: Arm, kind: str, q: Array, seconds: float) -> dict[str, float]:
    """A post between the forearm and its target, on the way of joint 1; then back."""
    T = arm.forward_kinematics(q).homogeneous
    elbow, wrist = _points(arm, q)
    reach = 0.4 * (elbow - arm.limb.shoulder) + 0.6 * (wrist - arm.limb.shoulder)
    turn = 0.5 * TURN
    R = np.array([[np.cos(turn), -np.sin(turn), 0.0], [np.sin(turn), np.cos(turn), 0.0], [0.0, 0.0, 1.0]])
    foot = arm.limb.shoulder + R @ reach
    up = np.array([0.0, 0.0, 0.6])
    peg = Peg(foot - up, foot + up)
    plant, controller = Plant(arm, World(pegs=(peg,)), damping=DAMPING), make(kind, arm)
    plant.reset(q)
    turned = q.copy()
    turned[0] += TURN
    controller.set_target(arm.forward_kinematics(turned), seed=turned)
    record = simulate(plant, controller, seconds)
    force = np.linalg.norm(record.contact, axis=1)
    controller.set_target(T, seed=q)
    back = simulate(plant, controller, seconds, every=4)
    return {
        "peak_N": float(force.max()),
        "lasting_N": float(force[-400:].mean()),
        "largest_joint_speed_rad_s": float(np.abs(record.v).max()),
        "largest_torque_N_m": float(np.abs(record.torque).max()),
        "tip_error_after_return_m": float(back.errors(T)[0][-1]),
    }


def _points(arm: Arm, q: Array) -> tuple[Array, Array]:
    """Elbow and wrist centre at q."""
    from srs_ik.paper.experiments.measure import points

    elbow, wrist, _ = points(arm, q[None])
    return elbow[0], wrist[0]


def _payload(arm: Arm, kind: str, mass: float, seconds: float) -> dict[str, float]:
    q = home(arm)
    T = arm.forward_kinematics(q).homogeneous
    plant, controller = Plant(arm, World(payload=Payload(mass)), damping=DAMPING), make(kind, arm)
    plant.reset(q)
    controller.set_target(T, seed=q)
    record = simulate(plant, controller, 2.0 * seconds, every=4)
    sag = float(T[2, 3] - record.tip[-1, 2])
    return {"sag_m": sag, **settled(record, T)}


def _draw(forces: dict[str, tuple[Array, Array]], figures: dict[str, Any]) -> Figure:
    figure = new_figure(12.0, 4.4)
    axes = figure.add_subplot(1, 2, 1)
    for kind, (t, force) in forces.items():
        found = figures["wall"][kind]
        label = f"{NAMES[kind]}: median peak {found['peak_N']:.0f} N, then {found['lasting_N']:.0f} N"
        axes.plot(t, force, color=COLOURS[kind], linewidth=1.0, label=label)
    axes.set(xlabel="time (s)", ylabel="force on the wall (N)")
    axes.set_title("target 50 mm behind a wall, one of the postures", fontsize=10)
    axes.legend(fontsize=7)
    axes = figure.add_subplot(1, 2, 2)
    for kind, rows in figures["payload"].items():
        masses = [float(name.removesuffix(" kg")) for name in rows]
        axes.plot(masses, [1e3 * row["sag_m"] for row in rows.values()], "o-", color=COLOURS[kind], label=NAMES[kind])
    axes.set(xlabel="unknown payload (kg)", ylabel="sag of the tip (mm)")
    axes.legend(fontsize=7)
    return figure
