"""`srs-ik preview`: an arm in the browser, or in one HTML file."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from srs_ik.cli.chosen import Chosen, choosing
from srs_ik.cli.options import Seven, Source, WrongInput, fail
from srs_ik.cli.poses import JOINTS, Quat, Rpy, Xyz, angles, read_pose, unit_of
from srs_ik.cli.scenes import Margin, Meshes, SceneFile, read, with_meshes

if TYPE_CHECKING:
    import numpy as np

    from srs_ik.arm import Arm
    from srs_ik.preview.view import Preview


@choosing
def preview(
    source: Source,
    chosen: Chosen,
    q: Annotated[Seven | None, typer.Option("--q", metavar=JOINTS, help="Joint angles to show.")] = None,
    xyz: Xyz = None,
    rpy: Rpy = None,
    quat: Quat = None,
    ellipsoids: Annotated[
        bool, typer.Option("--ellipsoids", help="Show the ellipsoids of velocity and force at the tip.")
    ] = False,
    ghosts: Annotated[
        bool, typer.Option("--ghosts", help="Show a posture of each other branch, as pale copies of the arm.")
    ] = False,
    self_motion: Annotated[
        bool, typer.Option("--self-motion", help="Move the arm through its arm angles while the tip stays.")
    ] = False,
    scene: SceneFile = None,
    margin: Margin = None,
    save: Annotated[
        Path | None,
        typer.Option(metavar="FILE.html", help="Write the scene as one file that needs no server, and leave."),
    ] = None,
    interactive: Annotated[
        bool, typer.Option("--interactive", help="A page with a target, a list of branches and a slider to play with.")
    ] = False,
    follow: Annotated[
        bool, typer.Option("--follow", help="A page with a target to drag, which the arm follows within its limits.")
    ] = False,
    meshes: Meshes = None,
    port: Annotated[int, typer.Option(metavar="PORT", help="Port of the page; 0 for any that is free.")] = 0,
    degrees: Annotated[bool, typer.Option("--degrees", help="Angles are given in degrees (--q, --rpy).")] = False,
) -> None:
    """Show an arm in the browser, on a page that this machine alone can open, until Ctrl+C.

    With a pose, --xyz with --rpy or --quat, the posture farthest from the joint limits is shown, and the feasible arm
    angles as arcs around the circle of the elbow. With --scene, its objects are shown too, the arm's bodies in the
    colour of their clearance, and the arm angles that they forbid; with --follow, the arm stops before them. Exit
    status 1 if there is no posture.
    """
    _check(save, interactive, follow, ellipsoids or ghosts or self_motion, port)
    if interactive and scene is not None:
        raise WrongInput("--interactive is a page that shows no scene, and goes with no --scene")
    if q is not None and (xyz or rpy or quat):
        raise WrongInput("--q is a posture already and goes with none of --xyz, --rpy and --quat")
    unit = unit_of(degrees)
    shown = None if q is None else angles("--q", q, unit)
    pose = read_pose(xyz, rpy, quat, None, unit)[0] if xyz or rpy or quat else None

    around = read(scene, margin)

    from srs_ik.loading import load

    arm = with_meshes(load(source, **chosen), meshes)
    if pose is not None:
        solution = arm.solve(pose, **around)
        if not solution:
            fail(f"{solution.status.name}: {solution.message}")
        shown = solution.q.tolist()
    if follow:
        from srs_ik.preview.live.following import FollowingPreview

        with FollowingPreview(arm, shown, package_dirs=meshes or (), port=port, **around) as following:
            _serve(following)
        return
    if interactive:
        from srs_ik.preview.live.interactive import InteractivePreview

        with InteractivePreview(arm, shown, meshes or (), port) as page:
            _serve(page)
        return

    from srs_ik.preview import Preview

    with Preview(arm, meshes or (), port) as view:
        _draw(view, arm, shown, pose, ellipsoids, ghosts, self_motion)
        if around:
            view.show_scene(**around)
            view.show_intervals(arm.forward_kinematics(view.q) if pose is None else pose, **around)
        if save is None:
            _serve(view)
        else:
            _say_missing(view)
            typer.echo(view.save(save))


def _check(save: Path | None, interactive: bool, follow: bool, marked: bool, port: int) -> None:
    if (interactive or follow) and (save is not None or marked):
        others = "--save, --ellipsoids, --ghosts and --self-motion"
        option = "--follow" if follow else "--interactive"
        raise WrongInput(f"{option} is a page that answers, and goes with none of {others}")
    if port not in range(65536):
        raise WrongInput(f"--port is a number from 0 to 65535, not {port}")
    if save is not None and save.suffix.lower() not in (".html", ".htm"):
        raise WrongInput(f"--save writes a web page: give it a name such as scene.html, not {str(save)!r}")
    if save is not None and not save.absolute().parent.is_dir():
        raise WrongInput(f"--save: there is no folder {str(save.parent)!r}")


def _draw(
    view: Preview,
    arm: Arm,
    angles: list[float] | None,
    pose: np.ndarray | None,
    ellipsoids: bool,
    ghosts: bool,
    self_motion: bool,
) -> None:
    if angles is not None:
        view.show(angles)
    T = arm.forward_kinematics(view.q).homogeneous if pose is None else pose
    if pose is not None:
        view.show_intervals(T)
    if ellipsoids:
        view.show_ellipsoids(view.q)
    if ghosts:
        view.show_ghosts(T)
    if self_motion:
        view.show_self_motion(T)


def _serve(page: Any) -> None:
    """Keep the page until the user has seen enough."""
    _say_missing(page)
    try:
        typer.echo(f"{page.arm.name}: {page.url} (Ctrl+C ends it)")
        while True:
            time.sleep(3600.0)
    except KeyboardInterrupt:
        typer.echo()


def _say_missing(page: Any) -> None:
    if page.missing:
        more = f" (and {len(page.missing) - 1} more)" if len(page.missing) > 1 else ""
        typer.echo(f"srs-ik: not drawn: {page.missing[0]}{more}; see --meshes", err=True)
