"""`srs-ik solve`: joint angles for a pose."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from srs_ik.cli import freedom
from srs_ik.cli import objective as objectives
from srs_ik.cli.chosen import Chosen, choosing
from srs_ik.cli.options import AsJson, Seven, Source, Three, WrongInput, fail, numbers
from srs_ik.cli.pose_file import check_out, read_poses
from srs_ik.cli.poses import JOINTS, NoLimits, PoseOfQ, Quat, Rpy, Xyz, angles, read_pose, unit_of
from srs_ik.cli.scenes import Exact, Margin, Meshes, SceneFile, read, with_meshes
from srs_ik.cli.solve_file import report

if TYPE_CHECKING:
    import numpy as np
    from rich.console import Console

    from srs_ik.arm import Arm
    from srs_ik.solve.solution import Solution


@choosing
def solve(
    source: Source,
    chosen: Chosen,
    xyz: Xyz = None,
    rpy: Rpy = None,
    quat: Quat = None,
    q: PoseOfQ = None,
    arm_angle: Annotated[
        str | None, typer.Option(metavar="ANGLE", help="Arm angle of the posture; zero as 'srs-ik inspect' says.")
    ] = None,
    seed: Annotated[
        Seven | None, typer.Option(metavar=JOINTS, help="Choose the posture nearest to these joint angles.")
    ] = None,
    elbow: Annotated[
        Three | None, typer.Option(metavar="X Y Z", help="Bring the elbow as near to this point as can be, metres.")
    ] = None,
    branch: Annotated[int | None, typer.Option(metavar="0..7", help="Choose the posture from this branch.")] = None,
    free_axis: freedom.Axis = None,
    cone: freedom.Cone = None,
    objective: objectives.Name = None,
    force: objectives.Force = None,
    velocity: objectives.Velocity = None,
    twist: objectives.Twist = None,
    wrench: objectives.Wrench = None,
    reference: objectives.Reference = None,
    tolerance: objectives.Tolerance = None,
    every: Annotated[
        bool,
        typer.Option("--all", help="Print every branch at the arm angle; without one, a posture for every interval."),
    ] = False,
    file: Annotated[
        Path | None,
        typer.Option(metavar="POSES.csv", help="Solve every pose of a file as 'srs-ik path' reads it, each by itself."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="JOINTS.csv", help="With --file: write joint angles, radians, and statuses here."),
    ] = None,
    no_limits: NoLimits = False,
    scene: SceneFile = None,
    margin: Margin = None,
    exact: Exact = False,
    meshes: Meshes = None,
    degrees: Annotated[
        bool,
        typer.Option("--degrees", help="Angles are given in degrees (--rpy, --q, --arm-angle, --seed, --cone ...)."),
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Find the joint angles that bring the tip of an arm to a pose.

    The pose is --xyz with --rpy or --quat, or that of --q; --file has many. Without --arm-angle, --seed and
    --objective the posture farthest from the joint limits is chosen. Exit status 1 if there is no solution, with the
    closest posture, or if a pose of the file has none.
    """
    unit = unit_of(degrees)
    if every and (seed is not None or branch is not None):
        raise WrongInput("--all prints every solution and goes with neither --seed nor --branch")
    if branch is not None and branch not in range(8):
        raise WrongInput(f"--branch is a whole number from 0 to 7, not {branch}")
    judged = objectives.read_objective(objective, force, velocity, twist, wrench, reference, tolerance, unit)
    if elbow is not None and (every or judged or any(x is not None for x in (arm_angle, free_axis))):
        raise WrongInput("--elbow goes with none of --arm-angle, --free-axis, --objective and --all")
    point = None if elbow is None else numbers("--elbow", elbow)
    if judged is not None and (every or any(x is not None for x in (arm_angle, seed, branch))):
        raise WrongInput(
            "--objective goes with none of --arm-angle, --seed, --branch and --all: it searches all postures"
        )
    angle = None if arm_angle is None else angles("--arm-angle", [arm_angle], unit)[0]
    start = None if seed is None else angles("--seed", seed, unit)
    free = freedom.read(free_axis, cone, unit)
    if free is not None and (every or judged or any(x is not None for x in (arm_angle, branch))):
        raise WrongInput("--free-axis goes with none of --arm-angle, --branch, --objective and --all")
    if file is not None and (every or judged or xyz or rpy or quat or q):
        raise WrongInput("--file has the poses: it goes with none of --xyz, --rpy, --quat, --q, --all and --objective")
    if out is not None and file is None:
        raise WrongInput("--out writes what becomes of the poses of --file; for one pose there is --json")
    if file is not None:
        check_out(out, as_json, file)
        poses, lines = read_poses(file, unit)
    else:
        pose, configuration = read_pose(xyz, rpy, quat, q, unit, free is not None and free.cone == math.pi)

    around = read(scene, margin, exact)

    from srs_ik.loading import load

    arm = with_meshes(load(source, **chosen), meshes)
    if file is not None:
        solved = arm.solve_batch(
            poses, angle, start, branch, respect_limits=not no_limits, elbow=point, free_axis=free, **around
        )
        report(arm, solved, file, lines, out, as_json)
        return
    if pose is None:
        pose = arm.forward_kinematics(configuration).homogeneous
    if every:
        found = arm.solve_all(pose, arm_angle=angle, respect_limits=not no_limits, **around)
        best = found[0] if found.failure is None else found.failure
        solutions = [solution for solution in found if solution]
    else:
        if judged is not None:
            best = arm.optimise(pose, judged, respect_limits=not no_limits, **around)
        else:
            best = arm.solve(pose, angle, start, branch, not no_limits, elbow=point, free_axis=free, **around)
        solutions = [best] if best else []

    if as_json:
        _print_json(arm, pose, best, solutions if every else None)
    else:
        _print_tables(arm, best, solutions if every and solutions else None, angle is not None)
    if not solutions:
        fail(f"{best.status.name}: {best.message}")


