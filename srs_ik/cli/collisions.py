"""`srs-ik collisions`: what given joint angles hit, and the way from each to the next."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from srs_ik.cli.chosen import Chosen, choosing
from srs_ik.cli.joint_file import GivenJoints, JointsFile, read_joints, refuse_both_or_none
from srs_ik.cli.options import AsJson, Source, WrongInput, fail, numbers
from srs_ik.cli.poses import angles, unit_of
from srs_ik.cli.scenes import Meshes, with_meshes

if TYPE_CHECKING:
    from srs_ik.solve.in_scene.edges import PathCollision
    from srs_ik.solve.solution import Collision


@choosing
def collisions(
    source: Source,
    chosen: Chosen,
    q: GivenJoints = None,
    file: JointsFile = None,
    path: Annotated[
        bool, typer.Option("--path", help="With --file: straight lines from each posture to the next as well.")
    ] = False,
    scene: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="What stands around the arm, as JSON or YAML; the arm alone if not given."),
    ] = None,
    margin: Annotated[str, typer.Option(metavar="M", help="What is to be left between two bodies, metres.")] = "0",
    meshes: Meshes = None,
    degrees: Annotated[bool, typer.Option("--degrees", help="Joint angles are given in degrees.")] = False,
    as_json: AsJson = False,
) -> None:
    """Tell which bodies of an arm, and of what stands around it, meet at given joint angles, by their real shapes.

    One posture by --q, or those of a CSV file by --file, such as 'srs-ik path --out' and 'follow --out' write. Exit
    status 1 if something meets.
    """
    refuse_both_or_none(q, file)
    if path and file is None:
        raise WrongInput("--path goes with --file JOINTS.csv")
    unit = unit_of(degrees)
    given = None if q is None else angles("--q", q, unit)
    left = numbers("--margin", [margin])[0]

    import numpy as np

    from srs_ik.collision.scenes.scene import Scene
    from srs_ik.loading import load

    around = Scene() if scene is None else Scene.from_file(scene)
    arm = with_meshes(load(source, **chosen), meshes)
    postures = read_joints(file, arm.joint_names, unit) if file is not None else np.array([given])
    if path:
        found = [_on_line(each) for each in arm.path_collisions(postures, around, left)]
    else:
        each = ((k, arm.collision(posture, around, left)) for k, posture in enumerate(postures))
        found = [_at_posture(k, hit) for k, hit in each if hit is not None]
    if as_json:
        from srs_ik.cli.render import heading, print_json

        print_json({**heading(arm), "postures": len(postures), "collisions": found})
    elif found:
        _print_table(found)
    where = "line" if path and len(postures) > 1 else "posture"
    count = len(postures) - (where == "line")
    if found:
        fail(f"bodies meet on {len(found)} of {count} {where}s" if count > 1 else f"bodies meet on the {where}")
    if not as_json:
        print(f"{count} {where if count == 1 else where + 's'}, nothing meets")


def _at_posture(k: int, hit: Collision) -> dict[str, Any]:
    return {"posture": k + 1, **hit._asdict()}


def _on_line(hit: PathCollision) -> dict[str, Any]:
    return {"posture": hit.sample + 1, "at": hit.at, **hit.collision._asdict()}


def _print_table(found: list[dict[str, Any]]) -> None:
    from srs_ik.cli.render import console, fixed, table

    rows = [(_place(each), each["first"], each["second"], fixed(1e3 * each["depth"], 2)) for each in found]
    console().print(table(("posture", "body", "body", "missing (mm)"), rows, left=3))


def _place(each: dict[str, Any]) -> str:
    """Which posture, or how far from one to the next."""
    return f"{each['posture'] + each['at']:.3f}" if "at" in each else str(each["posture"])
