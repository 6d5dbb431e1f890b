"""From whatever names or describes a robot to an `Arm`, or to a report of the limbs in it."""

from srs_ik.loading.loader import find_limbs, load
from srs_ik.robot.candidates import LimbReport
from srs_ik.robot.sources import robots

__all__ = ["LimbReport", "find_limbs", "load", "robots"]
