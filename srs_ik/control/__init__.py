"""Torque control by superposition: fractal impedances on tip, orientation and elbow, and what they are compared with.

C. Tiseo, S. R. Charitos, M. Mistry name this as their future work: the geometrical posture as the target of the elbow,
without projections into a null space.
"""

from srs_ik.control import baselines, one_axis, planners
from srs_ik.control.controller import PortReading, TorqueController
from srs_ik.control.impedance import FractalImpedance, JointLimits, JointSpeeds
from srs_ik.control.profile import ForceProfile

__all__ = [
    "ForceProfile",
    "FractalImpedance",
    "JointLimits",
    "JointSpeeds",
    "PortReading",
    "TorqueController",
    "baselines",
    "one_axis",
    "planners",
]
