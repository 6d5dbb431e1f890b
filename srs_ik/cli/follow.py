"""`srs-ik follow`: joint targets for poses that come one a period, as a tracker gives them."""

from __future__ import annotations

import math
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from srs_ik.cli import freedom
from srs_ik.cli.chosen import Chosen, choosing
from srs_ik.cli.options import AsJson, Seven, Source, WrongInput, fail, is_number, numbers
from srs_ik.cli.pose_file import check_out, is_output, read_targets, write_table
from srs_ik.cli.poses import JOINTS, angles, unit_of
from srs_ik.cli.scenes import Margin, Meshes, SceneFile, read, with_meshes
from srs_ik.cli.waiting import counted

if TYPE_CHECKING:
    from srs_ik.arm import Arm
    from srs_ik.solve.tracker.step import TrackerStep
    from srs_ik.solve.tracker.tracker import Tracker


@choosing
def follow(
    source: Source,
    chosen: Chosen,
    poses: Annotated[
        Path,
        typer.Argument(
            metavar="FILE.csv",
            help="Poses of the tip, one a period, as for 'srs-ik path'; a line of nan or empty cells is a lost target.",
            show_default=False,
        ),
    ],
    dt: Annotated[str, typer.Option(metavar="SECONDS", help="Time between two poses.")],
    start: Annotated[
        Seven | None,
        typer.Option("--q", metavar=JOINTS, help="Joint angles to begin with; those of the first pose if not given."),
    ] = None,
    elbow: Annotated[
        str, typer.Option(metavar="keep|ANGLE|NAME", help="What the elbow does: keep, an arm angle, or an objective.")
    ] = "keep",
    free_axis: freedom.Axis = None,
    cone: freedom.Cone = None,
    velocity: Annotated[
        str | None, typer.Option(metavar="RAD/S", help="Largest velocity of every joint; the robot's if not given.")
    ] = None,
    acceleration: Annotated[
        str | None,
        typer.Option(
            metavar="RAD/S2",
            help="Largest acceleration, inf: none; the robot's, or to full velocity in 0.1 s, if not given.",
        ),
    ] = None,
    smoothing: Annotated[
        str | None,
        typer.Option(
            metavar="SECONDS",
            help="Time constant of a filter that takes jitter from the poses, 0: none; by their noise if not given.",
        ),
    ] = None,
    scene: SceneFile = None,
    margin: Margin = None,
    meshes: Meshes = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE.csv", help="Write time, joint angles (rad), status and errors here.")
    ] = None,
    degrees: Annotated[
        bool, typer.Option("--degrees", help="Angles are given in degrees, also those per second (--velocity ...).")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Follow poses that come one a period, within the limits of position, velocity and acceleration of every joint.

    With a scene, the arm stops before it hits anything. Exit status 1 where the tip is not on the last target at the
    end; a line on standard error says why.
    """
    unit = unit_of(degrees)
    (period,) = numbers("--dt", [dt])
    options: dict[str, Any] = {"elbow": _elbow(elbow, unit)}
    free = freedom.read(free_axis, cone, unit)
    if free is not None:
        options["free_axis"] = free
    if smoothing is not None:
        options["smoothing"] = numbers("--smoothing", [smoothing])[0]
    if velocity is not None:
        options["velocity"] = unit * numbers("--velocity", [velocity])[0]
    if acceleration is not None:
        options["acceleration"] = (
            math.inf if acceleration.lower() in ("inf", "+inf") else unit * numbers("--acceleration", [acceleration])[0]
        )
    q0 = None if start is None else angles("--q", start, unit)
    check_out(out, as_json, poses)
    targets = read_targets(poses, unit, period)
    around = read(scene, margin)

    from srs_ik.loading import load

    arm = with_meshes(load(source, **chosen), meshes)
    begin = _start(arm, targets, {"free_axis": free} | around) if q0 is None else q0
    tracker = arm.tracker(begin, period, **options, **around)
    steps = [tracker.update(T) for T in counted(targets, "following")]
    if out is not None:
        _write(out, arm, steps, period)
    if as_json:
        _print_json(arm, tracker, steps)
    elif not is_output(out):
        _print_table(arm, tracker, steps)
    if not steps[-1]:
        fail(f"{poses}, last line: {steps[-1].message}")


def _elbow(word: str, unit: float) -> str | float:
    return angles("--elbow", [word], unit)[0] if is_number(word) else word


def _start(arm: Arm, targets: list[Any], asked: dict[str, Any]) -> Any:
    """A posture of the first target that there is."""
    first = next((T for T in targets if T is not None), None)
    found = None if first is None else arm.solve(first, **asked)
    if not found:
        why = "there is no pose in the file" if found is None else found.message
        raise WrongInput(f"no posture to begin with: {why} Give one by --q")
    return found.q


def _write(path: Path, arm: Arm, steps: list[TrackerStep], period: float) -> None:
    header = ("t", *arm.joint_names, "status", "position_error", "orientation_error", "message")
    rows = (
        [k * period, *step.q.tolist(), str(step.status), step.position_error, step.orientation_error, step.message]
        for k, step in enumerate(steps, 1)
    )
    write_table(path, header, rows)


def _largest(steps: list[TrackerStep]) -> tuple[Any, Any]:
    """Largest joint velocities and accelerations."""
    import numpy as np

    return tuple(np.abs([getattr(s, name) for s in steps]).max(axis=0) for name in ("velocity", "acceleration"))


def _print_json(arm: Arm, tracker: Tracker, steps: list[TrackerStep]) -> None:
    from srs_ik.cli.render import heading, print_json

    velocity, acceleration = _largest(steps)
    print_json(
        {
            **heading(arm),
            "dt": tracker.dt,
            "q": [step.q for step in steps],
            "status": [str(step.status) for step in steps],
            "position_error": [step.position_error for step in steps],
            "orientation_error": [step.orientation_error for step in steps],
            "largest_velocity": velocity,
            "velocity_limit": tracker.velocity_limit,
            "largest_acceleration": acceleration,
            "acceleration_limit": tracker.acceleration_limit,
            "noise": tracker.noise,
            "smoothed": tracker.smoothed,
        }
    )


def _print_table(arm: Arm, tracker: Tracker, steps: list[TrackerStep]) -> None:
    from srs_ik.cli.render import console, fixed, table

    velocity, acceleration = _largest(steps)
    figures = zip(
        arm.joint_names, velocity, tracker.velocity_limit, acceleration, tracker.acceleration_limit, strict=True
    )
    screen = console()
    screen.print(f"{arm.name}: {arm.tip} in {arm.base}, {len(steps)} poses, {len(steps) * tracker.dt:.6g} s")
    columns = ("joint", "largest velocity (rad/s)", "limit", "largest acceleration (rad/s2)", "limit")
    screen.print(table(columns, [(name, *(fixed(x, 4) for x in rest)) for name, *rest in figures]))
    counts = Counter(str(step.status) for step in steps)
    screen.print(", ".join(f"{status} {100.0 * count / len(steps):.1f} %" for status, count in counts.most_common()))
    if tracker.smoothed > 0.0:
        along, about = (f"{1e3 * x:.3g}" for x in tracker.noise)
        screen.print(f"noise of the last poses {along} mm, {about} mrad; smoothed by {1e3 * tracker.smoothed:.3g} ms")
