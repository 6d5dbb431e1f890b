"""`srs-ik task`: joint angles for what the hand has to do."""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, Any

import typer

from srs_ik.cli import freedom
from srs_ik.cli.chosen import Chosen, choosing
from srs_ik.cli.options import AsJson, Hand, Seven, Source, Three, WrongInput, fail, numbers
from srs_ik.cli.poses import JOINTS, NoLimits, Xyz, angles, unit_of
from srs_ik.cli.scenes import Exact, Margin, Meshes, SceneFile, read, with_meshes

if TYPE_CHECKING:
    from srs_ik.arm import Arm
    from srs_ik.solve.task import TaskSolution

DIRECTION = "X Y Z"


class Side(StrEnum):
    """Sides of a body."""

    LEFT = "left"
    RIGHT = "right"


class Tie(StrEnum):
    """Elbows of which neither is to a side."""

    LOWER = "lower"
    UPPER = "upper"


@choosing
def task(
    source: Source,
    chosen: Chosen,
    xyz: Xyz = None,
    velocity: Annotated[
        Three | None,
        typer.Option(metavar=DIRECTION, help="Direction in which the hand has to move easily, of any length."),
    ] = None,
    force: Annotated[
        Three | None, typer.Option(metavar=DIRECTION, help="Direction in which it has to bear or to push.")
    ] = None,
    grasp: Annotated[
        Three | None,
        typer.Option(
            metavar=DIRECTION, help="Direction in which the hand reaches out; without it, that of the forearm."
        ),
    ] = None,
    pronosupination: Annotated[
        Three | None,
        typer.Option(
            metavar=DIRECTION,
            help="Direction of the hand across that, which fixes its roll; without it, the most comfortable roll.",
        ),
    ] = None,
    side: Annotated[Side, typer.Option(help="Elbow towards +y of the base (left) or -y (right).")] = Side.LEFT,
    tie: Annotated[Tie, typer.Option(help="Elbow to take where one is above the other.")] = Tie.LOWER,
    seed: Annotated[
        Seven | None,
        typer.Option(metavar=JOINTS, help="Joint angles to stay near: in branch, and in a roll left free."),
    ] = None,
    hand: Hand = None,
    free_axis: freedom.Axis = None,
    cone: freedom.Cone = None,
    no_limits: NoLimits = False,
    scene: SceneFile = None,
    margin: Margin = None,
    exact: Exact = False,
    meshes: Meshes = None,
    degrees: Annotated[bool, typer.Option("--degrees", help="Angles are given in degrees (--seed, --cone).")] = False,
    as_json: AsJson = False,
) -> None:
    """Find the posture that suits a task, and the joint angles for it.

    The plane of the arm is laid into that of velocity and force as far as the target allows, which is the method of
    the source paper. Directions are in the base frame. Exit status 1 if there is no solution; the closest posture is
    printed then.
    """
    if xyz is None or velocity is None or force is None:
        raise WrongInput("a task is at least --xyz X Y Z, --velocity X Y Z and --force X Y Z")
    directions = {"velocity": velocity, "force": force, "grasp": grasp, "pronosupination": pronosupination}
    given: dict[str, Any] = {
        name: None if words is None else numbers(f"--{name}", words) for name, words in directions.items()
    }
    unit = unit_of(degrees)
    position = numbers("--xyz", xyz)
    axes = None if hand is None else numbers("--hand", hand)
    start = None if seed is None else angles("--seed", seed, unit)

    from srs_ik.inputs.task import Task
    from srs_ik.loading import load
    from srs_ik.solve.task import TaskSolution

    wanted = Task(position, **given)
    around = read(scene, margin, exact)
    free = freedom.read(free_axis, cone, unit)
    hand_axes = None if axes is None else [axes[:3], axes[3:]]
    arm = with_meshes(load(source, **chosen, hand=hand_axes), meshes)
    solution = arm.solve_task(wanted, side.value, not no_limits, tie.value, seed=start, free_axis=free, **around)
    assert isinstance(solution, TaskSolution)
    if as_json:
        _print_json(arm, solution)
    else:
        _print_tables(arm, solution)
    if not solution:
        fail(f"{solution.status.name}: {solution.message}")


def _print_json(arm: Arm, solution: TaskSolution) -> None:
    from srs_ik.cli.render import fields, heading, print_json

    posture = solution.posture
    names = ("shoulder", "elbow", "wrist", "hand", "normal", "task_normal", "direction", "arm_angle", "reached", "miss")
    answer = {
        **heading(arm),
        "T_base_tip": solution.T_base_tip,
        **fields(solution),
        "angle_lost": solution.angle_lost,
        "side": posture.side,
        "posture": {name: getattr(posture, name) for name in names},
    }
    print_json(answer)


def _print_tables(arm: Arm, solution: TaskSolution) -> None:
    import numpy as np

    from srs_ik.cli.render import console, direction, fixed, table
    from srs_ik.cli.solve import print_solution

    out = console()
    posture = solution.posture
    out.print(f"{arm.name}: {arm.tip} in {arm.base}, {posture.side} arm")
    rows = [(name, *(fixed(x, 6) for x in getattr(posture, name))) for name in ("shoulder", "elbow", "wrist", "hand")]
    out.print(table(("posture", "x (m)", "y (m)", "z (m)"), rows))
    out.print()
    out.print(f"normal of the arm's plane {direction(posture.normal)}, of the task's {direction(posture.task_normal)}")
    out.print(posture.message)
    out.print()
    print_solution(out, arm, solution)
    lost = solution.angle_lost
    out.print(f"{'arm angle lost':<18}{fixed(lost, 9)} rad, {fixed(np.rad2deg(lost), 4)} deg")
