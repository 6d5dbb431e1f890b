"""Whether joint paths are the best there are, one line of result a call; calls with other seeds go on with others.

python benchmarks/path_truth.py known  --robot iiwa14 --kind cross --count 75 --seed 0 [--poses 200] [--dt]
                                       [--objective sum_of_squares|largest_step|time]
python benchmarks/path_truth.py brute  --robot iiwa14 --count 25 --seed 0 [--angles 2000]
python benchmarks/path_truth.py broken --robot iiwa14 --count 25 --seed 0 [--angles 2000]
python benchmarks/path_truth.py ssik   --robot iiwa14 --kind cross --count 20

known: motions inside the limits as in `known_motions.py`, number --seed and those behind it. Their poses are given to
`solve_path`, with the first posture as seed and without: no break, no larger value, every posture on its pose and
inside the limits; with --dt, inside the velocity limits that the motion keeps by 5 %. Times are of the processor,
beside those of the intervals of the same poses in the same run.

brute: 20 poses of a motion against exhaustive dynamic programming over a sweep of arm angles in all branches and turns.
broken: the same, where the second half of the poses is of another motion: as many breaks as by brute force.
ssik: that library's own paths of the same motions, for arms that it brings along.

Exit status 1 where something does not hold; the line then names the numbers of the problems.
"""

from __future__ import annotations

import argparse
import sys
import time
import zlib
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
sys.path.insert(0, str(Path(__file__).resolve().parent))

import subjects
from known_motions import KINDS, OF_MAKERS, known_motion, load
from path_brute import best_path
from path_oracle import differences, swept_postures

import srs_ik

OBJECTIVES = ("sum_of_squares", "largest_step", "time")
ROUNDING = 1e-6
"""A value may be larger than the known one by this part of it."""

COARSE = 1e-3
"""The same against a sweep."""

ON_POSE = 1e-8
"""m and rad."""

LONGEST = 0.5
"""Longest joint step that is continuous, rad."""

SHORT = 20
"""Poses of a problem for brute force."""


def generator(arm: srs_ik.Arm, kind: str, number: int) -> np.random.Generator:
    return np.random.default_rng([zlib.crc32(arm.name.encode()), KINDS.index(kind), number])


def poses_of(arm: srs_ik.Arm, q: np.ndarray) -> np.ndarray:
    return np.array([arm.forward_kinematics(each).homogeneous for each in q])


def value_of(arm: srs_ik.Arm, objective: str, steps: np.ndarray) -> float:
    """What joint steps (k, 7) count."""
    if objective == "largest_step":
        return float(np.abs(steps).max())
    if objective == "time":
        return float((np.abs(steps) / arm.velocity_limit).max(axis=1).sum())
    return float((steps**2).sum())


def steps_from(arm: srs_ik.Arm, seed: np.ndarray | None, q: np.ndarray) -> np.ndarray:
    """Joint steps of a path, that from the seed included."""
    endless = np.isinf(arm.lower) & np.isinf(arm.upper)
    q = q if seed is None else np.vstack([seed, q])
    return np.array([differences(a[None], b[None], endless)[0, 0] for a, b in pairwise(q)])


