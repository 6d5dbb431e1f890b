"""Pictures without a browser, by Matplotlib: ellipsoids with the arm, and what the arm angle does and may be."""

from srs_ik.plots.arm_angle import plot_arm_angle
from srs_ik.plots.ellipsoids import plot_ellipsoids
from srs_ik.plots.intervals import plot_intervals

__all__ = ["plot_arm_angle", "plot_ellipsoids", "plot_intervals"]
