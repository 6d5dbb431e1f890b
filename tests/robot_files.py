"""Robot files for tests: made ones always, real ones where they are at hand, and small robots written for a test."""

from importlib import metadata
from pathlib import Path

import chains
import numpy as np
import pinocchio as pin
import pytest

SHARED = Path(__file__).resolve().parents[2] / "shared" / "urdf"

EXAMPLES = {
    "human": "human_description/robots/human.urdf",
    "simple_humanoid": "simple_humanoid_description/urdf/simple_humanoid.urdf",
    "romeo": "romeo_description/urdf/romeo.urdf",
    "icub": "icub_description/robots/icub.urdf",
}


REAL = (
    "abb_yumi",
    "franka_fr3",
    "iiwa14_drake_models",
    "iiwa14_kuka_experimental",
    "kinova_gen3_7dof",
    "kinova_j2s7s300",
    "med7_lbr_stack",
    "motoman_sia10f",
    "motoman_sia5d",
    "openarm_v10_bimanual",
    "realman_rm75",
    "sawyer",
    "unitree_h1_2_handless",
    "xarm7",
)
"""Files of makers, which are not part of this project: tests use those that lie beside the checkout."""


def at_hand(*names: str) -> list[str]:
    """Those of some files that are here, in their order."""
    return [name for name in names if name not in REAL or (SHARED / f"{name}.urdf").is_file()]


def robot_file(name: str) -> Path:
    """A made robot, one of example-robot-data, or a real file beside the checkout; skips the test without it."""
    if name in chains.MAKERS:
        return chains.file_of(name)
    return example_urdf(name) if name in EXAMPLES else shared_urdf(name)


def shared_urdf(name: str) -> Path:
    path = SHARED / f"{name}.urdf"
    if not path.is_file():
        pytest.skip(f"{path.name} is not beside the checkout")
    return path


def example_urdf(name: str) -> Path:
    wanted = f"example-robot-data/robots/{EXAMPLES[name]}"
    try:
        files = metadata.files("example-robot-data") or ()
    except metadata.PackageNotFoundError:
        files = ()
    for file in files:
        if str(file).endswith(wanted):
            return Path(str(file.locate()))
    pytest.skip(f"example-robot-data with {wanted} is not installed")


def random_configuration(model: pin.Model, rng: np.random.Generator) -> np.ndarray:
    """One within reach of every joint, limited or not."""
    return pin.integrate(model, pin.neutral(model), rng.uniform(-2.0, 2.0, model.nv))


def joint_xml(name: str, parent: str, child: str, kind: str = "revolute", inside: str | None = None) -> str:
    if inside is None:
        inside = '<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/>'
    return f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{inside}</joint>'


def robot_xml(*parts: str, links: str = "a b c", name: str = "small") -> str:
    return (
        f'<robot name="{name}">'
        + "".join(f'<link name="{link}"/>' for link in links.split())
        + "".join(parts)
        + "</robot>"
    )


def serial_arm(
    axes: str = "z y z y z y z",
    offsets: str = "0 0 .3 0 .3 0 .1",
    kinds: dict[int, str] | None = None,
    prefix: str = "",
) -> str:
    """Links `l0` to `l7` and joints `j1` to `j7` about the given axes, each a step up the z axis from the last one."""
    unit = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}
    parts = [f'<link name="{prefix}l0"/>']
    for k, (axis, offset) in enumerate(zip(axes.split(), offsets.split(), strict=True), 1):
        inside = (
            f'<origin xyz="0 0 {offset}"/><axis xyz="{unit[axis]}"/>'
            '<limit lower="-2" upper="2" effort="10" velocity="3"/>'
        )
        parts.append(f'<link name="{prefix}l{k}"/>')
        parts.append(
            joint_xml(f"{prefix}j{k}", f"{prefix}l{k - 1}", f"{prefix}l{k}", (kinds or {}).get(k, "revolute"), inside)
        )
    return "".join(parts)
