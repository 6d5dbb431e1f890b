"""What a posture can do: ellipsoids, polytopes, gravity."""

from srs_ik.analysis.ellipsoids import (
    Ellipsoid,
    force_ellipsoid,
    force_transmission,
    force_velocity_ratio,
    isotropy,
    manipulability,
    velocity_ellipsoid,
    velocity_transmission,
)
from srs_ik.analysis.polytopes import Polytope, force_polytope, velocity_polytope

__all__ = [
    "Ellipsoid",
    "Polytope",
    "force_ellipsoid",
    "force_polytope",
    "force_transmission",
    "force_velocity_ratio",
    "isotropy",
    "manipulability",
    "velocity_ellipsoid",
    "velocity_polytope",
    "velocity_transmission",
]
