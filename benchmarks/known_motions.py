"""Motions that are known: joint angles inside the limits, as sums of two sines a joint."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import srs_ik

KINDS = ("aside", "cross", "limits", "singular")
BESIDE = Path(__file__).resolve().parents[2] / "shared" / "urdf"
OF_MAKERS = {
    "med7": "med7_lbr_stack",
    "openarm_left": "openarm_v10_bimanual",
    "openarm_right": "openarm_v10_bimanual",
    "sia10": "motoman_sia10f",
    "rm75": "realman_rm75",
    "j2s7s300": "kinova_j2s7s300",
    "h1_2_left": "unitree_h1_2_handless",
    "h1_2_right": "unitree_h1_2_handless",
}
"""Files of makers, used where they lie beside the checkout."""

WIDE = 1.5 * np.pi
"""Joints without limits move so far to both sides, rad."""


def known_motion(arm: srs_ik.Arm, rng: np.random.Generator, kind: str, count: int) -> np.ndarray:
    """(count, 7) joint angles, steps of one joint up to 0.05 to 0.14 rad for 200 poses.

    Kinds: "aside", joints 2, 4 and 6 stay on one side of their singular angles; "cross", anywhere inside the limits;
    "limits", joints stay on their limits for a while; "singular", joints 2, 4 and 6 swing about their singular angles.
    """
    lower, upper = np.maximum(arm.lower, -WIDE), np.minimum(arm.upper, WIDE)
    phases = np.array([0.0, phase(arm, 1), 0.0, phase(arm, 3), 0.0, phase(arm, 5), 0.0])
    low, high = lower.copy(), upper.copy()
    for j in (1, 3, 5):
        below, above = phases[j] - 0.15 - lower[j], upper[j] - phases[j] - 0.15
        if kind == "aside" and max(below, above) > 0.0:
            up = above > 0.0 and (below <= 0.0 or rng.uniform() < above / (above + below))
            low[j], high[j] = (phases[j] + 0.15, upper[j]) if up else (lower[j], phases[j] - 0.15)
        elif kind == "singular" and min(phases[j] - lower[j], upper[j] - phases[j]) > 0.05:
            low[j], high[j] = max(low[j], phases[j] - 0.4), min(high[j], phases[j] + 0.4)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    share = rng.uniform(0.2, 0.8, 7)
    size = half * (1.4 if kind == "limits" else 0.98) * rng.uniform(0.3, 1.0, 7)
    middle = middle + (half - np.minimum(size, 0.98 * half)) * rng.uniform(-1.0, 1.0, 7)
    rates = rng.uniform(0.5, 2.0, (2, 7)) * 2.0 * np.pi
    starts = rng.uniform(0.0, 2.0 * np.pi, (2, 7))

    def at(t: np.ndarray) -> np.ndarray:
        waves = np.sin(rates[:, None] * t[:, None] + starts[:, None])
        return np.clip(middle + size * (share * waves[0] + (1.0 - share) * waves[1]), lower, upper)

    rough = np.abs(np.diff(at(np.linspace(0.0, 1.0, 400)), axis=0)).max() * 399
    span = rng.uniform(0.05, 0.14) * 199 / rough
    return at(np.linspace(0.0, span, count))


def phase(arm: srs_ik.Arm, joint: int) -> float:
    """The angle of joint 2, 4 or 6 (1, 3, 5) that is singular, as the branches tell: they change there."""
    bit = {3: 4, 1: 2, 5: 1}[joint]
    angles = np.linspace(max(arm.lower[joint], -np.pi), min(arm.upper[joint], np.pi), 400)
    q = np.tile(np.full(7, 0.4), (400, 1))
    q[:, joint] = angles
    sides = [arm.branch(row) & bit for row in q]
    changes = np.flatnonzero(np.diff(sides))
    if not len(changes):
        return float(min((arm.lower[joint], arm.upper[joint]), key=abs))
    nearest = min(changes, key=lambda i: abs(angles[i]))
    return float(0.5 * (angles[nearest] + angles[nearest + 1]))


def load(name: str) -> srs_ik.Arm:
    """A robot by name, of a maker's file if that lies beside the checkout."""
    beside = BESIDE / f"{OF_MAKERS.get(name, name)}.urdf"
    return srs_ik.load(name, urdf=beside) if beside.is_file() else srs_ik.load(name)
