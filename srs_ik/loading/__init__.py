"""From whatever names or describes a robot to an `Arm`, or to a report of the limbs in it."""

from srs_ik.loading.limbs import LimbReport
from srs_ik.loading.load import find_limbs, load
from srs_ik.loading.sources import names

__all__ = ["LimbReport", "find_limbs", "load", "names"]
