"""Robots made for tests from a few figures: one for each kind of chain that real robot files hold.

They stand for files that cannot be part of the project. Each is written as a URDF into a folder of its own that lives
as long as the process.
"""

from __future__ import annotations

import atexit
import shutil
import tempfile
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pinocchio as pin

TURN, QUARTER = 2.0 * np.pi, 0.5 * np.pi
CONTINUOUS = (-np.inf, np.inf)


class Line(NamedTuple):
    """A joint axis at the zero configuration, in the base frame."""

    axis: tuple[float, float, float]
    point: tuple[float, float, float]
    """Millimetres."""
    limits: tuple[float, float]
    """Rad."""


X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
_X, _Y, _Z = (-1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0)

# Exact, XYX wrist; the joint origins lie on their axes, away from the centres.
OFFSETS = (
    Line(Z, (0, 0, 120), (-2.9, 2.9)),
    Line(Y, (0, -12, 310), (-2.0, 2.0)),
    Line(Z, (0, 0, 500), (-2.9, 2.9)),
    Line(_Y, (0, 12, 670), (-2.1, 2.1)),
    Line(Z, (0, 0, 850), (-2.9, 2.9)),
    Line(Y, (0, -60, 1010), (-2.0, 2.0)),
    Line(Z, (0, 0, 1080), (-3.05, 3.05)),
)

# Exact, XYX wrist, an elbow 80 mm off the line of the upper arm, and bent at zero; joint 1 turns a whole turn.
BENT = (
    Line(Z, (0, 0, 300), (-np.pi, np.pi)),
    Line(Y, (0, 0, 300), (-1.9, 1.9)),
    Line(Z, (0, 0, 560), (-2.95, 2.95)),
    Line(_Y, (80, 0, 560), (-QUARTER, 2.0)),
    Line(_X, (340, 0, 620), (-QUARTER, QUARTER)),
    Line(_Y, (340, 0, 620), (-1.9, 1.9)),
    Line(_X, (470, 0, 620), (-QUARTER, QUARTER)),
)

# Exact but for its right angles, which the file rounds to a microradian.
ROUNDED = (
    Line(Z, (0, 0, 240), (-3.1, 3.1)),
    Line(Y, (0, 0, 240), (-2.25, 2.25)),
    Line(Z, (0, 0, 490), (-3.1, 3.1)),
    Line(Y, (0, 0, 490), (-2.35, 2.35)),
    Line(Z, (0, 0, 705), (-3.1, 3.1)),
    Line(Y, (0, 0, 705), (-2.2, 2.2)),
    Line(Z, (0, 0, 850), (-6.28, 6.28)),
)

# Near: two axes of the shoulder miss the first by 0.45 mm.
NEAR = (
    Line(Z, (0, 0, 0), (-2.9, 2.9)),
    Line(Y, (-0.45, 0, 350), (-2.0, 2.0)),
    Line(Z, (-0.45, 0, 350), (-2.9, 2.9)),
    Line(_Y, (0, 0, 760), (-2.1, 2.1)),
    Line(Z, (0, 0, 760), (-2.9, 2.9)),
    Line(Y, (0, 0, 1150), (-2.0, 2.0)),
    Line(Z, (0, 0, 1150), (-3.05, 3.05)),
)

# Near, and folded at zero: the hand lies in the shoulder; every other joint is continuous, the rest turn about pi.
FOLDED = (
    Line(_Z, (0, 0, 150), CONTINUOUS),
    Line(_Y, (0, 1.5, 270), (0.8, 5.4)),
    Line(Z, (0, 1.5, 70), CONTINUOUS),
    Line(Y, (0, 1.5, -135), (0.5, 5.7)),
    Line(_Z, (0, -9.5, 70), CONTINUOUS),
    Line(_Y, (0, -9.5, 175), (1.1, 5.1)),
    Line(Z, (0, -9.5, 70), CONTINUOUS),
)

# Near, XYZ wrist: the first axis is oblique, the elbow beside the upper arm, and three axes miss one another.
OBLIQUE = (
    Line((0.0, 0.96, 0.28), (0, 150, 420), (-3.1, 1.5)),
    Line(X, (30, 209, 437), (-0.4, 3.4)),
    Line(Z, (0, 211, 290), (-2.6, 3.0)),
    Line(Y, (6, 240, 105), (-0.95, 3.1)),
    Line(X, (125, 211, 95), (-3.0, 2.7)),
    Line(Y, (215, 211, 95), (-0.45, 0.45)),
    Line(Z, (227, 211, 95), (-1.25, 1.25)),
)

# Exact, XYZ wrist: the left arm of two; the right one is its mirror image.
LEFT = (
    Line(Z, (0, 0, 60), (-3.4, 1.3)),
    Line(_X, (-30, 0, 120), (-3.2, 0.15)),
    Line(Y, (0, 65, 120), (-QUARTER, QUARTER)),
    Line(_Z, (0, 215, 90), (0.0, 2.4)),
    Line(Y, (0, 310, 120), (-QUARTER, QUARTER)),
    Line(X, (35, 430, 120), (-0.75, 0.75)),
    Line(Z, (0, 430, 120), (-QUARTER, QUARTER)),
)