def _print_json(arm: Arm, pose: np.ndarray, best: Solution, solutions: list[Solution] | None) -> None:
    from srs_ik.cli.render import fields, heading, print_json

    answer = {**heading(arm), "T_base_tip": pose, **fields(best)}
    if solutions is not None:
        answer["solutions"] = [fields(s) for s in solutions]
    print_json(answer)


def _print_tables(arm: Arm, best: Solution, solutions: list[Solution] | None, at_angle: bool) -> None:
    from srs_ik.cli.render import console

    out = console()
    out.print(f"{arm.name}: {arm.tip} in {arm.base}")
    if solutions is None:
        print_solution(out, arm, best)
    else:
        _print_solutions(out, arm, solutions, at_angle)


def print_solution(out: Console, arm: Arm, solution: Solution) -> None:
    """Print the joint angles of a solution and what they are worth."""
    import numpy as np

    from srs_ik.cli.render import fixed, table
    from srs_ik.solve.optimise import Optimum

    margin = _margins(arm, solution)
    rows = [
        (name, fixed(q, 9), fixed(np.rad2deg(q), 4), fixed(np.rad2deg(m), 2))
        for name, q, m in zip(arm.joint_names, solution.q, margin, strict=True)
    ]
    out.print(table(("joint", "rad", "deg", "to the limit (deg)"), rows))
    facts = [
        ("status", solution.status.name),
        ("branch", str(solution.branch)),
        ("arm angle", f"{fixed(solution.arm_angle, 9)} rad, {fixed(math.degrees(solution.arm_angle), 4)} deg"),
        ("position error", f"{solution.position_error:.3g} m"),
        ("orientation error", f"{solution.orientation_error:.3g} rad"),
    ]
    if isinstance(solution, Optimum):
        second = "" if solution.second_value is None else f", then {solution.second_value:.9g}"
        facts.append((solution.objective.name, f"{solution.value:.9g}{second} ({solution.objective.unit})"))
    width = max(18, *(len(name) + 2 for name, _ in facts))
    out.print()
    for name, fact in facts:
        out.print(f"{name:<{width}}{fact}")


def _print_solutions(out: Console, arm: Arm, solutions: list[Solution], at_angle: bool) -> None:
    import numpy as np

    from srs_ik.cli.render import fixed, table

    rows = [
        (
            str(s.branch),
            fixed(math.degrees(s.arm_angle), 2),
            *(fixed(np.rad2deg(q), 2) for q in s.q),
            fixed(np.rad2deg(_margins(arm, s).min()), 2),
        )
        for s in solutions
    ]
    columns = ("branch", "arm angle", *(f"q{i}" for i in range(1, 8)), "to limit")
    out.print(table(columns, rows, title="all angles in degrees", left=0))
    worst = max(s.position_error for s in solutions), max(s.orientation_error for s in solutions)
    count = f"{len(solutions)} {'solution' if len(solutions) == 1 else 'solutions'}"
    meaning = "the branches at this arm angle" if at_angle else "the best of each interval of feasible arm angles"
    out.print(f"{count}, {meaning}; errors up to {worst[0]:.1e} m and {worst[1]:.1e} rad")


def _margins(arm: Arm, solution: Solution) -> np.ndarray:
    """(7,) distance of each joint to its nearer limit, radians; infinite where continuous."""
    import numpy as np

    return np.minimum(solution.q - arm.lower, arm.upper - solution.q)
