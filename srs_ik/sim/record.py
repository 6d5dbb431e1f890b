"""What a simulation leaves behind, as arrays."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np

from srs_ik.arm import Arm
from srs_ik.errors import InvalidController, quoted
from srs_ik.inputs.control import positive, thing
from srs_ik.inputs.poses import PoseLike, as_rigid_matrix
from srs_ik.robot.limb import Vector
from srs_ik.sim.world import World

_WIDTHS = {"t": 0, "q": 7, "v": 7, "torque": 7, "weight": 7, "potential": 0, "kinetic": 0, "stored": 0, "contact": 3}
"""Columns of the arrays of a record; 0: a figure a sample."""


@dataclass(frozen=True, eq=False)
class Record:
    """A motion, one row a sample; n samples.

    Attributes:
        arm: the arm that moved.
        t: (n,) s.
        q: (n, 7) joint angles, rad.
        v: (n, 7) joint speeds, rad/s.
        torque: (n, 7) what the controller asked for when the sample was taken, N m.
        weight: (n, 7) the part of it that held the arm's weight, N m; zero for a controller that does not tell.
        potential: (n,) energy of gravity at `q`, J.
        kinetic: (n,) at `q` and `v`, J.
        stored: (n,) energy of the controller's profiles, J; zero for a controller that has none.
        contact: (n, 3) force of the world on the arm at `q` and `v`, under the torques until then, N, base axes.
        world: what stood around it.

    Raises:
        InvalidController: a thing of another class, or arrays whose rows are not as many.
    """

    arm: Arm
    t: Vector
    q: Vector
    v: Vector
    torque: Vector
    weight: Vector
    potential: Vector
    kinetic: Vector
    stored: Vector
    contact: Vector
    world: World = field(default_factory=World)

    def __post_init__(self) -> None:
        thing(self.arm, Arm, "arm", "srs_ik.load")
        thing(self.world, World, "world")
        n = self.t.size if isinstance(self.t, np.ndarray) else 0
        for name, width in _WIDTHS.items():
            array = getattr(self, name)
            shape = (n, width) if width else (n,)
            if not isinstance(array, np.ndarray) or array.shape != shape or array.dtype.kind != "f":
                raise InvalidController(f"{name} of a record has to be an array of floats of shape {shape}")

    @cached_property
    def poses(self) -> Vector:
        """(n, 4, 4) of the tip in the base frame."""
        return self.arm.forward_kinematics_batch(self.q)

    @property
    def tip(self) -> Vector:
        """(n, 3) tip point, m."""
        return self.poses[:, :3, 3]

    @cached_property
    def elbow(self) -> Vector:
        """(n, 3) elbow centre, m."""
        return self.arm.centres(self.q).elbow

    @cached_property
    def speed(self) -> Vector:
        """(n,) of the tip point, m/s."""
        J = self.arm.jacobian_batch(self.q)
        return np.linalg.norm(np.einsum("nij,nj->ni", J[:, :3], self.v), axis=1)

    @cached_property
    def work(self) -> Vector:
        """(n,) work that all but gravity's compensation has done on the arm until each sample, J.

        A torque is held until the next sample, and does work by the mean of both speeds: for constant forces that is
        the change of kinetic energy without error, where every time step is recorded and no torque is late.
        """
        way = 0.5 * (self.v[1:] + self.v[:-1]) * np.diff(self.t)[:, None]
        return np.append(0.0, np.cumsum(np.sum((self.torque - self.weight)[:-1] * way, axis=1)))

    def errors(self, T_base_target: PoseLike) -> tuple[Vector, Vector]:
        """Distance (n,), m, and angle (n,), rad, from a pose.

        Raises:
            InvalidPose: the target is no finite rigid transform.
        """
        T_base_target = as_rigid_matrix(T_base_target)
        turn = np.einsum("nji,jk->nik", self.poses[:, :3, :3], T_base_target[:3, :3])
        skew = np.stack(
            [turn[:, 2, 1] - turn[:, 1, 2], turn[:, 0, 2] - turn[:, 2, 0], turn[:, 1, 0] - turn[:, 0, 1]], axis=1
        )
        angle = np.arctan2(np.linalg.norm(skew, axis=1), np.trace(turn, axis1=1, axis2=2) - 1.0)
        return np.linalg.norm(self.tip - T_base_target[:3, 3], axis=1), angle

    def __repr__(self) -> str:
        last = self.t[-1] if len(self.t) else 0.0
        return f"Record({self.arm.name}: {len(self.t)} samples, to {last:.4g} s)"

    def replay(self, path: str | Path, rate: float = 30.0, target: PoseLike | None = None) -> Path:
        """Write the motion, with the world around it, as one HTML page that plays without a server.

        Args:
            path: where the page is to be, a file that ends in .html.
            rate: samples of the record that are shown a second.
            target: pose of the tip that is shown as a frame.

        Returns:
            The path.

        Raises:
            InvalidPose: the target is no finite rigid transform.
            PreviewError: the page cannot be written, or the path ends otherwise.
            InvalidController: no path, or a rate that is not positive.
        """
        if not isinstance(path, str | Path):
            raise InvalidController(f"the path of a replay has to be a text or a Path, not {quoted(path)}")
        positive(rate, "rate")
        from srs_ik.preview import Preview
        from srs_ik.sim.scenery import meshes

        dt = float(self.t[1] - self.t[0]) if len(self.t) > 1 else 1.0 / rate
        step = max(1, round(1.0 / (rate * dt)))
        with Preview(self.arm) as view:
            view.show_obstacles(meshes(self.world))
            if target is not None:
                view.show_target(target)
            view.animate(self.q[::step], step * dt)
            return view.save(path)
