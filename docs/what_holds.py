"""Makes the tables and pictures of docs/what_holds.md: python docs/what_holds.py [--tasks 300] [--scipy 10].

Runs the experiments of `srs-ik reproduce all` and the measurements of benchmarks/claims.py, and writes every figure and
every verdict that follows from it.
"""

from __future__ import annotations

import argparse
import re
import runpy
from pathlib import Path
from typing import Any

from what_holds_rows import Row, rows_of_claims, rows_of_experiments

import srs_ik
from srs_ik.paper.experiments import EXPERIMENTS
from srs_ik.paper.experiments.c_grasp import EXTENSIONS, GRASPS
from srs_ik.paper.experiments.ik_accuracy import ANGLES, LENGTHS

ROOT = Path(__file__).resolve().parents[1]
PAGE = Path(__file__).with_suffix(".md")
PICTURES = ROOT / "docs" / "pictures"
ROBOTS = ("human_arm", "iiwa14", "gen3")
SHOWN = {"lr-arms": 75, "c-grasp": 75, "walking": 75}
"""Experiments whose picture is on the page, and the dots per inch there."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tasks", type=int, default=300)
    parser.add_argument("--scipy", type=int, default=10)
    chosen = parser.parse_args()
    module = runpy.run_path(str(ROOT / "benchmarks" / "claims.py"), run_name="claims")
    arms = {name: srs_ik.load(name) for name in ROBOTS}
    limb = arms["human_arm"]
    outcomes = {name: experiment(limb, lambda share: None) for name, experiment in EXPERIMENTS.items()}
    figures = {name: outcome.figures for name, outcome in outcomes.items()}
    claims = module["claims"](limb, chosen.tasks, chosen.scipy)
    accuracy = {name: EXPERIMENTS["ik-accuracy"](arm, lambda share: None).figures for name, arm in arms.items()}
    accuracy["human_arm"] = figures["ik-accuracy"]
    optimal = {
        name: module["optimality"](arm, module["random_tasks"](arm, chosen.tasks))
        for name, arm in arms.items()
        if arm is not limb
    }
    optimal = {"human_arm": claims["optimality"]["random"], **optimal}
    tables = {
        "claims": claims_table([*rows_of_experiments(figures, claims, limb), *rows_of_claims(claims)]),
        "accuracy": accuracy_table(accuracy),
        "optimality": optimality_table(optimal, claims["optimality"]["in_the_plane"]),
        "grasps": grasp_table(figures["c-grasp"]),
    }
    text = PAGE.read_text()
    for name, lines in tables.items():
        begin, end = f"<!-- {name}: begin -->", f"<!-- {name}: end -->"
        text = re.sub(f"{begin}.*?{end}", lambda _, b=begin, e=end, ls=lines: "\n".join([b, *ls, e]), text, flags=re.S)
    PAGE.write_text(text)
    for name, dpi in SHOWN.items():
        path = PICTURES / f"{name}.png"
        outcomes[name].draw().savefig(path, dpi=dpi, metadata={"Software": None}, pil_kwargs={"optimize": True})


# Tables -------------------------------------------------------------------------------------------------------------


def claims_table(rows: list[Row]) -> list[str]:
    lines = [f"| {row.claim} | **{row.verdict}** | {row.found} | `{row.command}` |" for row in rows]
    return ["| claim | verdict | measured | by |", "|---|---|---|---|", *lines]


def accuracy_table(accuracy: dict[str, Any]) -> list[str]:
    lines = ["| robot | solved | error | mean | deviation | worst |", "|---|--:|---|--:|--:|--:|"]
    for robot, figures in accuracy.items():
        sides = [figures["left"], figures["right"]]
        solved = f"{sum(side['solved'] for side in sides):,} of {sum(side['tasks'] for side in sides):,}"
        for name in (*LENGTHS, *ANGLES):
            what, unit = name.rsplit("_", 1)
            mean, deviation, worst = (max(side[name][key] for side in sides) for key in ("mean", "deviation", "worst"))
            lines.append(f"| {robot} | {solved} | {what} ({unit}) | {mean:.1e} | {deviation:.1e} | {worst:.1e} |")
    return lines


def optimality_table(optimal: dict[str, Any], in_the_plane: dict[str, Any]) -> list[str]:
    lines = [
        "| robot | tasks | C / best | f'JpJp'f / best | best / v'JpJp'v | within 1 % of the best C |",
        "|---|---|--:|--:|--:|--:|",
    ]
    named = [(robot, "random", figures) for robot, figures in optimal.items()]
    for robot, tasks, figures in [*named, ("human_arm", "target in the task's plane", in_the_plane)]:
        cells = [
            f"{figures[name]['median']:.2f} ({figures[name]['most']:.1f})"
            for name in ("C_over_best", "force_term_over_best", "best_over_velocity_term")
        ]
        lines.append(f"| {robot} | {tasks} | {' | '.join(cells)} | {100 * figures['within_one_percent']:.0f} % |")
    return lines


def grasp_table(figures: dict[str, Any]) -> list[str]:
    lines = [
        "| target (reaches) | N-grasp | F-grasp | V-grasp | reached with F or V |",
        "|--:|---|---|---|--:|",
    ]
    for i in range(1, len(EXTENSIONS), 2):
        rows = [figures["by_extension"][grasp]["left"][i] for grasp in GRASPS]
        cells = [" - ".join(ratio(r[name]) for name in ("least", "geometric_mean", "largest")) for r in rows]
        lines.append(f"| {EXTENSIONS[i]:.2f} | {' | '.join(cells)} | {rows[1]['reached']} of 36 |")
    return lines


def ratio(C: float) -> str:
    """A value of C; where one of its terms is rounding, what it stands for."""
    return "0" if C < 1e-9 else "∞" if C > 1e9 else f"{C:.2g}"


if __name__ == "__main__":
    main()
