"""`srs-ik plot`: a picture of an arm, in a file."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from srs_ik.cli.chosen import Chosen, choosing
from srs_ik.cli.options import Source, WrongInput, fail
from srs_ik.cli.picture import check, save
from srs_ik.cli.poses import NoLimits, PoseOfQ, Quat, Rpy, Xyz, read_pose, unit_of

if TYPE_CHECKING:
    from srs_ik.arm import Arm


class Kind(StrEnum):
    """What is drawn."""

    ellipsoids = "ellipsoids"
    arm_angle = "arm-angle"
    intervals = "intervals"


class Part(StrEnum):
    """Rows of the Jacobian; both in one have no picture."""

    linear = "linear"
    angular = "angular"


@choosing
def plot(
    kind: Annotated[
        Kind,
        typer.Argument(
            help="The arm with its ellipsoids; joint angles, manipulability and limit margin against the arm angle; or "
            "the feasible arm angles of each branch.",
            show_default=False,
        ),
    ],
    source: Source,
    chosen: Chosen,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "--out", metavar="FILE.png", help="The picture (png, pdf, svg, ...); has to be given."
        ),
    ] = None,
    xyz: Xyz = None,
    rpy: Rpy = None,
    quat: Quat = None,
    q: PoseOfQ = None,
    branch: Annotated[
        int | None, typer.Option(metavar="0..7", help="Branch of 'arm-angle'; that of 'srs-ik solve' if not given.")
    ] = None,
    part: Annotated[
        Part | None, typer.Option(help="Part of 'ellipsoids': linear (if not given) or angular.", show_default=False)
    ] = None,
    limits: Annotated[
        bool, typer.Option("--limits", help="Weigh the joints of 'ellipsoids' by the arm's own limits.")
    ] = False,
    no_limits: NoLimits = False,
    degrees: Annotated[bool, typer.Option("--degrees", help="Angles are given in degrees (--rpy, --q).")] = False,
) -> None:
    """Draw a picture of an arm at a pose into a file (extra 'plot').

    'ellipsoids' shows the posture of --q itself, or at a pose the one that 'srs-ik solve' finds. Exit status 1 if
    there is none.
    """
    if output is None:
        raise WrongInput("name the picture: --output FILE.png")
    if branch is not None and branch not in range(8):
        raise WrongInput(f"--branch is a whole number from 0 to 7, not {branch}")
    for option, given, of in (
        ("--branch", branch is not None, Kind.arm_angle),
        ("--part", part is not None, Kind.ellipsoids),
        ("--limits", limits, Kind.ellipsoids),
    ):
        if given and kind is not of:
            raise WrongInput(f"{option} is of '{of.value}', and changes nothing of '{kind.value}'")
    pose, angles = read_pose(xyz, rpy, quat, q, unit_of(degrees))
    check(output, "--output")

    from srs_ik import plots
    from srs_ik.loading import load

    arm = load(source, **chosen)
    if kind is Kind.ellipsoids:
        posture = angles if pose is None else _solved(arm, pose, not no_limits)
        figure = plots.plot_ellipsoids(arm, posture, limits, (part or Part.linear).value)
    else:
        if pose is None:
            pose = arm.forward_kinematics(angles).homogeneous
        found = arm.intervals(pose, respect_limits=not no_limits)
        if not found:
            fail("no posture meets the pose; 'srs-ik solve' says what is left")
        if kind is Kind.intervals:
            figure = plots.plot_intervals(arm, pose, respect_limits=not no_limits)
        else:
            figure = plots.plot_arm_angle(arm, pose, branch)
    save(figure, output)


def _solved(arm: Arm, pose: Any, respect_limits: bool) -> Any:
    solution = arm.solve(pose, respect_limits=respect_limits)
    if not solution:
        fail(solution.message)
    return solution.q
