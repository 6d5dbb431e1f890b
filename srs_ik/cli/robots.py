"""`srs-ik robots`: the robots that have names."""

from __future__ import annotations

import typer

from srs_ik.cli.options import AsJson


def robots(as_json: AsJson = False) -> None:
    """List the robots that are known by name, and what has to be installed for those that are missing here."""
    from srs_ik.cli.render import console, print_json, table
    from srs_ik.loading.sources import catalogue

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
                    "install": entry.install or None,
                }
                for entry in entries
            ]
        )
        return
    rows = [
        (entry.name, entry.base, entry.tip, "no" if entry.install else "yes", entry.description, entry.origin)
        for entry in entries
    ]
    columns = ("robot", "base", "tip", "here", "description", "from")
    console(fit=True).print(table(columns, rows, left=len(columns)))
    missing: dict[str, list[str]] = {}
    for entry in entries:
        if entry.install:
            missing.setdefault(entry.install, []).append(entry.name)
    typer.echo()
    for command, names in missing.items():
        typer.echo(f"For {' and '.join(names)}: {command}")
    typer.echo(
        "Names of robot_descriptions, such as iiwa14_description, are known too, where that package is installed."
    )
