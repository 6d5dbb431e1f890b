"""What the pages say about a posture, in words and figures that a person reads."""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from srs_ik.preview import palette

if TYPE_CHECKING:
    from srs_ik.arm import Arm
    from srs_ik.solve.intervals import Interval
    from srs_ik.solve.solution import Solution

Entry = tuple[palette.Rgb, str]
"""A colour and what it stands for."""


def title(arm: Arm) -> str:
    """The arm and its two frames."""
    return f"{arm.name}, {arm.base} to {arm.tip}"


def degrees(angle: float) -> str:
    """An angle in degrees to two places; zero without a sign."""
    return f"{round(float(np.rad2deg(angle)), 2) + 0.0:.2f}"


def span(interval: Interval) -> str:
    """An interval of arm angles, and its branch."""
    return f"branch {interval.branch}: {degrees(interval.lower)} to {degrees(interval.upper)} deg"


def branches(numbers: Iterable[int]) -> list[Entry]:
    """The legend of arcs."""
    return [(palette.BRANCHES[number], f"branch {number}") for number in sorted(set(numbers))]


CLEARANCES: list[Entry] = [
    (palette.TOUCHING, "at the margin"),
    (palette.CLOSE, "5 cm away"),
    (palette.CLEAR, "10 cm and more"),
]
"""The legend of bodies in the colour of their clearance."""

TAKEN: Entry = (palette.FORBIDDEN, "bodies meet")


def report(solution: Solution, intervals: Sequence[Interval]) -> str:
    """The posture as HTML, in which escaping is complete: names and messages are those of a robot file."""
    legend = "".join(
        f"<span style='white-space: nowrap; margin-right: 0.8em'><span style='color: {css(colour)}'>&#9679;</span> "
        f"{html.escape(text)}</span> "
        for colour, text in branches(interval.branch for interval in intervals)
    )
    rows = "".join(
        f"<tr><td>{html.escape(name)}</td><td align=right>{degrees(angle)}</td></tr>"
        for name, angle in solution.as_dict().items()
    )
    return (
        f"<div style='{STYLE}'><p>{html.escape(solution.message)}</p><p>{legend}</p>"
        f"<table width='100%'><tr><th align=left>joint</th><th align=right>deg</th></tr>{rows}</table></div>"
    )


STYLE = "font-size: 0.85em; padding: 0 0.8em; overflow-wrap: anywhere"
"""Of texts on pages."""


def css(colour: palette.Rgb) -> str:
    """A colour as style sheets write it."""
    return "#" + "".join(f"{round(255.0 * x):02x}" for x in colour)
