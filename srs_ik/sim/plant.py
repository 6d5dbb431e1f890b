"""The plant: an arm in MuJoCo, with motors, limits, damping and what stands around it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from srs_ik.arm import Arm
from srs_ik.errors import InvalidController
from srs_ik.inputs.angles import as_joint_vector
from srs_ik.inputs.control import flag, one_of, positive, seven_not_negative, thing, torques, vector
from srs_ik.robot.limb import Vector
from srs_ik.sim.furnish import Furnisher
from srs_ik.sim.model import import_mujoco, make_spec, require_inertias
from srs_ik.sim.world import World

TIMESTEP = 2.5e-4
"""Seconds."""

PLACES = ("tip", "elbow")
"""Of the arm, that can be pushed."""

LIMIT_TIME = 0.004
"""Time constant of the joint limits, s: soft constraints, but stiff ones."""

NEVER = 1e6
"""A joint angle, rad, that stands for a limit that is not there, of a joint with one limit alone."""


class Plant:
    """An arm in MuJoCo: a program that knows nothing of this package moves it.

    Motors are actuators that the effort limits clamp; joint limits are soft constraints; velocity limits are not
    simulated. Where MuJoCo cannot read the robot file (links without masses, for one), its bodies are those that
    Pinocchio read from it.

    Args:
        arm: the arm; its links need inertias.
        world: walls, pegs, boxes and a payload.
        damping: of the joints, N m s/rad, one or (7,); "file" for what the robot file says.
        armature: inertia of the rotors, kg m^2, one or (7,), added to what the file has.
        timestep: s.
        joint_limits: whether the joints end at their limits.
        effort_limits: whether the motors end at theirs.
        friction: of the joints, dry, N m, one or (7,); "file" for what the robot file says.

    Attributes:
        model: the ``mujoco.MjModel``.
        data: its ``mujoco.MjData``. After a change of either by hand, ``mujoco.mj_forward(model, data)`` has to be
            called before the next step, which begins with what was derived of the state.
        source: "urdf" or "pinocchio", where the bodies were read from.
        damping: (7,) N m s/rad.
        friction: (7,) N m.
        touches_by: what meets the world: "tip", its ball alone; and the arm too, by "shapes" of its file or by "bars".

    Raises:
        MissingExtra: MuJoCo is not installed.
        InvalidController: the links have no inertias, a thing is of another class, or a figure is none.
    """

    def __init__(
        self,
        arm: Arm,
        world: World | None = None,
        damping: ArrayLike | Literal["file"] = "file",
        armature: ArrayLike = 0.0,
        timestep: float = TIMESTEP,
        joint_limits: bool = True,
        effort_limits: bool = True,
        friction: ArrayLike | Literal["file"] = "file",
    ) -> None:
        self._mujoco = mujoco = import_mujoco()
        self.arm = thing(arm, Arm, "arm", "srs_ik.load")
        self.world = World() if world is None else thing(world, World, "world")
        flag(joint_limits, "joint_limits")
        flag(effort_limits, "effort_limits")
        require_inertias(arm)
        self.timestep = positive(timestep, "timestep")
        spec, self.source = make_spec(arm)
        self._furnish(spec)
        spec.option.timestep = self.timestep
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        spec.option.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
        spec.option.gravity = arm.model.gravity.linear
        for k, name in enumerate(arm.joint_names):
            self._set_joint(spec, k, name, joint_limits, effort_limits)
        self.model = spec.compile()
        self._at = np.array([self.model.joint(name).dofadr[0] for name in arm.joint_names])
        if not (isinstance(damping, str) and damping == "file"):
            self.model.dof_damping[self._at] = seven_not_negative(damping, "damping")
        if not (isinstance(friction, str) and friction == "file"):
            self.model.dof_frictionloss[self._at] = seven_not_negative(friction, "friction")
        self.model.dof_armature[self._at] += seven_not_negative(armature, "armature")
        self.data = mujoco.MjData(self.model)
        self.damping = np.array(self.model.dof_damping[self._at])
        self.friction = np.array(self.model.dof_frictionloss[self._at])
        self._tip_body, self._elbow_body = (int(self.model.joint(arm.joint_names[k]).bodyid[0]) for k in (6, 2))
        self._push = np.zeros(self.model.nv)
        # MuJoCo counts here what it found to be no number, or too large, in a motion: position, speed and so on.
        self._warned, first = self.data.warning.number, int(mujoco.mjtWarning.mjWARN_BADQPOS)
        self._bad = range(first, len(self._warned))
        self.reset(np.zeros(7))

    def __repr__(self) -> str:
        w = self.world
        around = [(w.walls, "wall", "walls"), (w.pegs, "peg", "pegs"), (w.boxes, "box", "boxes")]
        held = [f"{len(some)} {one if len(some) == 1 else more}" for some, one, more in around if some]
        held += ["payload"] if w.payload else []
        return f"Plant({self.arm.name}{''.join(f', {each}' for each in held)}, at {self.data.time:.4g} s)"

    # State ------------------------------------------------------------------------------------------------------

    def reset(self, q: ArrayLike, v: ArrayLike | None = None) -> None:
        """Put the arm at joint angles (7,), rad, with speeds (7,), rad/s, at rest if not given.

        Raises:
            InvalidConfiguration: not 7 finite figures.
        """
        self._mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[self._at] = as_joint_vector(q)
        self.data.qvel[self._at] = np.zeros(7) if v is None else as_joint_vector(v, "v")
        self._mujoco.mj_forward(self.model, self.data)

    @property
    def q(self) -> Vector:
        """(7,) joint angles, rad."""
        return np.array(self.data.qpos[self._at])

    @property
    def v(self) -> Vector:
        """(7,) joint speeds, rad/s."""
        return np.array(self.data.qvel[self._at])

    def step(self, torque: Vector) -> None:
        """One time step with torques (7,), N m, which the effort limits clamp.

        Raises:
            InvalidController: not 7 finite torques, or a motion that is unstable: MuJoCo begins anew then.
        """
        self.data.ctrl[:] = torques(torque)
        begun = self.data.time
        # The second half of a step, then the first half of the next one: what MuJoCo derives of a state (energies,
        # mass matrix, where the links are) belongs to q and v as they are now, and not to those before the step.
        if self.model.opt.integrator == self._mujoco.mjtIntegrator.mjINT_RK4:
            self._mujoco.mj_step(self.model, self.data)
        else:
            self._mujoco.mj_step2(self.model, self.data)
        self._mujoco.mj_step1(self.model, self.data)
        for what in self._bad:
            if self._warned[what]:
                raise InvalidController(
                    f"the motion is unstable at {begun:.4g} s: figures of it are infinite to MuJoCo; take a softer "
                    f"controller, a higher rate, or time steps shorter than {self.timestep:g} s"
                )

    def push(self, on: str, force: ArrayLike) -> None:
        """Push the tip or the elbow with a force (3,) in base axes, N, until the next call of this function.

        Raises:
            InvalidController: another place, or not a force.
        """
        self.push_all([(on, force)])

    def push_all(self, pushes: Iterable[tuple[str, ArrayLike]]) -> None:
        """Push by several forces at once, each with its place, until the next push; those on one place add up.

        Raises:
            InvalidController: another place, or not a force.
        """
        self._push[:] = 0.0
        for on, force in pushes:
            one_of(on, PLACES, "a push is on")
            h = self.R_root_base @ vector(force, "force of a push")
            body, point = (self._tip_body, self._tip_site) if on == "tip" else (self._elbow_body, self._elbow_site)
            where = self.data.xpos[body] + self.data.xmat[body].reshape(3, 3) @ point
            self._mujoco.mj_applyFT(self.model, self.data, h, np.zeros(3), where, body, self._push)
        self.data.qfrc_applied[:] = self._push

    def release(self) -> None:
        """Push no more."""
        self.push_all(())

    def fall_exactly(self) -> None:
        """Integrate by the method of Runge and Kutta of order 4 from now on, for comparison with other programs."""
        self.model.opt.integrator = self._mujoco.mjtIntegrator.mjINT_RK4

    # Figures ----------------------------------------------------------------------------------------------------

    @property
    def mass_matrix(self) -> Vector:
        """(7, 7) at `q`, in the joints' order, kg m^2, column by column by MuJoCo's product."""
        columns, out = np.zeros((7, 7)), np.zeros(self.model.nv)
        for k, index in enumerate(self._at):
            one = np.zeros(self.model.nv)
            one[index] = 1.0
            self._mujoco.mj_mulM(self.model, self.data, out, one)
            columns[:, k] = out[self._at]
        return columns

    @property
    def bias(self) -> Vector:
        """(7,) torques of gravity, Coriolis and centrifugal forces at `q` and `v`, N m."""
        return np.array(self.data.qfrc_bias[self._at])

    @property
    def energy(self) -> tuple[float, float]:
        """Potential and kinetic energy at `q` and `v`, J."""
        return float(self.data.energy[0]), float(self.data.energy[1])

    def contact_force(self) -> Vector:
        """(3,) sum of what the world does to the arm at `q` and `v` under the last torques, N, base axes."""
        self._mujoco.mj_forwardSkip(self.model, self.data, self._mujoco.mjtStage.mjSTAGE_VEL, 1)
        total, one = np.zeros(3), np.zeros(6)
        for k in range(self.data.ncon):
            contact = self.data.contact[k]
            self._mujoco.mj_contactForce(self.model, self.data, k, one)
            # Axes of a contact are rows; its normal leads from the first shape to the second one.
            force = contact.frame.reshape(3, 3).T @ one[:3]
            total += force if self.model.geom_conaffinity[contact.geom1] else -force
        return self.R_root_base.T @ total

    # Making -----------------------------------------------------------------------------------------------------

    def _set_joint(self, spec: Any, k: int, name: str, limited: bool, clamped: bool) -> None:
        mujoco, arm, joint = self._mujoco, self.arm, spec.joint(name)
        bounded = limited and (np.isfinite(arm.lower[k]) or np.isfinite(arm.upper[k]))
        joint.limited = mujoco.mjtLimited.mjLIMITED_TRUE if bounded else mujoco.mjtLimited.mjLIMITED_FALSE
        if bounded:
            joint.range = [max(arm.lower[k], -NEVER), min(arm.upper[k], NEVER)]
            joint.solref_limit = [LIMIT_TIME, 1.0]
        joint.actfrclimited = mujoco.mjtLimited.mjLIMITED_FALSE
        motor = spec.add_actuator(name=f"motor of {name}", trntype=mujoco.mjtTrn.mjTRN_JOINT, target=name)
        motor.set_to_motor()
        if clamped and np.isfinite(arm.effort_limit[k]):
            motor.forcelimited = mujoco.mjtLimited.mjLIMITED_TRUE
            motor.forcerange = [-arm.effort_limit[k], arm.effort_limit[k]]

    def _furnish(self, spec: Any) -> None:
        """Put shapes on the arm that touch the world, the world around it, and the payload in its hand."""
        furnisher, world, limb = Furnisher(self._mujoco, spec, self.arm), self.world, self.arm.limb
        self.R_root_base, self.p_root_base = furnisher.R_root_base, furnisher.p_root_base
        self._tip_site = furnisher.local_point(6, limb.T_base_tip_zero[:3, 3])[1]
        self._elbow_site = furnisher.local_point(2, limb.elbow)[1]
        furnisher.put_ball(world.tip_radius)
        self.touches_by = furnisher.put_arm(world) if world.meets_the_arm else "tip"
        for wall in world.walls:
            furnisher.put_wall(wall)
        for peg in world.pegs:
            furnisher.put_peg(peg)
        for box in world.boxes:
            furnisher.put_box(box)
        if world.payload is not None:
            furnisher.put_payload(world.payload)
