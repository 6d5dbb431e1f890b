"""The peers, each behind the same few lines: which call, which poses, and how to read the answer.

Every peer gets the description of this package, or axes read from it, but ssik, which brings its own two robots: its
poses are those of its own forward kinematics. Iterative solvers start at the seed, and have MOST_STEPS steps.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

import srs_ik
from srs_ik.bench.own import BATCH, Batch, best_time
from srs_ik.bench.timing import Timed, measure
from srs_ik.bench.work import Work

LOCKED = 0.4
"""Angle at which joint 3 is held for solvers of six joints, rad."""
MOST_STEPS = 100
CONVERGED = 1e-9
"""Error, m and rad, at which an iterative solver that is steered here stops."""
ROBOTS = Path(__file__).resolve().parents[1] / "robots"


def seeded(work: Work) -> dict[str, Any]:
    """Arguments and known postures of calls that start at a seed."""
    return {"arguments": list(zip(work.poses, work.seeds, strict=True)), "near": (work.q, work.seeds)}


def locked_work(arm: srs_ik.Arm, work: Work) -> list[tuple[np.ndarray]]:
    """Poses of the same postures, with joint 3 at its lock."""
    q = work.q.copy()
    q[:, 2] = LOCKED
    return [(arm.forward_kinematics(row).homogeneous,) for row in q]


def eaik_solver(arm: srs_ik.Arm) -> tuple[Any, np.ndarray]:
    """EAIK's solver with joint 3 locked, and the turn of its tip: it has the axes of the base at zero."""
    from eaik.IK_HP import HPRobot

    origins = np.vstack([np.zeros(3), arm.limb.points, arm.limb.T_base_tip_zero[:3, 3]])
    turned = np.eye(4)
    turned[:3, :3] = np.asarray(arm.limb.T_base_tip_zero)[:3, :3].T
    return HPRobot(arm.limb.axes, np.diff(origins, axis=0), [(2, LOCKED)]), turned


def eaik(arm: srs_ik.Arm, work: Work) -> Iterator[Timed]:
    """EAIK with joint 3 locked: the branches at one value of the redundancy; knows no limits."""
    solver, turned = eaik_solver(arm)
    if not solver.hasKnownDecomposition():
        return

    def call(pose: np.ndarray) -> Any:
        return solver.IK(pose)

    def postures(answer: Any) -> list[np.ndarray]:
        return [q for q, nearly in zip(answer.Q, answer.is_LS, strict=True) if not nearly]

    # The errors are those of the same posture on our own chain.
    given = [(pose @ turned,) for (pose,) in locked_work(arm, work)]
    tip_arm = arm.with_tool(turned)
    yield measure(tip_arm, "EAIK", "IK(pose), joint 3 locked, no limits", call, given, postures)


