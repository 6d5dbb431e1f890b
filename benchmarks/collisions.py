"""Collision-free postures beside those of peers: the same poses and scenes, share of poses solved and time.

Run: python benchmarks/collisions.py [--poses N] [--kinds table shelf box] [--solvers NAME ...] [--json FILE]

Poses are those of random collision-free postures of iiwa14, so that each has an answer, in scenes that a script makes
(`tests/scene_sets.py`). An answer counts where it meets its pose within a millimetre and a milliradian, inside the
limits, and hits nothing by `pinocchio.computeCollisions` on the shapes of the robot's own file, the same pairs watched
for everybody. Printed are poses solved, and mean and median of the processor time a pose, ms. Peers that are not
installed are left out: `pip install ssik pin-pink mink daqp roboplan`.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from arms import generator
from collision_oracle import Truth, file_of
from scene_sets import Object, geometry_of, made, scene_of

import srs_ik

MET = 1e-3
"""An answer meets its pose within this, m and rad."""

STEPS = 200
"""Steps of differential inverse kinematics at most."""

ROUNDS, LONG = 3, 5.0
"""The least time of some rounds counts, each pose by itself; of one round where that takes long, s."""

Solver = Callable[[np.ndarray], "np.ndarray | None"]


class Place:
    """An arm in a scene, and the truth about it."""

    def __init__(self, kind: str, number: int) -> None:
        self.arm = srs_ik.load("iiwa14")
        file, folders = file_of(self.arm)
        self.file, self.rng = file, generator("iiwa14" + kind, number)
        self.truth = Truth(file, self.arm, folders)
        self.objects: list[Object] = made(kind, self.arm, self.rng)
        for each in self.objects:
            self.truth.add(each.name, each.T, geometry_of(each))

    def free(self) -> np.ndarray:
        """A random posture that hits nothing."""
        while True:
            q = self.rng.uniform(self.arm.lower, self.arm.upper)
            if not self.truth.collides(q):
                return q

    def is_good(self, T: np.ndarray, q: np.ndarray | None) -> bool:
        """Whether an answer counts."""
        if q is None or (q < self.arm.lower - 1e-9).any() or (q > self.arm.upper + 1e-9).any():
            return False
        return max(self.arm.verify(T, q)) <= MET and not self.truth.collides(q)


def ours(place: Place, exact: bool) -> Solver:
    """This package, by the spheres or on the real shapes."""
    scene, blocked = scene_of(place.objects, exact=exact), srs_ik.Scene()
    # What answers where nothing is free may have to be compiled, too.
    blocked.add_sphere("all", [0.0, 0.0, 0.0], 5.0)
    place.arm.solve(place.arm.forward_kinematics(place.free()), scene=blocked)

    def call(T: np.ndarray) -> np.ndarray | None:
        found = place.arm.solve(T, scene=scene)
        return found.q if found else None

    return call


def ssik_filtered(place: Place) -> Solver:
    """All solutions that ssik samples, the first of them that hits nothing."""
    from ssik import Manipulator

    theirs = Manipulator.from_prebuilt("iiwa14")
    q = place.free()
    tool = np.linalg.inv(place.arm.forward_kinematics(q).homogeneous) @ theirs.fk(q)

    def call(T: np.ndarray) -> np.ndarray | None:
        for each in theirs.solve(T @ tool):
            answer = np.asarray(getattr(each, "q", each), dtype=float)
            inside = (answer >= place.arm.lower).all() and (answer <= place.arm.upper).all()
            if inside and not place.truth.collides(answer):
                return answer
        return None

    return call


def pink_with_barrier(place: Place) -> Solver:
    """Pink's differential inverse kinematics with its barrier between bodies, from a few free postures."""
    import pink
    from pink.barriers import SelfCollisionBarrier

    arm, truth = place.arm, place.truth
    pairs = len(truth.shapes.collisionPairs)
    barrier = SelfCollisionBarrier(n_collision_pairs=pairs, gain=20.0, safe_displacement_gain=1.0, d_min=0.002)
    task = pink.tasks.FrameTask(arm.tip, position_cost=1.0, orientation_cost=1.0)
    starts = [place.free() for _ in range(3)]

    def call(T: np.ndarray) -> np.ndarray | None:
        task.set_target(pin.SE3(T))
        for start in starts:
            configuration = pink.Configuration(
                truth.model,
                truth.model.createData(),
                arm.configuration(start, truth.model),
                collision_model=truth.shapes,
                collision_data=pin.GeometryData(truth.shapes),
            )
            for _ in range(STEPS):
                if np.abs(task.compute_error(configuration)).max() < 0.5 * MET:
                    return arm.angles(configuration.q)
                try:
                    velocity = pink.solve_ik(
                        configuration, [task], 0.1, solver="daqp", barriers=[barrier], safety_break=False
                    )
                except (pink.exceptions.PinkError, ValueError):
                    break
                configuration.integrate_inplace(velocity, 0.1)
        return None

    return call


