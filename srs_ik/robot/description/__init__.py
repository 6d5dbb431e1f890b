"""Reading robot descriptions: a file, XML text, or a ``yourdfpy.URDF`` becomes a ``pinocchio.Model``."""

from srs_ik.robot.description.model import RobotModel, load_model

__all__ = ["RobotModel", "load_model"]
