"""How far can an arm be from S-R-S? Measures it, writes the table of docs/near_arms.md and its picture.

Limbs of about 0.37, 0.32 and 0.10 m, of which one axis is moved off its centre, or all six are, or the elbow is. Each
is asked for poses of random configurations; these, and the errors of the answers, are Pinocchio's on the limb as it is
built here. For the measurement alone, the threshold of the recognition is set aside.

Run: python docs/near_arms.py
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from time import thread_time
from typing import Any

import numpy as np
import pinocchio as pin

import srs_ik
from srs_ik.robot import recognition

PAGE = Path(__file__).with_name("near_arms.md")
PICTURE = Path(__file__).with_name("pictures") / "near_arms.png"
SIZES_MM = (0.1, 1.0, 5.0, 10.0, 20.0, 30.0, 45.0, 60.0)
AWAY = 0.5
"""How far a seed is from a known posture at most, rad in each joint."""
LIMITS = np.radians([170, 120, 170, 120, 170, 120, 175])
X, Y, Z = np.eye(3)

MOVED: dict[str, Callable[[np.random.Generator], list[int]]] = {
    "shoulder": lambda rng: [int(rng.integers(0, 3))],
    "wrist": lambda rng: [int(rng.integers(4, 7))],
    "all six": lambda rng: [0, 1, 2, 4, 5, 6],
    "elbow": lambda rng: [3],
}
"""Which axes are moved: one of the shoulder, one of the wrist, all of them, or the elbow: that limb is exact."""


def limb(seed: int, kind: str, size: float) -> pin.Model:
    """A limb with axes moved across themselves by `size` metres; directions and lengths follow from the seed alone."""
    rng = np.random.default_rng(seed)
    upper_arm, forearm, hand = np.array([0.37, 0.32, 0.10]) * rng.uniform(0.8, 1.2, 3)
    axes = [Z, Y, Z, Y, Z, Y, Z if seed % 2 else X]
    heights = np.array([0.0, 0.0, 0.0, upper_arm, *[upper_arm + forearm] * 3])
    points = heights[:, None] * Z
    for k in MOVED[kind](rng):
        # An elbow moved along the arm would be another pair of lengths.
        across = X * rng.choice([-1.0, 1.0]) if k == 3 else np.cross(axes[k], rng.normal(size=3))
        points[k] += size * across / np.linalg.norm(across)
    model, before = pin.Model(), np.zeros(3)
    model.name = f"{kind}_{1e3 * size:g}mm_{seed}"
    for k in range(7):
        placement = pin.SE3(np.eye(3), points[k] - before)
        bound = LIMITS[k : k + 1]
        joint = pin.JointModelRevoluteUnaligned(axes[k])
        model.addJoint(k, joint, placement, f"joint_{k + 1}", np.ones(1), np.ones(1), -bound, bound)
        before = points[k]
    model.addFrame(pin.Frame("base", 0, 0, pin.SE3.Identity(), pin.OP_FRAME))
    tip = pin.SE3(np.eye(3), (upper_arm + forearm + hand) * Z - before)
    model.addFrame(pin.Frame("tip", 7, 0, tip, pin.OP_FRAME))
    return model


@dataclass
class Measured:
    """What became of the poses of all limbs with one size of offset."""

    miss_percent: list[float] = field(default_factory=list)
    solved: list[bool] = field(default_factory=list)
    at_angle: list[bool] = field(default_factory=list)
    known: list[bool] = field(default_factory=list)
    nearest: list[bool] = field(default_factory=list)
    errors: list[float] = field(default_factory=list)
    false_ok: int = 0
    microseconds: list[float] = field(default_factory=list)
    microseconds_at_angle: list[float] = field(default_factory=list)


def measure(model: pin.Model, count: int, respect_limits: bool, seed: int, into: Measured) -> None:
    """Ask one limb for the poses of random configurations inside its limits."""
    arm = srs_ik.load(model, base="base", tip="tip")
    into.miss_percent.append(100.0 * float(arm.limb.misses.max()) / (arm.limb.upper_arm + arm.limb.forearm))
    data, tip = model.createData(), model.getFrameId("tip")

    def forward(q: np.ndarray) -> pin.SE3:
        pin.framesForwardKinematics(model, data, q)
        return data.oMf[tip].copy()

    def solve(pose: pin.SE3, times: list[float] | None = None, **how: Any) -> srs_ik.Solution:
        """The answer, with its own claims checked."""
        start = thread_time()
        solution = arm.solve(pose, respect_limits=respect_limits, **how)
        if times is not None:
            times.append(1e6 * (thread_time() - start))
        if solution:
            apart = pose.actInv(forward(solution.q))
            # Metres and radians alike: the largest figure that a user would see.
            error = max(np.linalg.norm(apart.translation), np.linalg.norm(apart.rotation - np.eye(3)) / np.sqrt(2.0))
            into.errors.append(float(error))
            into.false_ok += bool(error > 1e-9 or (respect_limits and (np.abs(solution.q) > LIMITS).any()))
        return solution

    rng = np.random.default_rng(seed)
    for _ in range(count):
        q = rng.uniform(-LIMITS, LIMITS)
        pose = forward(q)
        into.solved.append(bool(solve(pose, into.microseconds)))
        away = q + rng.uniform(-AWAY, AWAY, 7)
        near = solve(pose, seed=away)
        into.nearest.append(bool(near) and np.linalg.norm(near.q - away) <= np.linalg.norm(q - away) + 1e-6)
        psi = arm.arm_angle(q)
        into.at_angle.append(bool(solve(pose, into.microseconds_at_angle, arm_angle=psi)))
        found = arm.solve_all(pose, arm_angle=psi, respect_limits=respect_limits)
        turns = [np.abs((s.q - q + np.pi) % (2.0 * np.pi) - np.pi).max() for s in found]
        into.known.append(min(turns, default=np.inf) < 1e-5)


def sweep(limbs: int, count: int) -> Iterator[tuple[str, float, Measured, Measured]]:
    """Every kind and size, with limits and without."""
    recognition.NEAR_MISS_RATIO = 1.0
    for kind in MOVED:
        for size in SIZES_MM:
            kept, ignored = Measured(), Measured()
            for seed in range(limbs):
                model = limb(seed, kind, 1e-3 * size)
                measure(model, count, True, seed, kept)
                measure(model, count, False, seed, ignored)
            yield kind, size, kept, ignored


def percent(found: list[bool]) -> str:
    """A percentage that says 100 only if it is all of them."""
    return "100" if all(found) else f"{np.floor(1000.0 * float(np.mean(found))) / 10.0:.1f}"


def row(kind: str, size: float, kept: Measured, ignored: Measured) -> str:
    """A line of the table; most cells hold two figures, with limits and without."""

    def both(figure: Callable[[Measured], str]) -> str:
        return f"{figure(kept)} / {figure(ignored)}"

    cells = [
        kind,
        f"{size:g}",
        f"{np.max(kept.miss_percent):.2f}",
        both(lambda m: percent(m.solved + m.nearest + m.at_angle)),
        both(lambda m: percent(m.known)),
        f"{max(*kept.errors, *ignored.errors):.0e}",
        both(lambda m: f"{np.median(m.microseconds):.0f}"),
        both(lambda m: f"{np.median(m.microseconds_at_angle):.0f}"),
    ]
    return f"| {' | '.join(cells)} |"


def draw(results: list[tuple[str, float, Measured, Measured]]) -> None:
    """Success and time against the size of the offset, limits kept."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 4), dpi=110, layout="constrained")
    left, right = figure.subplots(1, 2)
    for kind, colour in zip(MOVED, ["#2a78b5", "#d9822b", "#7a3f9d", "#3a8f5c"], strict=True):
        shown = [(size, kept) for moved, size, kept, _ in results if moved == kind]
        sizes = [size for size, _ in shown]
        for axes, style, name, figures in (
            (left, "o-", "solve(pose)", [100.0 * np.mean(m.solved) for _, m in shown]),
            (left, "x:", "with a seed", [100.0 * np.mean(m.nearest) for _, m in shown]),
            (left, "^--", "in solve_all", [100.0 * np.mean(m.known) for _, m in shown]),
            (right, "o-", "solve(pose)", [np.median(m.microseconds) for _, m in shown]),
            (right, "x:", "with arm_angle", [np.median(m.microseconds_at_angle) for _, m in shown]),
        ):
            axes.plot(sizes, figures, style, color=colour, label=f"{kind}: {name}")
    left.set(xscale="log", xlabel="axes moved by (mm)", ylabel="answers (%)", title="Success, limits kept")
    right.set(xscale="log", yscale="log", xlabel="axes moved by (mm)", ylabel="median (µs)", title="Time a call")
    for axes in (left, right):
        axes.legend(fontsize=7)
        axes.grid(alpha=0.3)
    figure.savefig(PICTURE, metadata={"Software": None}, pil_kwargs={"optimize": True})


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--limbs", type=int, default=6, help="limbs of each kind and size (default: 6)")
    parser.add_argument("--count", type=int, default=20, help="poses of a limb (default: 20)")
    parser.add_argument("--print", action="store_true", help="print the table, and leave page and picture alone")
    options = parser.parse_args()
    lines = [
        "| moved | by (mm) | worst miss (%) | answered (%) | in `solve_all` (%) | worst error | `solve` (µs) "
        "| with `arm_angle` (µs) |",
        "|---|--:|--:|--:|--:|--:|--:|--:|",
    ]
    print(*lines, sep="\n")
    results = []
    for result in sweep(options.limbs, options.count):
        results.append(result)
        lines.append(row(*result))
        print(lines[-1], flush=True)
    print("false OK:", sum(kept.false_ok + ignored.false_ok for *_, kept, ignored in results))
    if not options.print:
        table = "\n".join(lines)
        marks = re.compile("(<!-- table: begin -->\n).*(\n<!-- table: end -->)", re.DOTALL)
        PAGE.write_text(marks.sub(lambda found: found[1] + table + found[2], PAGE.read_text()))
        draw(results)


if __name__ == "__main__":
    main()
