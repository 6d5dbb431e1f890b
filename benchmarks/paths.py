"""Whether joint paths are the best there are: known motions, whose tip poses `solve_path` is given.

python benchmarks/paths.py [--motions 20] [--poses 200] [--urdf med14=FILE ...] [--arms iiwa14 ...] [--kinds cross ...]

A known motion is a sum of two sines a joint inside the limits. Whoever is given its poses must not break, and must not
take more than it: less is possible. Prints a Markdown table; docs/redundancy.md holds the outcome. Robots whose files
are not here are left out; --urdf says where one is.
"""

from __future__ import annotations

import argparse
import time
import zlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np

import srs_ik
from srs_ik.bench.report import machine

ARMS = (
    "iiwa14",
    "med7",
    "med14",
    "openarm_left",
    "human_left",
    "human_arm",
    "romeo_left",
    "sia10",
    "rm75",
    "gen3",
    "j2s7s300",
    "h1_2_left",
)
KINDS = ("aside", "cross", "limits", "singular")
BESIDE = Path(__file__).resolve().parents[2] / "shared" / "urdf"
OF_MAKERS = {
    "med7": "med7_lbr_stack",
    "openarm_left": "openarm_v10_bimanual",
    "sia10": "motoman_sia10f",
    "rm75": "realman_rm75",
    "j2s7s300": "kinova_j2s7s300",
    "h1_2_left": "unitree_h1_2_handless",
}
"""Files of makers, used where they lie beside the checkout."""

WIDE = 1.5 * np.pi
"""Joints without limits move so far to both sides, rad."""


def known_motion(arm: srs_ik.Arm, rng: np.random.Generator, kind: str, count: int) -> np.ndarray:
    """(count, 7) joint angles, steps of one joint up to 0.05 to 0.14 rad for 200 poses.

    Kinds: "aside", joints 2, 4 and 6 stay on one side of their singular angles; "cross", anywhere inside the limits;
    "limits", joints stay on their limits for a while; "singular", joints 2, 4 and 6 swing about their singular angles.
    """
    lower, upper = np.maximum(arm.lower, -WIDE), np.minimum(arm.upper, WIDE)
    phases = np.array([0.0, phase(arm, 1), 0.0, phase(arm, 3), 0.0, phase(arm, 5), 0.0])
    low, high = lower.copy(), upper.copy()
    for j in (1, 3, 5):
        below, above = phases[j] - 0.15 - lower[j], upper[j] - phases[j] - 0.15
        if kind == "aside" and max(below, above) > 0.0:
            up = above > 0.0 and (below <= 0.0 or rng.uniform() < above / (above + below))
            low[j], high[j] = (phases[j] + 0.15, upper[j]) if up else (lower[j], phases[j] - 0.15)
        elif kind == "singular" and min(phases[j] - lower[j], upper[j] - phases[j]) > 0.05:
            low[j], high[j] = max(low[j], phases[j] - 0.4), min(high[j], phases[j] + 0.4)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    share = rng.uniform(0.2, 0.8, 7)
    size = half * (1.4 if kind == "limits" else 0.98) * rng.uniform(0.3, 1.0, 7)
    middle = middle + (half - np.minimum(size, 0.98 * half)) * rng.uniform(-1.0, 1.0, 7)
    rates = rng.uniform(0.5, 2.0, (2, 7)) * 2.0 * np.pi
    starts = rng.uniform(0.0, 2.0 * np.pi, (2, 7))

    def at(t: np.ndarray) -> np.ndarray:
        waves = np.sin(rates[:, None] * t[:, None] + starts[:, None])
        return np.clip(middle + size * (share * waves[0] + (1.0 - share) * waves[1]), lower, upper)

    rough = np.abs(np.diff(at(np.linspace(0.0, 1.0, 400)), axis=0)).max() * 399
    span = rng.uniform(0.05, 0.14) * 199 / rough
    return at(np.linspace(0.0, span, count))


def phase(arm: srs_ik.Arm, joint: int) -> float:
    """The angle of joint 2, 4 or 6 (1, 3, 5) that is singular, as the branches tell: they change there."""
    bit = {3: 4, 1: 2, 5: 1}[joint]
    angles = np.linspace(max(arm.lower[joint], -np.pi), min(arm.upper[joint], np.pi), 400)
    q = np.tile(np.full(7, 0.4), (400, 1))
    q[:, joint] = angles
    sides = [arm.branch(row) & bit for row in q]
    changes = np.flatnonzero(np.diff(sides))
    if not len(changes):
        return float(min((arm.lower[joint], arm.upper[joint]), key=abs))
    nearest = min(changes, key=lambda i: abs(angles[i]))
    return float(0.5 * (angles[nearest] + angles[nearest + 1]))


class Tally:
    """What one arm's motions showed."""

    def __init__(self) -> None:
        self.motions = self.poses = 0
        self.breaks = {True: 0, False: 0}
        self.larger = {True: 0, False: 0}
        self.gains: list[float] = []
        self.steps: list[float] = []
        self.taken = 0.0
        self.failures: list[tuple] = []

    def add(self, known: np.ndarray, path: srs_ik.PathSolution, seeded: bool, taken: float) -> None:
        self.taken += taken
        self.poses += len(known)
        own = np.diff(known, axis=0)
        steps = path.steps if not seeded else np.vstack([path.q[0] - known[0], path.steps])
        least, most = float((own**2).sum()), float((steps**2).sum())
        if not path:
            self.breaks[seeded] += 1
            return
        if most > least * (1.0 + 1e-6):
            self.larger[seeded] += 1
        if seeded:
            self.gains.append(most / least)
            self.steps.append(path.largest_step / np.abs(own).max())


