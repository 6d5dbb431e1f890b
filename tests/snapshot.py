"""Answers of exact, almost exact, near and oblique limbs, written down and compared, so that a change of them is seen.

    python tests/snapshot.py before.npz                          # write some 10,000 answers
    python tests/snapshot.py after.npz --against before.npz      # write, and list what differs

A rearrangement of the code keeps every answer to the bit. A change of a method may change `q`, but makes no status and
no cost worse; the comparison counts both. Files that are not beside the checkout are left out.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator

import arms
import numpy as np
from oracles import random_angles, random_limb
from robot_files import SHARED

import srs_ik

FILES = ("iiwa14", "human_arm", "gen3", "rm75", "j2s7s300", "h1_2_left", "sia10f", "iiwa14_experimental")
"""Exact ones, a file rounded to a micrometre (RM75), and near ones."""

OBLIQUE = {f"oblique_{k}": {"seed": 100 + k, "miss": 0.0 if k < 4 else 0.005} for k in range(8)}
"""Random limbs with oblique axes, exact and near."""

POSES = 60
WITHIN = 0.3
"""Seeds lie within so much of a known posture, rad a joint."""

BETTER = 1e-7
"""Differences of cost that count, rad^2 or as part of a range."""


def load(name: str) -> srs_ik.Arm:
    if name in OBLIQUE:
        return srs_ik.load(random_limb(**OBLIQUE[name]).model, base="base", tip="tool")
    return arms.load(name)


def limbs() -> Iterator[tuple[str, srs_ik.Arm]]:
    for name in (*FILES, *OBLIQUE):
        if name in arms.REAL and not (SHARED / f"{arms.REAL[name][0]}.urdf").is_file():
            continue
        try:
            yield name, load(name)
        except srs_ik.NotAnSrsLimb:
            continue


def answers(name: str, arm: srs_ik.Arm) -> dict[str, np.ndarray]:
    """For each question the answers to all poses, (N, 10): status, branch, cost (NaN without one) and q.

    For intervals: 0, their number, minus their whole width, and the first seven of their ends.
    """
    rng = arms.generator(name, 7)
    known = np.array([random_angles(rng, arm.lower, arm.upper) for _ in range(POSES)])
    poses = np.array([arm.forward_kinematics(q).homogeneous for q in known])
    poses[-6:, :3, 3] *= rng.uniform(0.8, 1.6, (6, 1))  # some out of reach
    seeds = known + rng.uniform(-WITHIN, WITHIN, known.shape)
    far = np.array([random_angles(rng, arm.lower, arm.upper) for _ in range(POSES)])
    angles = np.array([arm.arm_angle(q) for q in known])
    others = rng.uniform(-np.pi, np.pi, POSES)

    def rows(solve: Callable[[int], srs_ik.Solution], seed: np.ndarray | None = None) -> np.ndarray:
        out = np.empty((POSES, 10))
        for i in range(POSES):
            s = solve(i)
            cost = np.nan
            if s:
                cost = margin(arm, s.q) if seed is None else float(((s.q - seed[i]) ** 2).sum())
            out[i] = [float(s.status), s.branch, cost, *s.q]
        return out

    asked: dict[str, np.ndarray] = {}
    for respect in (True, False):
        word = "limited" if respect else "free"
        keep = {"respect_limits": respect}
        asked[f"margin {word}"] = rows(lambda i, k=keep: arm.solve(poses[i], **k))
        asked[f"near {word}"] = rows(lambda i, k=keep: arm.solve(poses[i], seed=seeds[i], **k), seeds)
        asked[f"far {word}"] = rows(lambda i, k=keep: arm.solve(poses[i], seed=far[i], **k), far)
        asked[f"own angle {word}"] = rows(lambda i, k=keep: arm.solve(poses[i], arm_angle=angles[i], **k))
        asked[f"any angle {word}"] = rows(lambda i, k=keep: arm.solve(poses[i], arm_angle=others[i], **k))
        asked[f"branch {word}"] = rows(lambda i, k=keep: arm.solve(poses[i], arm_angle=angles[i], branch=i % 8, **k))
        asked[f"seeded angle {word}"] = rows(
            lambda i, k=keep: arm.solve(poses[i], arm_angle=angles[i], seed=far[i], **k), far
        )
        widths = []
        for pose in poses:
            found = arm.intervals(pose, **keep)
            ends = [end for each in found for end in (each.lower, each.upper)]
            width = sum(each.upper - each.lower for each in found)
            widths.append([0.0, len(found), -width, *np.resize(ends or [0.0], 7)])
        asked[f"intervals {word}"] = np.array(widths, dtype=float)
    return asked


def margin(arm: srs_ik.Arm, q: np.ndarray) -> float:
    """Minus the smallest distance to a limit, as part of half the range; joints without limits do not count."""
    limited = np.isfinite(arm.lower) & np.isfinite(arm.upper)
    if not limited.any():
        return 0.0
    lower, upper = arm.lower[limited], arm.upper[limited]
    half, middle = 0.5 * (upper - lower), 0.5 * (upper + lower)
    return float((np.abs(q[limited] - middle) / np.maximum(half, 1e-12)).max())


def compare(before: dict[str, np.ndarray], after: dict[str, np.ndarray]) -> int:
    """Print what differs, a line a question; returns how many answers are worse."""
    worse_in_all = 0
    total = 0
    for key in sorted(before):
        if key not in after:
            print(f"{key}: gone")
            continue
        old, new = before[key], after[key]
        total += len(old)
        same = ((old == new) | (np.isnan(old) & np.isnan(new))).all(axis=1)
        status = old[:, 0] != new[:, 0]
        gained = status & (new[:, 0] == 0)
        cost = new[:, 2] - old[:, 2]
        worse = (status & ~gained) | (cost > BETTER)
        better = gained | (cost < -BETTER)
        worse_in_all += int(worse.sum())
        if not same.all():
            which = np.flatnonzero(worse)[:8].tolist()
            print(
                f"{key}: {int((~same).sum())} of {len(old)} differ, {int(worse.sum())} worse {which}, "
                f"{int(better.sum())} better"
            )
    print(f"{total} answers, {worse_in_all} worse")
    return worse_in_all


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", help="where to write the answers")
    parser.add_argument("--against", help="answers to compare with")
    arguments = parser.parse_args()
    found: dict[str, np.ndarray] = {}
    for name, arm in limbs():
        print(name, flush=True)
        for question, rows in answers(name, arm).items():
            found[f"{name}/{question}"] = rows
    np.savez_compressed(arguments.file, **found)
    print(sum(map(len, found.values())), "answers written")
    if arguments.against:
        with np.load(arguments.against) as before:
            return int(compare(dict(before), found) > 0)
    return 0


if __name__ == "__main__":
    sys.exit(main())
