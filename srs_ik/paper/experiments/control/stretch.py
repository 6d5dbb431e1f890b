"""Through the straight elbow and beyond the reach, and back; and targets that the joint limits forbid."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy.optimize import minimize

from srs_ik.control import FractalImpedance, TorqueController
from srs_ik.control.planners import minimum_jerk
from srs_ik.paper.experiments.control.setting import COLOURS, DAMPING, NAMES, TIP, fractal, home, make, near_home
from srs_ik.paper.experiments.setting import SEED, Outcome, Progress, directions
from srs_ik.plots.figure import new_figure
from srs_ik.sim import Plant, Record, simulate
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from srs_ik.arm import Arm

OWN = {"per_axis": 20, "radial": 20}
ALL = {**OWN, "braked": 20, "linear": 5, "operational": 5, "operational_pinv": 5, "joint": 5}
"""Seeds of each controller."""


class Motion(NamedTuple):
    """How the target moves."""

    far: float  # farthest target, in distances from shoulder to wrist with the elbow straight
    out: float  # seconds on the way out, and again on the way back
    runs: dict[str, int]  # seeds by controller


MOTIONS = {
    "to the reach, 2 s": Motion(1.0, 2.0, OWN),
    "beyond it, 4 s": Motion(1.05, 4.0, OWN),
    "beyond it, 2 s": Motion(1.05, 2.0, ALL),
}
DRAWN = "beyond it, 2 s"

STAY, HOME = 0.5, 1.0
"""Seconds at the far end, and at home."""

FAST, FLIP = 3.0, 1.0
"""A joint speed, rad/s, and a change of the arm angle between start and end, rad, that a stretch should stay below."""

TARGETS, SETTLED = 12, 16.0
"""Targets that are forbidden, and seconds until the tip is looked at: at the end of the reach it slides slowly."""

CLOSE = 2e-3
"""A tip this much farther from its target than it has to be, m, is as near as can be: MuJoCo's limits are soft."""


def stretch(arm: Arm, progress: Progress, short: bool = False) -> Outcome:
    """The target moves away from the shoulder, straight out through the reach and back, its turn unchanged."""
    figures: dict[str, Any] = {"stretch": {name: {} for name in MOTIONS}}
    shown: dict[str, Record] = {}
    done, total = 0.0, sum(motion.out * sum(motion.runs.values()) for motion in MOTIONS.values())
    for name, motion in MOTIONS.items():
        for kind, count in motion.runs.items():
            found = _stretched(arm, kind, motion, 1 if short else count, 0.05 if short else 1.0)
            figures["stretch"][name][kind], record = found
            if name == DRAWN:
                shown[kind] = record
            done += motion.out * count
            progress(0.8 * done / total)
    figures["forbidden"] = _forbidden(arm, 2 if short else TARGETS, 2 if short else 12, 0.3 if short else SETTLED)
    progress(1.0)
    return Outcome(figures, lambda: _draw(figures, shown))


def _stretched(arm: Arm, kind: str, motion: Motion, count: int, slowness: float) -> tuple[dict[str, Any], Record]:
    rng = np.random.default_rng(SEED)
    plant, controller = Plant(arm, damping=DAMPING), make(kind, arm)
    rows, example = [], None
    for _ in range(count):
        q = near_home(arm, rng, 0.15)
        record, away = _one(arm, plant, controller, q, motion, slowness)
        turned = abs((arm.arm_angle(record.q[-1]) - arm.arm_angle(q) + np.pi) % (2.0 * np.pi) - np.pi)
        speed = float(np.abs(record.v).max())
        bent = (record.q[-1, 3] - arm.packed.elbow.straight) * (q[3] - arm.packed.elbow.straight)
        rows.append([speed, away, turned, np.abs(record.torque).max(), float(turned > FLIP or bent < 0.0)])
        example = example or record
    assert example is not None
    table = np.array(rows)
    return {
        "seeds": count,
        "below_3_rad_s": int((table[:, 0] <= FAST).sum()),
        "flips": int(table[:, 4].sum()),
        "largest_joint_speed_rad_s": {"median": float(np.median(table[:, 0])), "worst": float(table[:, 0].max())},
        "largest_torque_N_m": float(table[:, 3].max()),
        "tip_error_at_home_m": {"median": float(np.median(table[:, 1])), "worst": float(table[:, 1].max())},
        "arm_angle_change_rad": float(table[:, 2].max()),
    }, example


