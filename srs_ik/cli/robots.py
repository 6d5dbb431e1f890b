"""`srs-ik robots`: the robots that come with the package."""

from __future__ import annotations

import typer

from srs_ik.cli.options import AsJson


def robots(as_json: AsJson = False) -> None:
    """List the built-in robots."""
    from srs_ik import zoo
    from srs_ik.cli.render import console, print_json, table

    cards = [zoo.card(name) for name in zoo.robots()]
    if as_json:
        print_json([{"name": c.name, "description": c.description, "base": c.base, "tip": c.tip} for c in cards])
        return
    rows = [(c.name, c.base, c.tip, c.description) for c in cards]
    console(fit=True).print(table(("robot", "base", "tip", "description"), rows, left=4))
    typer.echo(
        "\nKnown by name too, with the extra 'robots' (pip install 'srs-ik[robots]'):\n"
        "human_left and human_right of example-robot-data,\n"
        "and every name of robot_descriptions, such as iiwa14_description."
    )