def mirrored(lines: Sequence[Line]) -> tuple[Line, ...]:
    """The other arm of a pair, across the plane y = 0: directions of turn are mirrored, too."""
    return tuple(Line((-a[0], a[1], -a[2]), (p[0], -p[1], p[2]), (lower, upper)) for a, p, (lower, upper) in lines)


class Row(NamedTuple):
    """A row of Denavit and Hartenberg's table: metres and rad."""

    a: float
    alpha: float
    d: float
    turn: float = 0.0
    """Of the joint at zero."""


# J. J. Craig's rows, of a and alpha before the joint, as Franka Robotics and UFACTORY publish them.
FR3 = (
    Row(0, 0, 0.333),
    Row(0, -QUARTER, 0),
    Row(0, QUARTER, 0.316),
    Row(0.0825, QUARTER, 0),
    Row(-0.0825, -QUARTER, 0.384),
    Row(0, QUARTER, 0),
    Row(0.088, QUARTER, 0.107),
)
XARM7 = (
    Row(0, 0, 0.267),
    Row(0, -QUARTER, 0),
    Row(0, QUARTER, 0.293),
    Row(0.0525, QUARTER, 0),
    Row(0.0775, QUARTER, 0.3425),
    Row(0, QUARTER, 0),
    Row(0.076, -QUARTER, 0.097),
)
# Denavit and Hartenberg's own rows, of a and alpha behind the joint, as they are published of Rethink's and ABB's arms.
SAWYER = (
    Row(0.081, -QUARTER, 0.317),
    Row(0, -QUARTER, 0.1925, -QUARTER),
    Row(0, -QUARTER, 0.4),
    Row(0, -QUARTER, -0.1685),
    Row(0, -QUARTER, 0.4),
    Row(0, -QUARTER, 0.1363),
    Row(0, 0, 0.13375),
)
YUMI = (
    Row(-0.03, -QUARTER, 0.166),
    Row(0.03, QUARTER, 0),
    Row(0.0405, -QUARTER, 0.2515),
    Row(0.0405, -QUARTER, 0),
    Row(0.027, -QUARTER, 0.265),
    Row(-0.027, QUARTER, 0),
    Row(0, 0, 0.036),
)