def _one(arm: Arm, plant: Plant, controller: Any, q: Array, motion: Motion, slowness: float) -> tuple[Record, float]:
    T = arm.forward_kinematics(q).homogeneous
    wrist = T[:3, :3] @ (np.linalg.inv(arm.limb.T_base_tip_zero) @ np.append(arm.limb.wrist, 1.0))[:3] + T[:3, 3]
    out = wrist - arm.limb.shoulder
    near = float(np.linalg.norm(out))
    far = motion.far * (arm.limb.upper_arm + arm.limb.forearm)
    length = slowness * motion.out
    times = np.cumsum([length, slowness * STAY, length, slowness * HOME])
    psi = arm.arm_angle(q)
    plant.reset(q)
    controller.set_target(T, arm_angle=psi, seed=q)
    seed, ticks = q, 0

    def move(t: float) -> None:
        nonlocal seed, ticks
        ticks += 1
        if ticks % 4 != 1 or t > times[2] + 0.01:
            return
        share = minimum_jerk([t / length])[0] - minimum_jerk([(t - times[1]) / length])[0]
        aim = T.copy()
        aim[:3, 3] += share * (far - near) / near * out
        options = {"restart": False} if isinstance(controller, TorqueController) else {}
        seed = controller.set_target(aim, arm_angle=psi, seed=seed, **options).q

    record = simulate(plant, controller, float(times[-1]), target=move, every=4)
    return record, float(record.errors(T)[0][-1])


def _forbidden(arm: Arm, count: int, starts: int, seconds: float) -> dict[str, Any]:
    """How much farther from a target the tip stays than it would have to, where limits or reach forbid it.

    Targets of the tip point alone: half of them beyond the reach, half around the shoulder, where the elbow's limit
    ends the way. In the radial form, and axis by axis, where another sum is least. The least distance within the
    limits is that of SciPy's L-BFGS-B from 12 starts.
    """
    rng = np.random.default_rng(SEED)
    reach = arm.limb.upper_arm + arm.limb.forearm + arm.limb.hand
    lower, upper = np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi)
    alone = [FractalImpedance("tip", TIP)]
    kinds = {
        "tip_alone": TorqueController(arm, alone),
        "tip_alone_per_axis": TorqueController(arm, [FractalImpedance("tip", TIP, per_axis=True)]),
        "tip_and_repelling_limits": TorqueController(arm, alone, limits=True),
        "all_ports": fractal(arm, per_axis=False),
    }
    more: dict[str, list[float]] = {kind: [] for kind in kinds}
    least = []
    for i in range(count):
        distance = 1.15 * reach if i % 2 else 0.15 * reach
        T = arm.forward_kinematics(home(arm)).homogeneous
        T[:3, 3] = arm.limb.shoulder + distance * directions(rng, 1)[0]
        least.append(_least_distance(arm, T[:3, 3], lower, upper, rng.uniform(lower, upper, (starts, 7))))
        for kind, controller in kinds.items():
            plant = Plant(arm, damping=DAMPING)
            plant.reset(home(arm))
            controller.set_target(T, seed=home(arm))
            record = simulate(plant, controller, seconds, every=40)
            more[kind].append(float(record.errors(T)[0][-1]) - least[-1])
    return {
        "targets": count,
        "least_distance_m": least,
        **{
            kind: {
                "median_farther_m": float(np.median(values)),
                "worst_farther_m": float(max(values)),
                "within_2_mm": int(sum(value < CLOSE for value in values)),
            }
            for kind, values in more.items()
        },
    }


def _least_distance(arm: Arm, point: Array, lower: Array, upper: Array, starts: Array) -> float:
    def squared(q: Array) -> tuple[float, Array]:
        off = arm.forward_kinematics(q).translation - point
        return float(off @ off), 2.0 * arm.jacobian(q)[:3].T @ off

    found = [
        minimize(squared, q, jac=True, method="L-BFGS-B", bounds=list(zip(lower, upper, strict=True))) for q in starts
    ]
    return float(np.sqrt(min(result.fun for result in found)))


def _draw(figures: dict[str, Any], shown: dict[str, Record]) -> Figure:
    figure = new_figure(12.0, 4.6)
    left, right = figure.subplots(1, 2)
    left.set_title(f"out {DRAWN}, and back in as long: all seeds", fontsize=10)
    right.set_title("one of the seeds", fontsize=10)
    for kind, record in shown.items():
        found = figures["stretch"][DRAWN][kind]
        speed = found["largest_joint_speed_rad_s"]["worst"]
        label = f"{NAMES[kind]}: {speed:.1f} rad/s at most, {found['flips']} of {found['seeds']} flip"
        left.semilogy(
            record.t, np.maximum(np.abs(record.v).max(axis=1), 1e-4), color=COLOURS[kind], linewidth=1.0, label=label
        )
        right.plot(record.t, np.rad2deg(record.q[:, 3]), color=COLOURS[kind], linewidth=1.0, label=NAMES[kind])
    left.axhline(FAST, color="black", linewidth=0.8, linestyle=":")
    left.set(xlabel="time (s)", ylabel="fastest joint (rad/s)")
    right.set(xlabel="time (s)", ylabel="elbow (deg)")
    left.legend(fontsize=7)
    right.legend(fontsize=7)
    return figure