def eaik_batch(arm: srs_ik.Arm, work: Work) -> Iterator[Batch]:
    """EAIK's call for many poses."""
    solver, turned = eaik_solver(arm)
    if solver.hasKnownDecomposition():
        poses = np.array([pose @ turned for (pose,) in locked_work(arm, work)])
        poses = np.concatenate([poses] * max(1, BATCH // len(poses)))
        times = (best_time(solver.IK_batched, poses, threads) / len(poses) for threads in (1, 2))
        yield Batch(arm.name, "EAIK: IK_batched, joint 3 locked, no limits", len(poses), *times)


def ik_geo(arm: srs_ik.Arm, work: Work) -> Iterator[Timed]:
    """ik-geo's wheel with joint 3 locked, as a six-joint arm with a spherical wrist; knows no limits."""
    from ik_geo import Robot

    if arm.limb.kind != "exact":
        return
    turn = pin.AngleAxis(LOCKED, np.asarray(arm.limb.axes[2])).matrix()
    T = np.asarray(arm.limb.T_base_tip_zero)
    shoulder, wrist = np.asarray(arm.limb.shoulder), np.asarray(arm.limb.wrist)

    def moved(point: np.ndarray) -> np.ndarray:
        return shoulder + turn @ (np.asarray(point) - shoulder)

    axes = np.asarray(arm.limb.axes)
    H = np.array([axes[0], axes[1], *(turn @ a for a in axes[3:])])
    elbow, hand, tip = moved(arm.limb.points[3]), moved(wrist), moved(T[:3, 3])
    points = np.array([np.zeros(3), shoulder, shoulder, elbow, hand, hand, hand, tip])
    solver = Robot.spherical_two_intersecting(H, np.diff(points, axis=0))
    zero = turn @ T[:3, :3]
    # The wheel reads rotations column by column.
    given = [(pose, zero @ pose[:3, :3].T, pose[:3, 3].copy()) for (pose,) in locked_work(arm, work)]

    def call(pose: np.ndarray, rotation: np.ndarray, position: np.ndarray) -> Any:
        return solver.get_ik(rotation, position)

    def postures(answer: Any) -> list[np.ndarray]:
        return [np.insert(q, 2, LOCKED) for q, nearly in answer if not nearly]

    yield measure(arm, "ik-geo", "get_ik(R, p), joint 3 locked, no limits", call, given, postures)


def ssik(arm: srs_ik.Arm, work: Work) -> Iterator[Timed]:
    """ssik's own arm: the posture nearest to a seed, the default sampling, the feasible arcs of all charts."""
    from ssik import Manipulator

    theirs = Manipulator.from_prebuilt(arm.name)
    poses = [theirs.fk(q) for q in work.q]
    # Its tip may be another than ours; the same flange otherwise, so one constant transform brings it over.
    tool = np.linalg.inv(work.poses[0]) @ poses[0]
    same = arm.with_tool(tool) if np.abs(work.poses[-1] @ tool - poses[-1]).max() < 1e-6 else None

    def nearest(pose: np.ndarray, seed: np.ndarray) -> Any:
        return theirs.solve(pose, max_solutions=1, q_seed=seed, seed_metric="wrap_l2")

    def arcs(pose: np.ndarray) -> Any:
        return [arc for chart in theirs.self_motion(pose).charts for arc in chart.in_limits()]

    def postures(answer: Any) -> list[np.ndarray]:
        return [solution.q for solution in answer]

    if same is None:
        return
    given = list(zip(poses, work.seeds, strict=True))
    name = "solve(pose, seed), one answer"
    yield measure(same, "ssik", name, nearest, given, postures, (work.q, work.seeds))
    alone = [(pose,) for pose in poses]
    yield measure(same, "ssik", "solve(pose)", theirs.solve, alone, postures)
    try:
        theirs.self_motion(poses[0])
    except NotImplementedError:
        return
    yield measure(same, "ssik", "self_motion(pose), in_limits()", arcs, alone, None)


def pinocchio(arm: srs_ik.Arm, work: Work) -> Iterator[Timed]:
    """The closed-loop inverse kinematics of Pinocchio's examples: Newton steps in Python; knows no limits."""
    model, frame = arm.model, arm.model.getFrameId(arm.tip)
    data = model.createData()

    def call(pose: np.ndarray, seed: np.ndarray) -> np.ndarray | None:
        q, goal = arm.configuration(seed), pin.SE3(pose)
        for _ in range(MOST_STEPS):
            pin.framesForwardKinematics(model, data, q)
            miss = data.oMf[frame].actInv(goal)
            error = pin.log6(miss).vector
            if np.abs(error).max() < CONVERGED:
                return q
            J = -pin.Jlog6(miss.inverse()) @ pin.computeFrameJacobian(model, data, q, frame, pin.LOCAL)
            step = -J.T @ np.linalg.solve(J @ J.T + 1e-12 * np.eye(6), error)
            q = pin.integrate(model, q, step)
        return None

    def postures(answer: np.ndarray | None) -> list[np.ndarray]:
        return [] if answer is None else [arm.angles(answer)]

    yield measure(arm, "pin", "CLIK from the seed, no limits", call, postures=postures, **seeded(work))


def roboticstoolbox(arm: srs_ik.Arm, work: Work) -> Iterator[Timed]:
    """Levenberg-Marquardt of the Robotics Toolbox, compiled: one search from the seed, asked for 1e-18."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import roboticstoolbox as rtb

        chain = rtb.Robot.URDF(str(ROBOTS / arm.name / f"{arm.name}.urdf")).ets(end=arm.tip)
    if chain.n != 7:
        return

    def call(pose: np.ndarray, seed: np.ndarray) -> Any:
        return chain.ik_LM(pose, q0=seed, ilimit=MOST_STEPS, slimit=1, tol=1e-18, joint_limits=False)

    def postures(answer: Any) -> list[np.ndarray]:
        return [answer[0]] if answer[1] else []

    name = "ik_LM(pose, q0), no limits"
    yield measure(arm, "roboticstoolbox-python", name, call, postures=postures, **seeded(work))


def pink(arm: srs_ik.Arm, work: Work) -> Iterator[Timed]:
    """Pink's differential inverse kinematics, a quadratic programme with limits a step, until it meets the pose."""
    import pink as package

    task = package.tasks.FrameTask(arm.tip, position_cost=1.0, orientation_cost=1.0)

    def call(pose: np.ndarray, seed: np.ndarray) -> np.ndarray | None:
        configuration = package.Configuration(arm.model, arm.model.createData(), arm.configuration(seed))
        task.set_target(pin.SE3(pose))
        for _ in range(MOST_STEPS):
            if np.abs(task.compute_error(configuration)).max() < CONVERGED:
                return configuration.q
            velocity = package.solve_ik(configuration, [task], 1.0, solver="daqp", safety_break=False)
            configuration.integrate_inplace(velocity, 1.0)
        return None

    def postures(answer: np.ndarray | None) -> list[np.ndarray]:
        return [] if answer is None else [arm.angles(answer)]

    yield measure(arm, "pin-pink", "solve_ik from the seed, daqp", call, postures=postures, **seeded(work))


def mink(arm: srs_ik.Arm, work: Work) -> Iterator[Timed]:
    """Mink's differential inverse kinematics on MuJoCo, a quadratic programme with limits a step."""
    import mink as package
    import mujoco

    text = (ROBOTS / arm.name / f"{arm.name}.urdf").read_text()
    options = '<mujoco><compiler fusestatic="false" discardvisual="true"/></mujoco></robot>'
    model = mujoco.MjModel.from_xml_string(text.replace("</robot>", options))
    if model.nq != 7:
        return
    task = package.FrameTask(arm.tip, "body", position_cost=1.0, orientation_cost=1.0)
    limits = [package.ConfigurationLimit(model)]
    configuration = package.Configuration(model)

    def call(pose: np.ndarray, seed: np.ndarray) -> np.ndarray | None:
        configuration.update(seed)
        task.set_target(package.SE3.from_matrix(pose))
        for _ in range(MOST_STEPS):
            if np.abs(task.compute_error(configuration)).max() < CONVERGED:
                return configuration.q.copy()
            velocity = package.solve_ik(configuration, [task], 1.0, solver="daqp", limits=limits)
            configuration.integrate_inplace(velocity, 1.0)
        return None

    def postures(answer: np.ndarray | None) -> list[np.ndarray]:
        return [] if answer is None else [answer]

    yield measure(arm, "mink", "solve_ik from the seed, daqp", call, postures=postures, **seeded(work))


PEERS = {
    "eaik": eaik,
    "ik_geo": ik_geo,
    "ssik": ssik,
    "pinocchio": pinocchio,
    "roboticstoolbox": roboticstoolbox,
    "pink": pink,
    "mink": mink,
}
"""By the name of the module that has to be there."""
