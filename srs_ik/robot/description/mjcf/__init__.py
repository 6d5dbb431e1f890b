"""MJCF files, the format of MuJoCo: what they say of motion and mass becomes a ``pinocchio.Model``.

Every element and attribute that moves a body or a joint is converted as MuJoCo converts it, or refused by its name.
Source: MuJoCo's XML reference, https://mujoco.readthedocs.io/en/stable/XMLreference.html.
"""

from srs_ik.robot.description.mjcf.model import build

__all__ = ["build"]
