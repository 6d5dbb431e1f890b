"""`srs-ik robots`: the robots that have names."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

from srs_ik.cli.options import AsJson

if TYPE_CHECKING:
    from srs_ik.robot.sources import NamedRobot


_LEGIBLE = 26
"""The narrowest column that sentences are wrapped in."""


def robots(as_json: AsJson = False) -> None:
    """List the robots that are known by name, and what has to be installed for those that are missing here."""
    from srs_ik.cli.render import console, print_json, table
    from srs_ik.robot.sources import catalogue

    entries = catalogue()
    if as_json:
        print_json(
            [
                {
                    "name": entry.name,
                    "description": entry.description,
                    "base": entry.base,
                    "tip": entry.tip,
                    "origin": entry.origin,
                    "installed": not entry.install,
                    "fetched_on_first_use": entry.fetched,
                    "install": entry.install or None,
                }
                for entry in entries
            ]
        )
        return
    rows = [(entry.name, entry.base, entry.tip, _here(entry), entry.description, entry.origin) for entry in entries]
    columns = ("robot", "base", "tip", "here", "description", "from")
    out = console(fit=True)
    # Names are there to be copied, and stand whole: where the terminal is narrow, columns on the right give way.
    widths = [*(max(len(row[k]) for row in (*rows, columns)) + 3 for k in range(4)), _LEGIBLE, _LEGIBLE]
    shown = next((k for k in range(len(columns), 3, -1) if sum(widths[:k]) <= out.width), 3)
    out.width = max(out.width, sum(widths[:shown]))
    out.print(table(columns[:shown], [row[:shown] for row in rows], left=shown, whole=4))
    missing: dict[str, list[str]] = {}
    for entry in entries:
        if entry.install:
            missing.setdefault(entry.install, []).append(entry.name)
    typer.echo()
    for command, names in missing.items():
        typer.echo(f"For {', '.join(names)}: {command}")
    typer.echo(
        "Names of robot_descriptions, such as iiwa14_description, are known too, where that package is installed."
    )


def _here(entry: NamedRobot) -> str:
    return "no" if entry.install else "on first use" if entry.fetched else "yes"