def mink_with_barrier(place: Place) -> Solver:
    """Mink's differential inverse kinematics with its limit that avoids collisions, from a few free postures."""
    import mink
    import mujoco

    arm = place.arm
    options = '<mujoco><compiler fusestatic="false" discardvisual="true"/></mujoco></robot>'
    text = place.file.read_text().replace("</robot>", options)
    if "<collision" not in text:
        text = text.replace("<visual>", "<collision>").replace("</visual>", "</collision>")
    spec = mujoco.MjSpec.from_string(text)
    kinds = {"box": mujoco.mjtGeom.mjGEOM_BOX, "sphere": mujoco.mjtGeom.mjGEOM_SPHERE}
    base = spec.body(arm.base) or spec.worldbody
    for each in place.objects:
        geom = base.add_geom(name=each.name, type=kinds.get(each.kind, mujoco.mjtGeom.mjGEOM_CYLINDER))
        # Boxes are given by half of their edges, cylinders by radius and half of their length.
        sizes = (
            0.5 * np.array(each.size)
            if each.kind == "box"
            else np.array([each.size[0], *(0.5 * np.array(each.size[1:]))])
        )
        geom.size[: len(sizes)], geom.pos = sizes, each.T[:3, 3]
        mujoco.mju_mat2Quat(geom.quat, each.T[:3, :3].ravel())
    model = spec.compile()
    names = {each.name for each in place.objects}
    of_body: dict[str, list[int]] = {}
    for k in range(model.ngeom):
        if model.geom(k).name not in names:
            of_body.setdefault(model.body(int(model.geom_bodyid[k])).name, []).append(k)
    moved = [k for body in arm.bodies if body.joint > 0 for k in of_body[body.name]]
    pairs = [(of_body[pair.first], of_body[pair.second]) for pair in arm.pairs if pair.kept]
    limits = [
        mink.ConfigurationLimit(model),
        mink.CollisionAvoidanceLimit(model, [*pairs, (moved, [model.geom(name).id for name in names])]),
    ]
    task = mink.FrameTask(arm.tip, "body", position_cost=1.0, orientation_cost=1.0)
    starts = [place.free() for _ in range(3)]

    def call(T: np.ndarray) -> np.ndarray | None:
        task.set_target(mink.SE3.from_matrix(T))
        for start in starts:
            configuration = mink.Configuration(model, start)
            for _ in range(STEPS):
                if np.abs(task.compute_error(configuration)).max() < 0.5 * MET:
                    return configuration.q.copy()
                try:
                    velocity = mink.solve_ik(configuration, [task], 0.1, solver="daqp", limits=limits)
                except mink.MinkError:
                    break
                configuration.integrate_inplace(velocity, 0.1)
        return None

    return call