def measure(arm: srs_ik.Arm, kind: str, motions: int, count: int, dt: bool, verbose: bool) -> Tally:
    tally = Tally()
    for number in range(motions):
        rng = np.random.default_rng([zlib.crc32(arm.name.encode()), KINDS.index(kind), number])
        known = known_motion(arm, rng, kind, count)
        poses = np.array([arm.forward_kinematics(q).homogeneous for q in known])
        seconds = None
        if dt:
            seconds = float((np.abs(np.diff(known, axis=0)) / arm.velocity_limit).max()) * 1.05
        for seeded in (True, False):
            begin = time.process_time()
            path = arm.solve_path(poses, seed=known[0] if seeded else None, dt=seconds)
            before = dict(tally.breaks), dict(tally.larger)
            tally.add(known, path, seeded, time.process_time() - begin)
            if dt and path and (np.abs(path.steps) > arm.velocity_limit * seconds * (1 + 1e-9)).any():
                tally.breaks[seeded] += 1
            if verbose and (tally.breaks, tally.larger) != before:
                print(f"  {arm.name} {kind} {number} seeded={seeded}: {path} {path.breaks[:2]}")
        tally.motions += 1
    return tally


def measure_ssik(arm: srs_ik.Arm, kind: str, motions: int, count: int) -> str:
    """ssik's own paths from the known start on the same motions: how many are whole and inside the limits."""
    from ssik import Manipulator

    theirs = Manipulator.from_prebuilt(arm.name)
    whole, gains, taken = 0, [], 0.0
    for number in range(motions):
        rng = np.random.default_rng([zlib.crc32(arm.name.encode()), KINDS.index(kind), number])
        known = known_motion(arm, rng, kind, count)
        poses = np.array([theirs.fk(q) for q in known])
        begin = time.process_time()
        track = theirs.solve_path(poses, q0=known[0])
        taken += time.process_time() - begin
        for label in track.tracks:
            q = np.asarray(track.q(label))
            if len(q) == count and ((q >= arm.lower) & (q <= arm.upper)).all():
                steps = np.vstack([q[0] - known[0], np.diff(q, axis=0)])
                if np.abs(steps).max() <= 0.5:
                    whole += 1
                    gains.append((steps**2).sum() / (np.diff(known, axis=0) ** 2).sum())
                    break
    ratio = f"{np.median(gains):.3f}, {max(gains):.3f}" if gains else "none"
    return f"| ssik | {kind} | {motions} | {whole} whole | {ratio} | {1e6 * taken / (motions * count):.0f} |"


def load_all(names: Sequence[str], files: dict[str, str]) -> list[srs_ik.Arm]:
    """The robots whose files are here, or beside the checkout."""
    arms = []
    for name in names:
        beside = BESIDE / f"{OF_MAKERS.get(name, name)}.urdf"
        file = files.get(name, beside if beside.is_file() else None)
        try:
            arms.append(srs_ik.load(name) if file is None else srs_ik.load(name, urdf=file))
        except srs_ik.SrsIkError as error:
            print(f"{name} is left out: {error}\n")
    return arms


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--motions", type=int, default=20, help="motions of each kind")
    parser.add_argument("--poses", type=int, default=200, help="poses of a motion")
    parser.add_argument("--arms", nargs="+", default=ARMS)
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=KINDS)
    parser.add_argument("--dt", action="store_true", help="with the velocity limits that the known motion just keeps")
    parser.add_argument("--ssik", action="store_true", help="ssik's paths on the same motions too, for its own arms")
    parser.add_argument("--verbose", action="store_true", help="name the motions that fail")
    parser.add_argument(
        "--urdf", nargs="*", default=[], metavar="ROBOT=FILE", help="files of robots that are elsewhere"
    )
    chosen = parser.parse_args(arguments)
    files = dict(entry.split("=", 1) for entry in chosen.urdf)
    print(", ".join(f"{name} {value}" for name, value in machine().items()))
    print(f"\n### {chosen.poses} poses a motion\n")
    print(
        "| arm | kind | motions | breaks, seeded / free | larger sum, seeded / free | sum over the known, median",
        end="",
    )
    print(" and worst | largest step over the known, median and worst | CPU us a pose |")
    print("|---|---|--:|--:|--:|--:|--:|--:|")
    for arm in load_all(chosen.arms, files):
        for seed in (None, np.clip(np.zeros(7), arm.lower, arm.upper)):
            arm.solve_path([arm.forward_kinematics(np.clip(np.full(7, 0.3), arm.lower, arm.upper))] * 3, seed=seed)
        for kind in chosen.kinds:
            t = measure(arm, kind, chosen.motions, chosen.poses, chosen.dt, chosen.verbose)
            gains, steps = t.gains or [np.nan], t.steps or [np.nan]
            print(
                f"| `{arm.name}` | {kind} | {t.motions} | {t.breaks[True]} / {t.breaks[False]} "
                f"| {t.larger[True]} / {t.larger[False]} | {np.median(gains):.3f}, {max(gains):.3f} "
                f"| {np.median(steps):.2f}, {max(steps):.2f} | {1e6 * t.taken / t.poses:.0f} |",
                flush=True,
            )
            if chosen.ssik:
                print(measure_ssik(arm, kind, chosen.motions, chosen.poses), flush=True)


if __name__ == "__main__":
    main()
