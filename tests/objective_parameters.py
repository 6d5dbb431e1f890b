"""The built-in objectives with parameters for each, that tests of several modules go through."""

import numpy as np

FORCE, VELOCITY = np.array([0.3, -2.0, 1.1]), np.array([1.0, 0.4, -0.2])
SIX = np.array([0.5, -1.0, 0.2, 2.0, 0.1, -0.7])
REFERENCE = np.array([0.1, -0.2, 0.3, -1.4, 0.5, 0.6, -0.7])
PARAMETERS = {
    "force_velocity_ratio": {"force": FORCE, "velocity": VELOCITY},
    "force_then_velocity": {"force": FORCE, "velocity": VELOCITY},
    "velocity_then_force": {"force": FORCE, "velocity": VELOCITY},
    "twist": {"twist": SIX},
    "wrench": {"wrench": SIX},
    "manipulability": {},
    "limit_margin": {},
    "reference_posture": {"reference": REFERENCE},
    "gravity_torque": {},
}
NAMES = tuple(PARAMETERS)