def roboplan_checked(place: Place) -> Solver:
    """RoboPlan's SimpleIk, which draws new starts until its answer hits nothing."""
    from roboplan import core, simple_ik

    arm = place.arm
    description = core.loadUrdfSceneDescription(str(place.file))
    scene = core.Scene("scene", description)
    watched = {frozenset((pair.first, pair.second)) for pair in arm.pairs if pair.kept}
    names = [body.name for body in arm.bodies]
    for i, first in enumerate(names):
        for second in names[i + 1 :]:
            scene.setCollisions(first, second, frozenset((first, second)) in watched)
    scene.addGroupFromChain("arm", arm.base, arm.tip)
    colour = np.ones(4)
    for each in place.objects:
        T = np.asfortranarray(each.T)
        if each.kind == "box":
            scene.addBoxGeometry(each.name, arm.base, core.Box(*each.size), T, colour)
        elif each.kind == "sphere":
            scene.addSphereGeometry(each.name, arm.base, core.Sphere(*each.size), T, colour)
        else:
            scene.addCylinderGeometry(each.name, arm.base, core.Cylinder(*each.size), T, colour)
    still = [body.name for body in arm.bodies if body.joint == 0]
    resting = [*still, *(each.name for each in place.objects)]
    for i, first in enumerate(resting):
        for second in resting[i + 1 :]:
            # What stands on one frame already is no pair.
            with contextlib.suppress(ValueError):
                scene.setCollisions(first, second, False)
    options = simple_ik.SimpleIkOptions(
        group_name="arm", max_time=0.5, max_restarts=50, max_linear_error_norm=1e-4, max_angular_error_norm=1e-4
    )
    solver = simple_ik.SimpleIk(scene, options)
    start, goal, found = core.JointConfiguration(), core.CartesianConfiguration(), core.JointConfiguration()
    start.positions = place.free()
    goal.base_frame, goal.tip_frame = arm.base, arm.tip

    def call(T: np.ndarray) -> np.ndarray | None:
        goal.tform = np.asfortranarray(T)
        try:
            return np.array(found.positions) if solver.solveIk(goal, start, found) else None
        except RuntimeError:  # no free start was drawn
            return None

    return call


def timed(call: Solver, T: np.ndarray) -> tuple[np.ndarray | None, float]:
    """An answer, and the processor time that it took, s."""
    begin = time.process_time()
    return call(T), time.process_time() - begin


SOLVERS = {
    "srs_ik": lambda place: ours(place, False),
    "srs_ik, exact": lambda place: ours(place, True),
    "ssik, filtered by coal": ssik_filtered,
    "Pink with a barrier, 3 starts": pink_with_barrier,
    "Mink with a barrier, 3 starts": mink_with_barrier,
    "RoboPlan SimpleIk, 50 restarts, 0.5 s": roboplan_checked,
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--poses", type=int, default=40)
    parser.add_argument("--kinds", nargs="+", default=["table", "shelf", "box"])
    parser.add_argument("--solvers", nargs="+", default=list(SOLVERS), choices=list(SOLVERS), metavar="NAME")
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    rows = []
    for kind in given.kinds:
        place = Place(kind, 30)
        poses = [place.arm.forward_kinematics(place.free()).homogeneous for _ in range(given.poses)]
        for name in given.solvers:
            try:
                call = SOLVERS[name](place)
            except ImportError as error:
                print(f"left out: {name} ({error})", file=sys.stderr)
                continue
            call(poses[0])
            begin, rounds = time.process_time(), []
            while not rounds or (len(rounds) < ROUNDS and time.process_time() - begin < LONG):
                answers, times = zip(*(timed(call, T) for T in poses), strict=True)
                rounds.append(times)
            each = 1e3 * np.min(rounds, axis=0)
            solved = sum(place.is_good(T, q) for T, q in zip(poses, answers, strict=True))
            rows.append(
                {
                    "scene": kind,
                    "solver": name,
                    "poses": len(poses),
                    "solved": solved,
                    "ms": each.mean(),
                    "median ms": np.median(each),
                }
            )
            print(
                f"| {kind} | {name} | {solved} of {len(poses)} | {each.mean():.3g} | {np.median(each):.3g} |",
                flush=True,
            )
    if given.json:
        given.json.write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