class Known:
    """What the paths of known motions show, seeded (0) and free (1)."""

    def __init__(self, arm: srs_ik.Arm, objective: str) -> None:
        self.arm, self.objective = arm, objective
        self.broken: list[list[int]] = [[], []]
        self.larger: list[list[str]] = [[], []]
        self.wrong: list[int] = []
        self.ratios: list[list[float]] = [[], []]
        self.taken = [0.0, 0.0]
        self.yardstick = 0.0
        self.poses = 0

    def add(self, number: int, known: np.ndarray, dt: bool) -> None:
        arm = self.arm
        poses = poses_of(arm, known)
        self.poses += len(known)
        begin = time.process_time()
        arm.intervals_batch(poses, threads=1)
        self.yardstick += time.process_time() - begin
        seconds = None
        if dt:
            seconds = float((np.abs(np.diff(known, axis=0)) / arm.velocity_limit).max()) * 1.05
        least = value_of(arm, self.objective, np.diff(known, axis=0))
        for free, seed in enumerate((known[0], None)):
            begin = time.process_time()
            path = arm.solve_path(poses, seed=seed, dt=seconds, objective=self.objective)
            self.taken[free] += time.process_time() - begin
            if not path:
                self.broken[free].append(number)
                continue
            if not self.holds(poses, path, seconds):
                self.wrong.append(number)
            ratio = value_of(arm, self.objective, steps_from(arm, seed, path.q)) / least
            self.ratios[free].append(ratio)
            if ratio > 1.0 + ROUNDING:
                self.larger[free].append(f"{number} ({ratio:.7g})")

    def holds(self, poses: np.ndarray, path: srs_ik.PathSolution, seconds: float | None) -> bool:
        """Whether postures are on their poses, inside the limits, and the steps within the velocity limits."""
        arm = self.arm
        off = np.abs(poses_of(arm, path.q) - poses).max()
        inside = ((path.q >= arm.lower - 1e-12) & (path.q <= arm.upper + 1e-12)).all()
        slow = seconds is None or (np.abs(path.steps) <= arm.velocity_limit * seconds * (1.0 + 1e-9)).all()
        return bool(off < ON_POSE and inside and slow)

    def failed(self) -> bool:
        return any(self.broken) or any(self.larger) or bool(self.wrong)

    def line(self) -> str:
        names = "seeded", "free"
        parts = []
        for free, name in enumerate(names):
            ratios = self.ratios[free] or [np.nan]
            taken = self.taken[free]
            parts.append(
                f"{name}: {len(self.broken[free])} breaks, {len(self.larger[free])} larger, over the known "
                f"{np.median(ratios):.4f} (median) {max(ratios):.8f} (worst), "
                f"{1e6 * taken / self.poses:.0f} us a pose = {taken / self.yardstick:.1f} times the intervals"
            )
        failures = [
            f"{what} {name} {numbers}"
            for what, found in (("broken", self.broken), ("larger", self.larger))
            for name, numbers in zip(names, found, strict=True)
            if numbers
        ]
        if self.wrong:
            failures.append(f"off their poses or limits {self.wrong}")
        return "; ".join([*parts, *failures])


def known_motions(arm: srs_ik.Arm, chosen: argparse.Namespace) -> tuple[str, bool]:
    """A line, and whether something does not hold."""
    found = Known(arm, chosen.objective)
    warm = poses_of(arm, known_motion(arm, generator(arm, chosen.kind, 0), chosen.kind, 40))
    for seed in (None, np.clip(np.zeros(7), arm.lower, arm.upper)):
        arm.solve_path(warm, seed=seed, objective=chosen.objective)
    for number in range(chosen.seed, chosen.seed + chosen.count):
        known = known_motion(arm, generator(arm, chosen.kind, number), chosen.kind, chosen.poses)
        found.add(number, known, chosen.dt)
    what = f"{chosen.kind}, {chosen.poses} poses, {chosen.objective}{', dt' if chosen.dt else ''}"
    return f"{what}, motions {chosen.seed} to {chosen.seed + chosen.count - 1}; {found.line()}", found.failed()


def piece(arm: srs_ik.Arm, rng: np.random.Generator, kind: str, count: int) -> np.ndarray:
    """(count, 7) some poses of a known motion, up to three steps apart."""
    stride = int(rng.integers(1, 4))
    known = known_motion(arm, rng, kind, 200)
    first = int(rng.integers(0, 200 - stride * count))
    return known[first : first + stride * count : stride]


