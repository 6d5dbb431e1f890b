"""What the experiments on torque control have in common: gains, postures, controllers, and how a motion is judged."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from srs_ik.control import ForceProfile, FractalImpedance, JointSpeeds, TorqueController
from srs_ik.control.baselines import Gains, JointImpedance, LinearImpedance, OperationalSpace
from srs_ik.control.profile import Law
from srs_ik.sim import Record
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.arm import Arm


DAMPING = 0.5
"""Of each joint, N m s/rad: the figure in the description of the iiwa 14 in drake_models. Our file has none."""

RATE = 4000.0
"""How often controllers are asked, where nothing else is said, Hz."""

TIP = ForceProfile.tanh(1000.0, 60.0)
TURN = ForceProfile.tanh(60.0, 12.0)
ELBOW = ForceProfile.tanh(600.0, 40.0)
"""A point stiffer than the published 800 N/m, a turn as published (60 N m/rad), and an elbow like the published one."""

PUBLISHED_TIP = ForceProfile.published(800.0, 100.0, 0.060, 0.080)
PUBLISHED_ELBOW = ForceProfile.published(630.0, 10.0, 0.010, 0.011)
"""Of the published experiments on hardware."""

SIMULATED_TIP = ForceProfile.published(5000.0, 150.0, 0.005, 0.006)
SIMULATED_ELBOW = ForceProfile.published(1000.0, 100.0, 0.010, 0.011)
"""Of the published simulation: config/lwr_control.yaml of the authors' program, under the licence BSD, at
github.com/wxmerkt/superimposition_of_passive_taskspace_controllers."""

NAMES = {
    "per_axis": "fractal, per axis",
    "radial": "fractal, radial",
    "braked": "fractal, radial, brakes",
    "spring": "bare springs",
    "linear": "springs and dampers",
    "operational": "operational space, damped inverse",
    "operational_pinv": "operational space, plain inverse",
    "joint": "joint impedance",
}
COLOURS = {
    "per_axis": "#16456e",
    "radial": "#6fa8d6",
    "braked": "#3f8f6b",
    "spring": "0.6",
    "linear": "#e9a23b",
    "operational": "#b5541c",
    "operational_pinv": "#e64c33",
    "joint": "#7a5195",
}


def fractal(
    arm: Arm,
    per_axis: bool = True,
    law: Law = "A",
    elbow: ForceProfile | None = ELBOW,
    tip: ForceProfile = TIP,
    limits: bool = True,
    speeds: bool = False,
) -> TorqueController:
    """Fractal impedances on the tip point, its turn, and the elbow; with brakes at the arm's own speeds, or without."""
    places = {"tip": tip, "orientation": TURN, "elbow": elbow}
    ports = [
        FractalImpedance(place, profile, law, per_axis, may_inject=True)  # type: ignore[arg-type]
        for place, profile in places.items()
        if profile is not None
    ]
    return TorqueController(arm, ports, limits=limits, speeds=JointSpeeds(rate=RATE) if speeds else None)


def make(kind: str, arm: Arm) -> Any:
    """A controller by its name in `NAMES`."""
    if kind == "per_axis":
        return fractal(arm)
    if kind == "radial":
        return fractal(arm, per_axis=False)
    if kind == "braked":
        return fractal(arm, per_axis=False, speeds=True)
    if kind == "spring":
        return fractal(arm, law="spring")
    if kind == "linear":
        return LinearImpedance(arm, Gains(joints=20.0))
    if kind == "joint":
        return JointImpedance(arm)
    return OperationalSpace(arm, inverse="pinv" if kind == "operational_pinv" else "damped")


def home(arm: Arm) -> Array:
    """A bent posture away from the limits."""
    q = np.array([0.0, 0.6, 0.0, -1.4, 0.0, 0.8, 0.0])
    room = np.minimum(0.3, 0.25 * (arm.upper - arm.lower))
    return np.clip(q, arm.lower + room, arm.upper - room)


def near_home(arm: Arm, rng: np.random.Generator, spread: float = 0.3) -> Array:
    """A posture around `home`."""
    room = np.minimum(0.2, 0.2 * (arm.upper - arm.lower))
    return np.clip(home(arm) + rng.uniform(-spread, spread, 7), arm.lower + room, arm.upper - room)


def settled(record: Record, T: Array) -> dict[str, float]:
    """How far a motion ended from its target, and how far it had been."""
    away, turned = record.errors(T)
    return {
        "largest_tip_error_m": float(away.max()),
        "final_tip_error_m": float(away[-1]),
        "final_turn_error_deg": float(np.rad2deg(turned[-1])),
        "largest_joint_speed_rad_s": float(np.abs(record.v).max()),
        "final_joint_speed_rad_s": float(np.abs(record.v[-1]).max()),
        "largest_torque_N_m": float(np.abs(record.torque).max()),
    }


def speed_peaks(speed: Array, dt: float) -> int:
    """Maxima of a speed above a tenth of the largest one, after a mean over 20 ms."""
    n = max(1, round(0.02 / dt))
    smooth = np.convolve(speed, np.full(n, 1.0 / n), mode="same")
    inner = (smooth[1:-1] > smooth[:-2]) & (smooth[1:-1] >= smooth[2:]) & (smooth[1:-1] > 0.1 * smooth.max())
    return int(inner.sum())


def moving(speed: Array, share: float = 0.05) -> slice:
    """The samples from the first to the last one with at least this share of the largest speed."""
    fast = np.flatnonzero(speed > share * speed.max())
    return slice(int(fast[0]), int(fast[-1]) + 1) if fast.size else slice(0, 0)


def sparc(speed: Array, dt: float) -> float:
    """Spectral arc length of a speed: the nearer to zero, the smoother; -1.4 or so for one smooth movement.

    Source: S. Balasubramanian et al., On the analysis of movement smoothness, J. NeuroEngineering 12, 2015.
    """
    n = 1 << int(np.ceil(np.log2(len(speed))) + 4)
    frequency = np.arange(n // 2) / (n * dt)
    spectrum = np.abs(np.fft.fft(speed, n))[: n // 2]
    spectrum /= spectrum.max()
    inside = np.flatnonzero((frequency <= 10.0) & (spectrum >= 0.05))
    f, s = frequency[: inside[-1] + 1], spectrum[: inside[-1] + 1]
    return float(-np.sum(np.hypot(np.diff(f) / f[-1], np.diff(s))))


def straightness(path: Array, start: Array, end: Array) -> float:
    """Largest distance of a path (n, 3) from the line between two points, over their distance."""
    line = (end - start) / np.linalg.norm(end - start)
    offset = path - start
    across = offset - np.outer(offset @ line, line)
    return float(np.linalg.norm(across, axis=1).max() / np.linalg.norm(end - start))
