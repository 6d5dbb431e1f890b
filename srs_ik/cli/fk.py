"""`srs-ik fk`: where the tip of an arm is."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from srs_ik.cli.chosen import Chosen, choosing
from srs_ik.cli.joint_file import GivenJoints, JointsFile, read_joints, refuse_both_or_none
from srs_ik.cli.options import AsJson, Source
from srs_ik.cli.pose_file import POSITION, QUATERNION, check_out, is_output, write_table
from srs_ik.cli.poses import angles, unit_of

if TYPE_CHECKING:
    import numpy as np

    from srs_ik.arm import Arm


@choosing
def fk(
    source: Source,
    chosen: Chosen,
    q: GivenJoints = None,
    file: JointsFile = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="POSES.csv", help="Write the poses here, as 'srs-ik path' and 'solve --file' read them."),
    ] = None,
    degrees: Annotated[bool, typer.Option("--degrees", help="Joint angles are given in degrees.")] = False,
    as_json: AsJson = False,
) -> None:
    """Show the pose of the tip of an arm, in its base frame, for given joint angles.

    One configuration by --q, or those of a CSV file by --file, such as 'srs-ik path --out' and 'solve --out' write.
    """
    refuse_both_or_none(q, file)
    unit = unit_of(degrees)
    check_out(out, as_json, file)
    given = None if q is None else angles("--q", q, unit)

    import numpy as np

    from srs_ik.loading import load

    arm = load(source, **chosen)
    configurations = read_joints(file, arm.joint_names, unit) if file is not None else np.array([given])
    poses = arm.forward_kinematics_batch(configurations)
    if out is not None:
        write_table(out, (*POSITION, *QUATERNION), ([*xyz, *quaternion] for xyz, quaternion in map(_parts, poses)))
    if as_json:
        _print_json(arm, configurations, poses, many=file is not None)
    elif not is_output(out):
        _print_table(arm, poses)


def _parts(T: np.ndarray) -> tuple[list[float], list[float]]:
    """Position and quaternion, the scalar part last."""
    from srs_ik.inputs.poses import xyz_quaternion

    xyz, quaternion = xyz_quaternion(T, order="xyzw")
    return xyz.tolist(), quaternion.tolist()


def _print_json(arm: Arm, configurations: np.ndarray, poses: np.ndarray, many: bool) -> None:
    from srs_ik.cli.render import heading, print_json

    q, T = (configurations, poses) if many else (configurations[0], poses[0])
    print_json({**heading(arm), "q": q, "T_base_tip": T})


def _print_table(arm: Arm, poses: np.ndarray) -> None:
    import pinocchio as pin

    from srs_ik.cli.render import console, fixed, table

    rows = []
    for k, T in enumerate(poses, 1):
        xyz, quaternion = _parts(T)
        rpy = pin.rpy.matrixToRpy(T[:3, :3]).tolist()
        rows.append((str(k), *(fixed(x, 9) for x in (*xyz, *rpy, *quaternion))))
    out = console()
    out.print(f"{arm.name}: {arm.tip} in {arm.base}, metres and radians")
    out.print(table(("", *POSITION, "roll", "pitch", "yaw", *QUATERNION), rows))
