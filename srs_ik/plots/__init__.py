"""Pictures without a browser, by Matplotlib: ellipsoids with the arm, what the arm angle does and may be, and paths."""

from srs_ik.plots.arm_angle import plot_arm_angle
from srs_ik.plots.ellipsoids import plot_ellipsoids
from srs_ik.plots.intervals import plot_intervals
from srs_ik.plots.maps import plot_map, plot_shell, plot_yaw_arcs
from srs_ik.plots.path import plot_path

__all__ = [
    "plot_arm_angle",
    "plot_ellipsoids",
    "plot_intervals",
    "plot_map",
    "plot_path",
    "plot_shell",
    "plot_yaw_arcs",
]
