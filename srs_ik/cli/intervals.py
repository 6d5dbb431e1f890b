"""`srs-ik intervals`: the arm angles at which a pose can be met."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from srs_ik.cli.chosen import Chosen, choosing
from srs_ik.cli.options import AsJson, Source, fail
from srs_ik.cli.poses import NoLimits, PoseOfQ, Quat, Rpy, Xyz, read_pose, unit_of
from srs_ik.cli.scenes import Exact, Margin, Meshes, SceneFile, read, with_meshes

if TYPE_CHECKING:
    import numpy as np

    from srs_ik.arm import Arm
    from srs_ik.solve.intervals import Interval


@choosing
def intervals(
    source: Source,
    chosen: Chosen,
    xyz: Xyz = None,
    rpy: Rpy = None,
    quat: Quat = None,
    q: PoseOfQ = None,
    no_limits: NoLimits = False,
    scene: SceneFile = None,
    margin: Margin = None,
    exact: Exact = False,
    meshes: Meshes = None,
    degrees: Annotated[bool, typer.Option("--degrees", help="Angles are given in degrees (--rpy, --q).")] = False,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE.png", help="Draw the intervals into this file as well (extra 'plot').")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """List the arm angles at which an arm can bring its tip to a pose, for each of the eight branches.

    An interval starts in [-pi, pi) and may pass pi; the whole circle is -pi to pi. Exit status 1 if there is none.
    """
    pose, configuration = read_pose(xyz, rpy, quat, q, unit_of(degrees))
    if plot is not None:
        from srs_ik.cli.picture import check

        check(plot, "--plot")

    around = read(scene, margin, exact)

    from srs_ik.loading import load

    arm = with_meshes(load(source, **chosen), meshes)
    if pose is None:
        pose = arm.forward_kinematics(configuration).homogeneous
    found = arm.intervals(pose, respect_limits=not no_limits, **around)
    if as_json:
        _print_json(arm, pose, found)
    elif found:
        _print_table(arm, found)
    if not found:
        where = "no posture" if no_limits else "no posture inside the joint limits"
        where += " and clear of the scene" if around else ""
        fail(f"{where} meets the pose, whatever its arm angle; 'srs-ik solve' says what is left")
    if plot is not None:
        from srs_ik.cli.picture import save
        from srs_ik.plots import plot_intervals

        save(plot_intervals(arm, pose, respect_limits=not no_limits, **around), plot)


def _print_json(arm: Arm, pose: np.ndarray, found: list[Interval]) -> None:
    from srs_ik.cli.render import print_json

    print_json(
        {
            "robot": arm.name,
            "base": arm.base,
            "tip": arm.tip,
            "T_base_tip": pose,
            "intervals": [{"branch": i.branch, "lower": i.lower, "upper": i.upper} for i in found],
        }
    )


def _print_table(arm: Arm, found: list[Interval]) -> None:
    from srs_ik.cli.render import console, fixed, table

    rows = [
        (
            str(i.branch),
            *(fixed(math.degrees(x), 4) for x in (i.lower, i.upper, i.width)),
            *(fixed(x, 9) for x in (i.lower, i.upper)),
        )
        for i in found
    ]
    columns = ("branch", "from (deg)", "to (deg)", "width (deg)", "from (rad)", "to (rad)")
    out = console()
    out.print(f"{arm.name}: arm angles for {arm.tip} in {arm.base}")
    out.print(table(columns, rows, left=0))
    branches = len({i.branch for i in found})
    count = f"{len(found)} {'interval' if len(found) == 1 else 'intervals'}"
    out.print(f"{count} in {branches} {'branch' if branches == 1 else 'branches'}")
