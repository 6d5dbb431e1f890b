"""What the tip does, by Pinocchio: its velocity from differences of its pose, and the torques of its wrench."""

import numpy as np
import pinocchio as pin

ROWS = {"linear": slice(0, 3), "angular": slice(3, 6), "full": slice(0, 6)}

STRETCHED = (0.3, 0.7, 0.2, 0.0, 0.4, 0.0, -0.2)
FOLDED = (0.3, 0.7, 0.2, np.pi, 0.4, 0.0, -0.2)
"""Postures of the iiwa14 in which shoulder, elbow, wrist and tip are in one line."""


def moved(forward, q: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """Velocity (6,) of the tip in base axes, by central differences of its pose."""
    step = 1e-5 / np.linalg.norm(rate)
    before, after = forward(q - step * rate), forward(q + step * rate)
    turn = pin.log3(after.rotation @ before.rotation.T)
    return np.concatenate([after.translation - before.translation, turn]) / (2.0 * step)


def held(arm, model, data, q: np.ndarray, wrench: np.ndarray) -> np.ndarray:
    """Joint torques under a wrench that the tip exerts, by inverse dynamics with and without its reaction."""
    configuration, still = arm.configuration(q), np.zeros(7)
    pin.framesForwardKinematics(model, data, configuration)
    tip, base = (data.oMf[model.getFrameId(name)] for name in (arm.tip, arm.base))
    turn = tip.rotation.T @ base.rotation
    at_tip = pin.Force(-turn @ wrench[:3], -turn @ wrench[3:])
    last = model.frames[model.getFrameId(arm.tip)].parentJoint
    outside = [pin.Force.Zero() for _ in range(model.njoints)]
    outside[last] = (data.oMi[last].inverse() * tip).act(at_tip)
    loaded = pin.rnea(model, data, configuration, still, still, outside).copy()
    return loaded - pin.rnea(model, data, configuration, still, still)
