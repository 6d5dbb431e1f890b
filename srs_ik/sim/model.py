"""From an arm to a model of MuJoCo: its own file where MuJoCo reads that, else the inertias that Pinocchio read."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree.ElementTree import tostring

import numpy as np
import pinocchio as pin

from srs_ik.errors import InvalidController, InvalidRobot, MissingExtra
from srs_ik.robot.description import document
from srs_ik.robot.description.files import label_of, read
from srs_ik.robot.limb import Vector

if TYPE_CHECKING:
    from srs_ik.arm import Arm

SMALLEST_MASS = 1e-12
"""Mass, kg, and inertia, kg m^2, of links that have none: MuJoCo moves nothing without."""

SOFTEST = 1e-9
"""An arm whose mass matrix has a smaller eigenvalue everywhere, kg m^2, cannot be simulated."""

_TRIALS = 32


def import_mujoco() -> Any:
    """The module, or the error that says how to install it.

    Raises:
        MissingExtra: MuJoCo is not installed, or older than 3.14, which reads inertias of URDF files wrongly.
    """
    try:
        import mujoco
    except ImportError:
        raise MissingExtra("sim", "a simulation") from None
    if tuple(int(part) for part in mujoco.__version__.split(".")[:2]) < (3, 14):
        raise MissingExtra("sim", f"a simulation, for which MuJoCo {mujoco.__version__} is too old,")
    return mujoco


def require_inertias(arm: Arm) -> None:
    """Raise InvalidController for an arm whose links have no inertias to move."""
    rng, data = np.random.default_rng(0), arm.model.createData()
    softest = max(_softest(arm, data, rng.uniform(-2.0, 2.0, 7)) for _ in range(_TRIALS))
    if softest < SOFTEST:
        bare = [name for name, body in zip(arm.joint_names, list(arm.model.inertias)[1:], strict=True) if not body.mass]
        which = f"; nothing that has a mass hangs on {', '.join(bare)}" if bare else ""
        raise InvalidController(
            f"the description of {arm.name} gives its links no inertias to simulate{which}: load one with <inertial>"
        )


def _softest(arm: Arm, data: Any, q: Vector) -> float:
    return float(np.linalg.eigvalsh(pin.crba(arm.model, data, arm.configuration(q)))[0])


def make_spec(arm: Arm) -> tuple[Any, str]:
    """MuJoCo's description of the arm, all other joints locked, and where it was read from: "urdf" or "pinocchio"."""
    mujoco = import_mujoco()
    text = _urdf(arm)
    if text is not None:
        try:
            spec = mujoco.MjSpec.from_string(text)
            spec.compiler.fusestatic = False
            for joint in list(spec.joints):
                if joint.name not in arm.joint_names:
                    spec.delete(joint)
            for tie in list(spec.equalities):
                spec.delete(tie)
            spec.compile()
            return spec, "urdf"
        except ValueError:
            # Links without masses, inertias that no body has, ties between joints: Pinocchio takes them as they are.
            pass
    return _from_pinocchio(mujoco, arm.model), "pinocchio"


def _urdf(arm: Arm) -> str | None:
    """The arm's URDF, links and joints alone; None for an arm that is not as in one, or was not loaded from it."""
    if arm.drawing is None or arm.locked or arm.held_mass:
        # MuJoCo would have all other joints at zero, and nothing in the hand.
        return None
    content = arm.drawing.content
    try:
        if content is None and arm.drawing.file is not None:
            content = read(Path(arm.drawing.file), label_of(Path(arm.drawing.file)))
        if not isinstance(content, str | bytes):
            return None
        return tostring(document.parse(content, arm.name), encoding="unicode")
    except InvalidRobot:
        return None


def _from_pinocchio(mujoco: Any, model: Any) -> Any:
    """Seven bodies and what stands still, with the inertias of a Pinocchio model."""
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    body = spec.worldbody
    for k in range(1, 8):
        placement, inertia = model.jointPlacements[k], model.inertias[k]
        quaternion = pin.Quaternion(placement.rotation)
        body = body.add_body(
            name=f"link of {model.names[k]}",
            pos=placement.translation,
            quat=[quaternion.w, quaternion.x, quaternion.y, quaternion.z],
        )
        body.explicitinertial = True
        body.mass = max(inertia.mass, SMALLEST_MASS)
        body.ipos = inertia.lever
        # The principal axes; MuJoCo refuses bodies that are thinner than a rod.
        moments, axes = np.linalg.eigh(inertia.inertia)
        axes[:, 0] *= np.sign(np.linalg.det(axes))
        turn = pin.Quaternion(axes)
        body.iquat = [turn.w, turn.x, turn.y, turn.z]
        body.inertia = np.maximum(moments, SMALLEST_MASS)
        joint = body.add_joint(name=model.names[k], type=mujoco.mjtJoint.mjJNT_HINGE, axis=_axis(model, k))
        joint.damping = [model.damping[model.joints[k].idx_v], 0.0, 0.0]
        joint.frictionloss = model.friction[model.joints[k].idx_v]
        joint.armature = model.armature[model.joints[k].idx_v]
    return spec


def _axis(model: Any, k: int) -> Vector:
    """Axis of a joint in its own frame, by Pinocchio itself."""
    joint = model.joints[k]
    data = model.createData()
    pin.computeJointJacobians(model, data, pin.neutral(model))
    return np.array(data.oMi[k].rotation.T @ data.J[3:, joint.idx_v])
