"""`srs-ik path`: a continuous joint path through the poses of a file."""

from __future__ import annotations

import math
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from srs_ik.cli import freedom
from srs_ik.cli.chosen import Chosen, choosing
from srs_ik.cli.options import AsJson, Seven, Source, WrongInput, fail, numbers, warn
from srs_ik.cli.picture import check, save
from srs_ik.cli.pose_file import check_out, is_output, read_poses, write_motion, write_path
from srs_ik.cli.poses import JOINTS, angles, unit_of
from srs_ik.cli.scenes import Exact, Margin, Meshes, SceneFile, read, with_meshes
from srs_ik.cli.waiting import at_work

if TYPE_CHECKING:
    import numpy as np

    from srs_ik.arm import Arm
    from srs_ik.solve.path.solution import PathSolution


class Least(StrEnum):
    """What a path makes least."""

    sum_of_squares = "sum_of_squares"
    largest_step = "largest_step"
    time = "time"


@choosing
def path(
    source: Source,
    chosen: Chosen,
    poses: Annotated[
        Path,
        typer.Argument(
            metavar="FILE.csv",
            help="Poses of the tip, one a line; the header names x, y, z and roll, pitch, yaw or qx, qy, qz, qw.",
            show_default=False,
        ),
    ],
    seed: Annotated[
        Seven | None, typer.Option(metavar=JOINTS, help="Start near these joint angles; anywhere if not given.")
    ] = None,
    start: Annotated[
        Seven | None, typer.Option(metavar=JOINTS, help="Joint angles held at the first pose: where the robot stands.")
    ] = None,
    free_axis: freedom.Axis = None,
    cone: freedom.Cone = None,
    dt: Annotated[
        str | None,
        typer.Option(
            metavar="SECONDS", help="Time between two poses: keep the velocity limits where a path is found so."
        ),
    ] = None,
    longest_step: Annotated[
        str | None, typer.Option(metavar="ANGLE", help="A joint step beyond this is a break; 0.5 rad if not given.")
    ] = None,
    objective: Annotated[
        Least, typer.Option(help="What is least among the paths with the fewest breaks.")
    ] = Least.sum_of_squares,
    velocity: Annotated[
        str | None,
        typer.Option(
            metavar="RAD/S",
            help="Largest velocity of every joint, or seven with commas between them; the robot's if not given.",
        ),
    ] = None,
    acceleration: Annotated[
        str | None,
        typer.Option(
            metavar="RAD/S2",
            help="With --objective time: largest acceleration of every joint, or seven with commas between them. "
            "Times in --out and --json are then its own, whatever --dt.",
        ),
    ] = None,
    closed: Annotated[
        bool, typer.Option("--closed", help="End in the posture of the beginning; the last pose is the first one.")
    ] = False,
    plot: Annotated[
        Path | None,
        typer.Option(metavar="FILE.png", help="Draw the feasible arm angles along the path, and the path in them."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE.csv", help="Write the joint angles here, radians, if there is no break."),
    ] = None,
    period: Annotated[
        str | None,
        typer.Option(
            metavar="SECONDS",
            help="With --out: write a motion through the postures, once in every period, from rest to rest inside the "
            "limits of --dt or --acceleration, with joint velocities.",
        ),
    ] = None,
    degrees: Annotated[
        bool,
        typer.Option("--degrees", help="Angles are given in degrees (roll, pitch, yaw, --seed, --acceleration ...)."),
    ] = False,
    scene: SceneFile = None,
    margin: Margin = None,
    exact: Exact = False,
    meshes: Meshes = None,
    as_json: AsJson = False,
) -> None:
    """Find a continuous joint path through many poses, inside the joint limits, chosen as a whole.

    With a scene, the straight lines of joint angles between the postures hit nothing either, for certain. Exit status 1
    where the path has to break; a line on standard error says at which pose, and why, and another one where velocity
    limits are passed within --dt.
    """
    unit = unit_of(degrees)
    if plot is not None:
        check(plot, "--plot")
    options: dict[str, object] = {"objective": objective.value, "closed": closed}
    free = freedom.read(free_axis, cone, unit)
    if free is not None:
        options["free_axis"] = free
    if seed is not None:
        options["seed"] = angles("--seed", seed, unit)
    if start is not None:
        options["known"] = {0: angles("--start", start, unit)}
    limits = None if velocity is None else [unit * each for each in _for_each_joint("--velocity", velocity)]
    if limits is not None and dt is None and objective is not Least.time:
        raise WrongInput("--velocity goes with --dt, or with --objective time")
    if dt is not None:
        options["dt"] = _positive("--dt", dt)
    if longest_step is not None:
        _positive("--longest-step", longest_step)
        (options["longest_step"],) = angles("--longest-step", [longest_step], unit)
    if acceleration is not None:
        options["acceleration_limit"] = [unit * each for each in _accelerations(acceleration, objective)]
    # With --objective time the robot may have limits of acceleration itself.
    timed = dt is not None or acceleration is not None or objective is Least.time
    if period is not None and (out is None or not timed):
        raise WrongInput("--period is of the motion in --out, and goes with --dt or --acceleration")
    every = None if period is None else _positive("--period", period)
    check_out(out, as_json, poses)
    T_base_tip, lines = read_poses(poses, unit, options.get("dt"))  # type: ignore[arg-type]
    around = read(scene, margin, exact)

    from srs_ik.loading import load

    arm = with_meshes(load(source, **chosen), meshes)
    if limits is not None:
        arm = arm.with_limits(velocity=limits)
    if period is not None and dt is None and acceleration is None and min(arm.acceleration_limit) == math.inf:
        raise WrongInput("--period goes with --dt or --acceleration, or with limits of acceleration of the robot")
    if start is not None:
        _check_start(arm, T_base_tip[0], options["known"][0], f"{poses}, line {lines[0]}")  # type: ignore[index]
    with at_work(f"a path through {len(T_base_tip)} poses"):
        found = arm.solve_path(T_base_tip, **options, **around)  # type: ignore[arg-type]
    if out is not None and found and every is None:
        write_path(out, arm, found, _times(found, options.get("dt")))
    elif out is not None and found and every is not None:
        motion = found.trajectory()
        write_motion(out, arm, motion.sample(every))
        if motion.stretch > 1.0:
            warn(f"the motion in {out} takes {motion.stretch:.4g} times the path's own times, to keep the limits")
    if plot is not None:
        from srs_ik.plots import plot_path

        save(plot_path(arm, T_base_tip, found, **around), plot)
    if as_json:
        _print_json(arm, found, lines)
    elif not is_output(out):
        _print_table(arm, found)
    if not found:
        first, others = found.breaks[0], len(found.breaks) - 1
        more = f" ({others} more)" if others else ""
        fail(f"{poses}, line {lines[first.sample]}: {first.message}{more}")
    if found.velocity_use is not None and (found.velocity_use > 1.0).any():
        _tell_passed(arm, found, f"{poses}, line {lines[int(found.velocity_use.argmax()) + 1]}")
    if out is not None and dt is not None and found.times is not None:
        whose = "--acceleration" if acceleration is not None else "the robot's limits of acceleration"
        warn(f"the times in {out} are those of {whose}, not --dt apart")


def _tell_passed(arm: Arm, found: PathSolution, place: str) -> None:
    """Say which joint passes its velocity limit most."""
    use = found.velocity_use
    assert use is not None
    step = int(use.argmax())
    joint = arm.joint_names[int((abs(found.steps[step]) / arm.velocity_limit).argmax())]
    warn(
        f"{place}: no path was found that keeps the velocity limits within --dt: "
        f"joint {joint} takes {use[step]:.4g} times its own"
    )


def _positive(option: str, word: str) -> float:
    (figure,) = numbers(option, [word])
    if not figure > 0.0:
        raise WrongInput(f"{option} takes a positive number, not {word}")
    return figure


def _accelerations(word: str, objective: Least) -> list[float]:
    if objective is not Least.time:
        raise WrongInput(f"--acceleration goes with --objective time, not with {objective.value}")
    return _for_each_joint("--acceleration", word)


def _for_each_joint(option: str, word: str) -> list[float]:
    """Seven figures of an option that takes one for all joints, or one for each."""
    words = word.split(",")
    if len(words) not in (1, 7):
        raise WrongInput(f"{option} takes one number, or 7 with commas between them, not {len(words)}")
    found = [_positive(option, each) for each in words]
    return found * 7 if len(found) == 1 else found


def _times(found: PathSolution, dt: object) -> list[float] | None:
    """When the path passes its poses, s, where that is known."""
    if found.times is not None:
        return [float(t) for t in found.times]
    return [i * dt for i in range(len(found))] if isinstance(dt, float) else None


def _check_start(arm: Arm, pose: np.ndarray, q: list[float], where: str) -> None:
    from srs_ik.solve.path.ask import ON_POSE

    off = arm.verify(pose, q)
    if max(off) > ON_POSE:
        by = f"{1e3 * off.position:.3g} mm and {off.orientation:.3g} rad"
        raise WrongInput(f"--start is not at the first pose, {where}: it misses it by {by}; --seed begins near it")


def _print_json(arm: Arm, found: PathSolution, lines: list[int]) -> None:
    from srs_ik.cli.render import heading, print_json

    print_json(
        {
            **heading(arm),
            "q": found.q,
            "status": [found[i].status.name for i in range(len(found))],
            "branch": found.branch,
            "arm_angle": found.arm_angle,
            "largest_step": found.largest_step,
            "value": found.value,
            "times": found.times,
            "velocity_use": found.velocity_use,
            "breaks": [
                {
                    "sample": b.sample,
                    "line": lines[b.sample],
                    "joint": b.joint,
                    "jump": b.jump,
                    "earliest": b.earliest,
                    "latest": b.latest,
                    "bodies": b.bodies,
                    "message": b.message,
                }
                for b in found.breaks
            ],
        }
    )


def _print_table(arm: Arm, found: PathSolution) -> None:
    """For every joint the range that it goes through, and its largest step."""
    import numpy as np

    from srs_ik.cli.render import console, fixed, table

    steps = np.abs(found.steps).max(axis=0, initial=0.0)
    rows = [
        (name, *(fixed(math.degrees(angle), 4) for angle in (first, least, most, step)))
        for name, first, least, most, step in zip(
            arm.joint_names, found.q[0], found.q.min(axis=0), found.q.max(axis=0), steps, strict=True
        )
    ]
    out = console()
    out.print(f"{arm.name}: {arm.tip} in {arm.base}, {len(found)} {'pose' if len(found) == 1 else 'poses'}")
    out.print(table(("joint", "first (deg)", "least", "most", "largest step"), rows))
    worst = found.position_error.max(), found.orientation_error.max()
    breaks = f"{len(found.breaks)} {'break' if len(found.breaks) == 1 else 'breaks'}"
    takes = "" if found.times is None else f"; {found.times[-1]:.4g} s from rest to rest"
    out.print(f"{breaks}; errors up to {worst[0]:.1e} m and {worst[1]:.1e} rad{takes}")
