"""`srs-ik ellipsoids`: what the tip of an arm can do at a configuration."""

from __future__ import annotations

import math
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, Any

import typer

from srs_ik.cli.chosen import Chosen, choosing
from srs_ik.cli.options import AsJson, Seven, Source, Three, WrongInput, numbers
from srs_ik.cli.poses import JOINTS, angles, unit_of

if TYPE_CHECKING:
    from rich.console import Console

    from srs_ik.analysis.ellipsoids import Ellipsoid
    from srs_ik.analysis.polytopes import Polytope
    from srs_ik.arm import Arm


ROUNDING = 1e-12
"""Velocities and forces below this are none."""


class Part(StrEnum):
    """Rows of the Jacobian."""

    linear = "linear"
    angular = "angular"
    full = "full"


class Axes(StrEnum):
    """Frame in which directions are written."""

    base = "base"
    tip = "tip"


PartOption = Annotated[Part, typer.Option(help="Of the tip point, of its rotation, or both in one (mixed units).")]


@choosing
def ellipsoids(
    source: Source,
    chosen: Chosen,
    q: Annotated[Seven | None, typer.Option(metavar=JOINTS, help="Joint angles of the arm; has to be given.")] = None,
    part: PartOption = Part.linear,
    limits: Annotated[
        bool, typer.Option("--limits", help="Weigh the joints by the arm's velocity and torque limits.")
    ] = False,
    axes: Annotated[Axes, typer.Option(help="Frame in which directions are given and printed.")] = Axes.base,
    along: Annotated[
        Three | None,
        typer.Option(metavar="X Y Z", help="Also the transmission ratios, and pure velocities and forces, along it."),
    ] = None,
    polytopes: Annotated[
        bool, typer.Option("--polytopes", help="Also the polytopes within the arm's own limits (extra 'polytopes').")
    ] = False,
    no_gravity: Annotated[
        bool, typer.Option("--no-gravity", help="Leave the arm's own weight out of the force polytope.")
    ] = False,
    degrees: Annotated[bool, typer.Option("--degrees", help="--q is given in degrees.")] = False,
    as_json: AsJson = False,
) -> None:
    """Show the velocity and force ellipsoids at the tip of an arm, with its manipulability and isotropy.

    They are those of joint velocities of norm 1 rad/s and of joint torques of norm 1 N m, or with --limits of joints
    at their limits. A singular direction is one along which the tip cannot move: the velocity ellipsoid is flat there,
    and the force ellipsoid unbounded. Manipulability and isotropy are those of joint velocities of norm 1 rad/s, with
    --limits too.
    """
    if q is None:
        raise WrongInput(f"give the joint angles: --q {JOINTS}")
    configuration = angles("--q", q, unit_of(degrees))
    direction = None if along is None else numbers("--along", along)
    if part is Part.full and (direction is not None or polytopes):
        raise WrongInput("--along and --polytopes go with --part linear or angular")
    if direction is not None and not any(direction):
        raise WrongInput("--along is a direction, and 0 0 0 is none")

    import numpy as np

    from srs_ik.analysis.ellipsoids import force_ellipsoid, isotropy, limits_of, manipulability, velocity_ellipsoid
    from srs_ik.loading import load

    arm = load(source, **chosen)
    velocity_limit, effort_limit = (limits_of(arm, kind) for kind in ("velocity", "effort")) if limits else (None, None)
    J = arm.jacobian(configuration)
    R = arm.forward_kinematics(configuration).rotation if axes is Axes.tip else np.eye(3)
    shown = [
        velocity_ellipsoid(J, velocity_limit, part.value).in_axes(R),
        force_ellipsoid(J, effort_limit, part.value).in_axes(R),
    ]
    bodies = _polytopes(arm, configuration, part.value, not no_gravity) if polytopes else []
    answer = {
        "robot": arm.name,
        "base": arm.base,
        "tip": arm.tip,
        "q": configuration,
        "part": part.value,
        "axes": axes.value,
        "limits": limits,
        "rank": shown[0].rank,
        "manipulability": manipulability(J, part.value),
        "isotropy": isotropy(J, part.value),
        **_figures(shown, bodies, R, direction),
    }
    if as_json:
        from srs_ik.cli.render import print_json

        print_json(answer)
        return
    _print(arm, answer, shown, bodies, R, direction)


