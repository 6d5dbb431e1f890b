"""What the commands print: tables for people, JSON for programs."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table

from srs_ik.system.arrays import plain

if TYPE_CHECKING:
    from srs_ik.arm import Arm
    from srs_ik.solve.solution import Solution

WIDE = 200
"""Columns that every table of numbers fits into: a terminal may wrap its lines, but no digit is cut off."""


def console(*, fit: bool = False) -> Console:
    """A console on standard output that prints names as they are.

    Args:
        fit: whether texts are wrapped to the width of the terminal; for tables of text alone.
    """
    width = None if fit and sys.stdout.isatty() else WIDE
    return Console(width=width, markup=False, emoji=False, highlight=False)


def table(
    columns: Sequence[str], rows: Iterable[Sequence[str]], *, title: str | None = None, left: int = 1, whole: int = 0
) -> Table:
    """A plain table; the first `left` columns are text and stand on the left, the rest are numbers.

    Neither numbers nor the first `whole` columns are broken into lines.
    """
    result = Table(
        box=box.SIMPLE_HEAD, title=title, title_justify="left", title_style="", pad_edge=False, show_edge=False
    )
    for i, column in enumerate(columns):
        result.add_column(
            column, justify="left" if i < left else "right", no_wrap=i >= left or i < whole, overflow="fold"
        )
    for row in rows:
        result.add_row(*row)
    return result


def fixed(value: float, digits: int) -> str:
    """A number with that many decimals; "-" where there is none, and no negative zero."""
    if not math.isfinite(value):
        return "-"
    return f"{round(value, digits) + 0.0:.{digits}f}"


def direction(vector: np.ndarray) -> str:
    """A vector as three numbers, short where they are whole."""
    return " ".join(f"{round(float(x), 4) + 0.0:g}" for x in vector)


def print_json(answer: object) -> None:
    """Print an answer as JSON: arrays as lists, and null for what is infinite or not a number."""
    print(json.dumps(plain(answer), indent=2, allow_nan=False), flush=True)


def heading(arm: Arm) -> dict[str, Any]:
    """What JSON says of an arm."""
    return {"robot": arm.name, "base": arm.base, "tip": arm.tip, "joint_names": list(arm.joint_names)}


def fields(solution: Solution) -> dict[str, Any]:
    """What JSON says of a solution."""
    from srs_ik.solve.optimise import Optimum

    answer = {
        "status": solution.status.name,
        "message": solution.message,
        "q": solution.q,
        "branch": solution.branch,
        "arm_angle": solution.arm_angle,
        "position_error": solution.position_error,
        "orientation_error": solution.orientation_error,
    }
    if solution.collision is not None:
        answer["collision"] = solution.collision._asdict()
    if isinstance(solution, Optimum):
        within = solution.interval
        answer["objective"] = solution.objective.name
        answer["value"] = solution.value
        answer["second_value"] = solution.second_value
        answer["interval"] = None if within is None else {"lower": within.lower, "upper": within.upper}
    return answer
