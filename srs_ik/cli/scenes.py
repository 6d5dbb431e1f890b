"""What stands around an arm, on the command line, and what its bodies are."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from srs_ik.cli.options import WrongInput, numbers

if TYPE_CHECKING:
    from rich.console import Console

    from srs_ik.arm import Arm

SceneFile = Annotated[
    Path | None,
    typer.Option(
        "--scene", metavar="FILE", help="Touch nothing of the scene in this JSON or YAML file, nor the arm itself."
    ),
]
Margin = Annotated[
    str | None, typer.Option(metavar="M", help="With --scene: what is to be left between two bodies, metres.")
]
Exact = Annotated[bool, typer.Option("--exact", help="With --scene: real shapes count, and not spheres around them.")]

Meshes = Annotated[
    list[Path] | None, typer.Option("--meshes", metavar="FOLDER", help="A folder to search for meshes; repeatable.")
]


def with_meshes(arm: Arm, folders: Sequence[Path] | None) -> Arm:
    """The arm whose meshes are sought in these folders first."""
    return arm.with_bodies(folders=folders) if folders else arm


def read(scene: Path | None, margin: str | None, exact: bool = False) -> dict[str, Any]:
    """The arguments of a question that a scene and a margin make, none without a scene; raises WrongInput."""
    if scene is None:
        if margin is not None or exact:
            raise WrongInput('--margin and --exact go with --scene FILE; {"objects": []} is the arm alone')
        return {}
    left = 0.0 if margin is None else numbers("--margin", [margin])[0]

    from srs_ik.collision.scenes.scene import Scene

    return {"scene": Scene.from_file(scene, exact), "margin": left}


def bodies_of(arm: Arm) -> dict[str, Any]:
    """What JSON says of the bodies of an arm."""
    return {
        "bodies": [
            {
                "name": body.name,
                "joint": body.joint,
                "source": body.source,
                "spheres": body.spheres,
                "protrusion_mm": 1e3 * body.protrusion,
            }
            for body in arm.bodies
        ],
        "pairs": [
            {"first": pair.first, "second": pair.second, "watched": pair.kept, "reason": pair.reason}
            for pair in arm.pairs
        ],
    }


def print_bodies(out: Console, arm: Arm) -> None:
    """Print the bodies of an arm, and the pairs of them."""
    from srs_ik.cli.render import fixed, table

    rows = [
        (body.name, body.source, str(body.joint), str(len(body.spheres)), fixed(1e3 * body.protrusion, 1))
        for body in arm.bodies
    ]
    out.print()
    out.print(table(("body", "of", "joint", "spheres", "protrusion (mm)"), rows, left=2))
    pairs = [(p.first, p.second, "yes" if p.kept else "no", p.reason) for p in arm.pairs if p.reason != "on one joint"]
    out.print(table(("body", "body", "watched", "reason"), pairs, left=4))