def against_brute_force(arm: srs_ik.Arm, chosen: argparse.Namespace) -> tuple[str, bool]:
    """A line, and whether something does not hold."""
    more, fewer, larger, ratios = [], [], [], []
    endless = np.isinf(arm.lower) & np.isinf(arm.upper)
    for number in range(chosen.seed, chosen.seed + chosen.count):
        kind = KINDS[number % len(KINDS)]
        rng = generator(arm, kind, 100_000 + number)
        if chosen.what == "broken":
            half = SHORT // 2
            known = np.vstack([piece(arm, rng, kind, half), piece(arm, rng, kind, SHORT - half)])
        else:
            known = piece(arm, rng, kind, SHORT)
        poses = poses_of(arm, known)
        seed = known[0] if number // len(KINDS) % 2 else None
        path = arm.solve_path(poses, seed=seed)
        own = float((steps_from(arm, seed, path.q) ** 2).sum())
        found = np.inf if path.breaks else own * (1.0 + COARSE)
        nodes = [swept_postures(arm, pose, chosen.angles) for pose in poses]
        if not all(map(len, nodes)):
            # A pose whose only postures lie between those of the sweep: there is nothing to compare with.
            continue
        breaks, least = best_path(nodes, seed, LONGEST, endless, found)
        if np.isinf(least) and not path.breaks:
            # All swept ones cost more.
            breaks, least = 0, own * (1.0 + COARSE)
        if len(path.breaks) != breaks:
            (more if len(path.breaks) > breaks else fewer).append(number)
        elif not breaks:
            ratios.append(own / least)
            if ratios[-1] > 1.0 + COARSE:
                larger.append(f"{number} ({ratios[-1]:.5f})")
    line = f"{chosen.what}, {SHORT} poses, {chosen.angles} angles, problems {chosen.seed} to "
    line += f"{chosen.seed + chosen.count - 1}: {len(more)} with more breaks {more or ''}, {len(fewer)} with fewer "
    line += f"{fewer or ''}; of {len(ratios)} without, {len(larger)} above {COARSE:g} {larger or ''}"
    if ratios:
        line += f", {np.median(ratios):.6f} (median) {max(ratios):.6f} (worst) times the exhaustive sum"
    return line, bool(more or larger)


def paths_of_ssik(arm: srs_ik.Arm, chosen: argparse.Namespace) -> tuple[str, bool]:
    """A line about ssik's own paths from the known start: how many are whole, inside the limits and continuous."""
    from ssik import Manipulator

    theirs = Manipulator.from_prebuilt(arm.name)
    whole, ratios, taken = 0, [], 0.0
    for number in range(chosen.seed, chosen.seed + chosen.count):
        known = known_motion(arm, generator(arm, chosen.kind, number), chosen.kind, chosen.poses)
        poses = np.array([theirs.fk(q) for q in known])
        begin = time.process_time()
        track = theirs.solve_path(poses, q0=known[0])
        taken += time.process_time() - begin
        tracks = [np.asarray(track.q(label)) for label in track.tracks]
        steps = [np.diff(np.vstack([known[:1], q]), axis=0) for q in tracks if is_whole(arm, q, len(known))]
        sums = [(each**2).sum() for each in steps if np.abs(each).max() <= LONGEST]
        if sums:
            whole += 1
            ratios.append(min(sums) / (np.diff(known, axis=0) ** 2).sum())
    line = f"ssik, {chosen.kind}, {chosen.poses} poses, motions {chosen.seed} to {chosen.seed + chosen.count - 1}; "
    line += f"seeded: {whole} of {chosen.count} whole"
    if ratios:
        line += f", over the known {np.median(ratios):.4f} (median) {max(ratios):.4f} (worst)"
    return line + f", {1e6 * taken / (chosen.count * chosen.poses):.0f} us a pose", False


def is_whole(arm: srs_ik.Arm, q: np.ndarray, count: int) -> bool:
    """Whether a path has all poses, inside the limits."""
    return len(q) == count and bool(((q >= arm.lower) & (q <= arm.upper)).all())


PARTS = {
    "known": known_motions,
    "brute": against_brute_force,
    "broken": against_brute_force,
    "ssik": paths_of_ssik,
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one part and print its line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=tuple(PARTS))
    parser.add_argument("--robot", required=True)
    parser.add_argument("--kind", choices=KINDS, default=KINDS[0], help="of known motions")
    parser.add_argument("--count", type=int, default=10, help="motions or problems")
    parser.add_argument("--seed", type=int, default=0, help="number of the first one")
    parser.add_argument("--poses", type=int, default=200, help="of known motions")
    parser.add_argument("--objective", choices=OBJECTIVES, default=OBJECTIVES[0], help="of known motions")
    parser.add_argument("--dt", action="store_true", help="known motions with the velocity limits that they just keep")
    parser.add_argument("--angles", type=int, default=2000, help="arm angles of the sweep")
    chosen = parser.parse_args(arguments)
    try:
        arm = (subjects.load if chosen.robot in subjects.FILES.keys() - OF_MAKERS.keys() else load)(chosen.robot)
    except srs_ik.SrsIkError as error:
        print(error)
        return 2
    begin = time.process_time()
    line, failed = PARTS[chosen.what](arm, chosen)
    print(f"{chosen.robot} {line} ({time.process_time() - begin:.0f} s)", flush=True)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