def turn_to(axis: Sequence[float]) -> np.ndarray:
    """A rotation whose z axis is a direction."""
    z = np.array(axis) / np.linalg.norm(axis)
    x = np.cross(Y if abs(z[1]) < 0.9 else Z, z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def origin(T: pin.SE3, digits: int = 17) -> str:
    xyz = " ".join(f"{x + 0.0:.17g}" for x in np.round(T.translation, 12))
    rpy = " ".join(f"{x + 0.0:.{digits}g}" for x in np.round(pin.rpy.matrixToRpy(T.rotation), 15))
    return f'<origin xyz="{xyz}" rpy="{rpy}"/>'


def along(axis: Sequence[float]) -> str:
    direction = " ".join(f"{x + 0.0:.17g}" for x in axis)
    return f'<axis xyz="{direction}"/>'


def link(name: str, mass: float = 0.0) -> str:
    if not mass:
        return f'<link name="{name}"/>'
    inertia = f'<inertia ixx="{0.01 * mass}" iyy="{0.012 * mass}" izz="{0.005 * mass}" ixy="0" ixz="0" iyz="0"/>'
    mass_at = f'<origin xyz="0.01 -0.02 0.05"/><mass value="{mass}"/>'
    return f'<link name="{name}"><inertial>{mass_at}{inertia}</inertial></link>'


def joint(name: str, parent: str, child: str, kind: str, inside: str) -> str:
    return f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{inside}</joint>'


def fixed(parent: str, child: str, T: pin.SE3) -> str:
    return joint(f"{parent}_{child}", parent, child, "fixed", origin(T))


def turning(k: int, prefix: str, inside: str, limits: tuple[float, float], effort: float, mass: float) -> str:
    """Joint k, 1 to 7, with the link that it moves."""
    free = limits == CONTINUOUS
    ends = "" if free else f'lower="{limits[0]:.17g}" upper="{limits[1]:.17g}" '
    inside += f'<limit {ends}effort="{effort}" velocity="{1.5 + 0.1 * k:.2g}"/>'
    before, behind = f"{prefix}link_{k - 1}", f"{prefix}link_{k}"
    kind = "continuous" if free else "revolute"
    return link(behind, mass) + joint(f"{prefix}joint_{k}", before, behind, kind, inside)


def arm(
    lines: Sequence[Line],
    tip: pin.SE3,
    prefix: str = "",
    turned_frames: bool = True,
    digits: int = 17,
    efforts: bool = True,
    masses: bool = True,
) -> str:
    """Links `link_0` to `link_7` and `tool`, joints `joint_1` to `joint_7`.

    Args:
        lines: the seven axes.
        tip: pose of the tool at the zero configuration.
        prefix: of all names.
        turned_frames: whether every joint turns about the z axis of its frame; else all frames are parallel at zero.
        digits: of the angles in the file.
        efforts: whether torque limits are given.
        masses: whether the links have any.
    """
    parts, T = [link(f"{prefix}link_0")], pin.SE3.Identity()
    for k, line in enumerate(lines, 1):
        axis = np.array(line.axis) / np.linalg.norm(line.axis)
        R = turn_to(axis) if turned_frames else np.eye(3)
        moved = pin.SE3(R, 1e-3 * np.array(line.point, dtype=float))
        inside = origin(T.actInv(moved), digits) + along(Z if turned_frames else axis)
        parts.append(turning(k, prefix, inside, line.limits, efforts * (100.0 - 12.0 * k), masses * (4.0 - 0.5 * k)))
        T = moved
    tool = f"{prefix}tool"
    return "".join(parts) + link(tool) + fixed(f"{prefix}link_7", tool, T.actInv(tip))


def by_table(rows: Sequence[Row], modified: bool, prefix: str = "") -> str:
    """An arm by Denavit and Hartenberg's table, after J. J. Craig where it is the modified one."""
    parts, T = [link(f"{prefix}link_0")], pin.SE3.Identity()
    for k, row in enumerate(rows, 1):
        tilt = pin.SE3(pin.rpy.rpyToMatrix(row.alpha, 0.0, 0.0), np.array([row.a, 0.0, 0.0]))
        lift = pin.SE3(pin.rpy.rpyToMatrix(0.0, 0.0, row.turn), np.array([0.0, 0.0, row.d]))
        before, T = (T * tilt * lift, pin.SE3.Identity()) if modified else (T, lift * tilt)
        parts.append(turning(k, prefix, origin(before) + along(Z), (-2.5, 2.5), 50.0, 1.0))
    tool = f"{prefix}tool"
    return "".join(parts) + link(tool) + fixed(f"{prefix}link_7", tool, T)


def gripper(prefix: str) -> str:
    """Two fingers that slide, behind the tool."""
    inside = '<axis xyz="0 1 0"/><limit lower="0" upper="0.04" effort="50" velocity="0.2"/>'
    return "".join(
        link(f"{prefix}finger_{k}", 0.05)
        + joint(f"{prefix}slide_{k}", f"{prefix}tool", f"{prefix}finger_{k}", "prismatic", inside)
        for k in (1, 2)
    )


def pose(xyz: Sequence[float], axis: Sequence[float] = Z) -> pin.SE3:
    """A pose in millimetres whose z axis is a direction."""
    return pin.SE3(turn_to(axis), 1e-3 * np.array(xyz, dtype=float))


def twins() -> str:
    """Two arms with grippers on a body, as on a table: each on a mount of its own."""
    parts = [link("body", 20.0)]
    for prefix, lines, side in (("left_", LEFT, 1.0), ("right_", mirrored(LEFT), -1.0)):
        parts.append(arm(lines, pose((0, side * 530, 125), (0, side, 0)), prefix) + gripper(prefix))
        parts.append(fixed("body", f"{prefix}link_0", pin.SE3(np.eye(3), np.array([0.0, 0.03 * side, 0.7]))))
    return "".join(parts)


def refused_twins() -> str:
    parts = [link("body")]
    for prefix, side in (("left_", 1.0), ("right_", -1.0)):
        parts.append(by_table(YUMI, False, prefix))
        mount = pin.SE3(pin.rpy.rpyToMatrix(-0.9 * side, 0.5, 0.0), np.array([0.05, 0.07 * side, 0.4]))
        parts.append(fixed("body", f"{prefix}link_0", mount))
    return "".join(parts)


MAKERS: dict[str, Callable[[], str]] = {
    "made_offsets": lambda: arm(OFFSETS, pose((0, 0, 1120))),
    "made_bent": lambda: arm(BENT, pose((490, 0, 620), X), efforts=False),
    "made_rounded": lambda: arm(ROUNDED, pose((0, 0, 850)), digits=7),
    "made_near": lambda: arm(NEAR, pose((0, 0, 1275)), turned_frames=False, efforts=False, masses=False),
    "made_folded": lambda: arm(FOLDED, pose((0, -9.5, 72))),
    "made_oblique": lambda: arm(OBLIQUE, pose((236, 211, 95)), turned_frames=False),
    "made_twins": twins,
    "made_fr3": lambda: by_table(FR3, True),
    "made_xarm7": lambda: by_table(XARM7, True),
    "made_sawyer": lambda: by_table(SAWYER, False),
    "made_yumi": refused_twins,
}
"""What writes each file, by its name; those from "made_fr3" on are no S-R-S limbs."""


@cache
def _folder() -> Path:
    folder = Path(tempfile.mkdtemp(prefix="srs_ik_chains_"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


@cache
def file_of(name: str) -> Path:
    """The URDF of a robot that is made here."""
    path = _folder() / f"{name}.urdf"
    path.write_text(f'<robot name="{name}">{MAKERS[name]()}</robot>\n')
    return path