def _figures(
    shown: list[Ellipsoid], bodies: list[Polytope], R: Any, direction: list[float] | None
) -> dict[str, dict[str, Any]]:
    """Ellipsoids and polytopes by their names, as JSON has them; `R` (3, 3) are the axes in which they are told."""
    answer: dict[str, dict[str, Any]] = {}
    for ellipsoid in shown:
        answer[ellipsoid.kind] = {
            "unit": ellipsoid.unit,
            "radii": ellipsoid.radii,
            "axes": ellipsoid.axes.T,
            "singular": ellipsoid.singular,
            "along": None if direction is None else ellipsoid.radius_along(direction),
        }
    for body in bodies:
        answer[f"{body.kind}_polytope"] = {
            "unit": body.unit,
            "along": None if direction is None else body.radius_along(R @ direction),
            "rank": body.rank,
            "vertices": body.vertices @ R,
            "faces": body.faces,
            "singular": body.singular.T @ R,
        }
    return answer


def _polytopes(arm: Arm, q: list[float], part: Any, gravity: bool) -> list[Polytope]:
    from srs_ik.analysis.polytopes import force_polytope, velocity_polytope

    return [velocity_polytope(arm, q, part), force_polytope(arm, q, part, gravity=gravity)]


def _print(
    arm: Arm,
    answer: dict[str, Any],
    shown: list[Ellipsoid],
    bodies: list[Polytope],
    R: Any,
    direction: list[float] | None,
) -> None:
    from srs_ik.cli.render import console

    out = console()
    joints = "joints up to their limits" if answer["limits"] else "joint velocities of 1 rad/s and torques of 1 N m"
    out.print(f"{arm.name}: {arm.tip} in {arm.base}, {answer['part']} part, for {joints}")
    for ellipsoid in shown:
        _print_ellipsoid(out, ellipsoid, arm.tip if answer["axes"] == "tip" else arm.base)
        if direction is not None:
            ratio = answer[ellipsoid.kind]["along"]
            out.print(f"along ({' '.join(f'{x:g}' for x in direction)}): {_figure(ratio)} {ellipsoid.unit}")
        out.print()
    unit = {"linear": " m^3", "angular": "", "full": " m^3"}[answer["part"]]
    whose = "of joint velocities of 1 rad/s, without limits: " if answer["limits"] else ""
    out.print(f"{whose}manipulability {answer['manipulability']:.6g}{unit}, isotropy {answer['isotropy']:.6g}")
    for body in bodies:
        out.print()
        _print_polytope(out, body, R)
        if direction is not None:
            largest = answer[f"{body.kind}_polytope"]["along"]
            out.print(f"alone along ({' '.join(f'{x:g}' for x in direction)}): {_figure(largest)} {body.unit}")


def _print_ellipsoid(out: Console, ellipsoid: Ellipsoid, frame: str) -> None:
    from srs_ik.cli.render import fixed, table

    names = "x y z" if len(ellipsoid.radii) == 3 else "x y z rx ry rz"
    remark = "flat" if ellipsoid.kind == "velocity" else "unbounded"
    rows = [
        (_figure(radius), *(fixed(x, 6) for x in axis), remark if singular else "")
        for radius, axis, singular in zip(ellipsoid.radii, ellipsoid.axes.T, ellipsoid.singular, strict=True)
    ]
    columns = (f"semi-axis ({ellipsoid.unit})", *names.split(), "")
    title = f"{ellipsoid.kind} ellipsoid, rank {ellipsoid.rank}, axes in {frame}"
    out.print(table(columns, rows, title=title, left=0))


def _print_polytope(out: Console, body: Polytope, R: Any) -> None:
    from srs_ik.cli.render import fixed, table

    if body.empty:
        out.print(f"{body.kind} polytope: empty, the joint torques do not suffice to hold the arm up")
        return
    out.print(f"{body.kind} polytope, rank {body.rank}, {len(body.vertices)} vertices, {len(body.faces)} faces")
    rows = [
        (name, _figure(-body.extent_along(-u)), _figure(body.extent_along(u)))
        for name, u in zip("xyz", R.T, strict=True)
    ]
    out.print(table(("component", f"least ({body.unit})", f"largest ({body.unit})"), rows))
    for u in body.singular.T @ R:
        out.print(f"{'flat across' if body.flat else 'unbounded along'} ({' '.join(fixed(x, 6) for x in u)})")


def _figure(value: float) -> str:
    """Six digits, and 0 for what is rounding."""
    if not math.isfinite(value):
        return "inf" if value > 0.0 else "-inf"
    return "0" if abs(value) < ROUNDING else f"{value:.6g}"
