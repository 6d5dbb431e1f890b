"""The built-in, made and real arms that tests of the solver go through, each loaded once a process."""

from __future__ import annotations

import zlib
from functools import cache

import numpy as np
from oracles import Forward, random_angles
from robot_files import at_hand, robot_file

import srs_ik

MADE = {
    "made_offsets": ("made_offsets", "link_0", "tool"),
    "made_bent": ("made_bent", "link_0", "tool"),
    "made_rounded": ("made_rounded", "link_0", "tool"),
    "made_near": ("made_near", "link_0", "tool"),
    "made_folded": ("made_folded", "link_0", "tool"),
    "made_oblique": ("made_oblique", "link_0", "tool"),
    "made_left": ("made_twins", "left_link_0", "left_tool"),
    "made_right": ("made_twins", "right_link_0", "right_tool"),
}
"""File, base and tip of every limb in the files that `chains` makes."""

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
"""File, base and tip of every limb in the files of makers."""

PLACES = MADE | REAL

BUILT_IN = ("iiwa14", "gen3", "human_arm")
NEAR = (
    "made_near",
    "made_folded",
    "made_oblique",
    "iiwa14_experimental",
    "gen3_upstream",
    "gen3",
    "j2s7s300",
    "h1_2_left",
    "h1_2_right",
)


STANDS_FOR = {
    "made_offsets": ("iiwa14_drake", "med7", "sia10f"),
    "made_bent": ("sia5d",),
    "made_rounded": ("rm75",),
    "made_near": ("iiwa14_experimental",),
    "gen3": ("gen3_upstream",),
    "made_folded": ("j2s7s300",),
    "made_oblique": ("h1_2_left", "h1_2_right"),
    "made_left": ("openarm_left",),
    "made_right": ("openarm_right",),
}
"""The arms of files that may not be at hand, and what is always tried for them."""

_STAND_IN = {real: made for made, reals in STANDS_FOR.items() for real in reals}


def here(*names: str) -> tuple[str, ...]:
    """Those of some arms whose files are at hand, and for each real one, here or not, what stands for it."""
    found: dict[str, None] = {}
    for name in names:
        if name in _STAND_IN:
            found[_STAND_IN[name]] = None
        if name in BUILT_IN or at_hand(PLACES[name][0]):
            found[name] = None
    return tuple(found)


FROM_FILES = tuple(name for name in here(*REAL) if name not in BUILT_IN)
EVERY = (*BUILT_IN, *FROM_FILES)
EXACT = tuple(name for name in EVERY if name not in NEAR)


def tolerance(name: str) -> float:
    """How well poses are met: metres and radians."""
    return 1e-9 if name in NEAR else 1e-11


@cache
def load(name: str) -> srs_ik.Arm:
    if name in BUILT_IN:
        return srs_ik.load(name)
    _, base, tip = PLACES[name]
    return srs_ik.load(file_of(name), base=base, tip=tip)


@cache
def forward(name: str) -> Forward:
    """Pinocchio on the whole robot of the file, read without the package."""
    arm = load(name)
    if name in BUILT_IN:
        from srs_ik.robot import zoo

        return Forward(zoo.card(name).urdf, arm.base, arm.tip, arm.joint_names)
    return Forward(file_of(name), *PLACES[name][1:], arm.joint_names)


def file_of(name: str):
    return robot_file(PLACES[name][0])


def generator(name: str, salt: int = 0) -> np.random.Generator:
    return np.random.default_rng([zlib.crc32(name.encode()), salt])


def configurations(name: str, count: int, salt: int = 0) -> np.ndarray:
    """(count, 7) random angles inside the limits."""
    arm, rng = load(name), generator(name, salt)
    return np.array([random_angles(rng, arm.lower, arm.upper) for _ in range(count)])
