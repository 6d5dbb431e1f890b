"""The real and built-in arms that tests of the solver go through, each loaded once a process."""

from __future__ import annotations

import zlib
from functools import cache

import numpy as np
from oracles import Forward, random_angles
from robot_files import EXAMPLES, example_urdf, shared_urdf

import srs_ik

REAL = {
    "iiwa14_drake": ("iiwa14_drake_models", "iiwa_link_0", "iiwa_link_7"),
    "iiwa14_experimental": ("iiwa14_kuka_experimental", "base_link", "tool0"),
    "gen3_upstream": ("kinova_gen3_7dof", "base_link", "tool_frame"),
    "j2s7s300": ("kinova_j2s7s300", "j2s7s300_link_base", "j2s7s300_link_7"),
    "med7": ("med7_lbr_stack", "lbr_link_0", "lbr_link_ee"),
    "sia10f": ("motoman_sia10f", "base_link", "link_tool0"),
    "sia5d": ("motoman_sia5d", "base_link", "tool0"),
    "openarm_left": ("openarm_v10_bimanual", "openarm_left_link0", "openarm_left_hand"),
    "openarm_right": ("openarm_v10_bimanual", "openarm_right_link0", "openarm_right_hand"),
    "rm75": ("realman_rm75", "base_link", "Link7"),
    "h1_2_left": ("unitree_h1_2_handless", "torso_link", "left_wrist_yaw_link"),
    "h1_2_right": ("unitree_h1_2_handless", "torso_link", "right_wrist_yaw_link"),
    "human_left": ("human", "left_clavicle", "left_hand"),
    "human_right": ("human", "right_clavicle", "right_hand"),
    "humanoid_left": ("simple_humanoid", "torso", "l_wrist"),
    "humanoid_right": ("simple_humanoid", "torso", "r_wrist"),
    "romeo_left": ("romeo", "torso", "l_wrist"),
    "romeo_right": ("romeo", "torso", "r_wrist"),
}
"""File, base and tip of every limb that the files at hand contain."""

BUILT_IN = ("iiwa14", "gen3", "human_arm")
NEAR = ("iiwa14_experimental", "gen3_upstream", "gen3", "j2s7s300", "h1_2_left", "h1_2_right")
EVERY = (*BUILT_IN, *REAL)
EXACT = tuple(name for name in EVERY if name not in NEAR)


def tolerance(name: str) -> float:
    """How well poses are met: metres and radians."""
    return 1e-9 if name in NEAR else 1e-11


@cache
def load(name: str) -> srs_ik.Arm:
    if name in BUILT_IN:
        return srs_ik.load(name)
    _, base, tip = REAL[name]
    return srs_ik.load(file_of(name), base=base, tip=tip)


@cache
def forward(name: str) -> Forward:
    """Pinocchio on the whole robot of the file, read without the package."""
    arm = load(name)
    if name in BUILT_IN:
        from srs_ik.robot import zoo

        return Forward(zoo.card(name).urdf, arm.base, arm.tip, arm.joint_names)
    return Forward(file_of(name), *REAL[name][1:], arm.joint_names)


def file_of(name: str):
    file = REAL[name][0]
    return example_urdf(file) if file in EXAMPLES else shared_urdf(file)


def generator(name: str, salt: int = 0) -> np.random.Generator:
    return np.random.default_rng([zlib.crc32(name.encode()), salt])


def configurations(name: str, count: int, salt: int = 0) -> np.ndarray:
    """(count, 7) random angles inside the limits."""
    arm, rng = load(name), generator(name, salt)
    return np.array([random_angles(rng, arm.lower, arm.upper) for _ in range(count)])
