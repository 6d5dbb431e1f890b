"""Looks for false answers: python benchmarks/no_false_ok.py [FILE ...] [--count N]

Random poses and configurations for every robot that has a name, as far as its file is here, and for every arm in the
files given. Every answer is checked by Pinocchio on the robot's file as its maker wrote it. Counted are answers

- with anything in them that is not finite,
- outside joint limits that were to be respected, whatever their status,
- that say OK and are not within 1e-9 m and 1e-9 rad of their pose,
- whose own errors are not those that Pinocchio measures,
- that say that a pose cannot be reached which is that of a configuration inside the limits.

Exit status 1 if there is one of them. Told besides: how often that is said of a configuration with joints on their
limits, where rounding of the pose alone may leave nothing inside.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from rich.console import Console
from rich.progress import track
from untouched import Untouched, distances

import srs_ik
from srs_ik import Arm, Status
from srs_ik.robot import zoo
from srs_ik.robot.places import locate

OK = 1e-9
"""What the status OK promises, m and rad."""

SAME = 1e-11
"""Reported and measured errors differ by rounding only, m and rad, and relatively."""

CLOSED = 1e-12
"""Arms whose axes miss by more, m, are followed on their true axes."""

CHUNK = 500

Make = Callable[["Subject", np.random.Generator, int], np.ndarray]


class Subject(NamedTuple):
    """An arm, and the file it comes from."""

    label: str
    arm: Arm
    forward: Untouched

    @property
    def span(self) -> tuple[np.ndarray, np.ndarray]:
        """The limits, or a whole turn where there are none."""
        arm = self.arm
        return np.where(np.isfinite(arm.lower), arm.lower, -np.pi), np.where(np.isfinite(arm.upper), arm.upper, np.pi)


def inside(subject: Subject, rng: np.random.Generator, count: int) -> np.ndarray:
    """Poses of configurations inside the limits."""
    return subject.forward.poses(rng.uniform(*subject.span, (count, 7)))


def edges(subject: Subject, rng: np.random.Generator, count: int) -> np.ndarray:
    """The same with about half of the joints on a limit, at zero or at a right angle: singular and stretched arms."""
    lower, upper = subject.span
    special = np.array([lower, upper, np.zeros(7), np.full(7, np.pi / 2), np.full(7, -np.pi / 2)])
    chosen = np.clip(special, lower, upper)[rng.integers(len(special), size=(count, 7)), np.arange(7)]
    Q = np.where(rng.random((count, 7)) < 0.5, chosen, rng.uniform(lower, upper, (count, 7)))
    return subject.forward.poses(Q)


def anywhere(subject: Subject, rng: np.random.Generator, count: int) -> np.ndarray:
    """Poses of configurations that may be outside the limits."""
    return subject.forward.poses(rng.uniform(-np.pi, np.pi, (count, 7)))


def around(subject: Subject, rng: np.random.Generator, count: int) -> np.ndarray:
    """Any rotation at any place up to 1.2 times as far as the arm reaches."""
    limb = subject.arm.limb
    poses = np.zeros((count, 4, 4))
    poses[:, 3, 3] = 1.0
    way = rng.normal(size=(count, 3))
    far = rng.uniform(0.0, 1.2 * (limb.upper_arm + limb.forearm + limb.hand), count)
    poses[:, :3, 3] = limb.shoulder + way * (far / np.linalg.norm(way, axis=1))[:, None]
    poses[:, :3, :3] = [np.linalg.qr(M)[0] for M in rng.normal(size=(count, 3, 3))]
    poses[:, :3, 0] *= np.linalg.det(poses[:, :3, :3])[:, None]
    return poses


class Call(NamedTuple):
    """A way to ask.

    Attributes:
        share: how many of a hundred questions are asked like this.
        near_share: the same for arms that are not closed in closed form, which take milliseconds for some.
        respects: whether limits are respected.
        complete: whether the answer is OK wherever a configuration inside the limits reaches the pose.
        options: what `Arm.solve_batch` gets besides the poses.
    """

    share: int
    near_share: int
    respects: bool
    complete: bool
    options: Callable[[Subject, np.random.Generator, int], dict[str, Any]]


def _angles(subject: Subject, rng: np.random.Generator, count: int) -> dict[str, Any]:
    return {"arm_angle": rng.uniform(-np.pi, np.pi, count)}


def _angles_without_limits(subject: Subject, rng: np.random.Generator, count: int) -> dict[str, Any]:
    return {**_angles(subject, rng, count), "respect_limits": False}


def _branches(subject: Subject, rng: np.random.Generator, count: int) -> dict[str, Any]:
    return {**_angles(subject, rng, count), "all_branches": True}


def _seeds(subject: Subject, rng: np.random.Generator, count: int) -> dict[str, Any]:
    return {"seed": rng.uniform(*subject.span, (count, 7))}


def _nothing(subject: Subject, rng: np.random.Generator, count: int) -> dict[str, Any]:
    return {}


POSES: tuple[Make, ...] = (inside, edges, anywhere, around)

CALLS = (
    Call(30, 44, True, False, _angles),
    Call(20, 30, False, False, _angles_without_limits),
    Call(20, 20, True, False, _branches),
    Call(25, 5, True, True, _seeds),
    Call(5, 1, True, True, _nothing),
)


class Tally:
    """What was found."""

    def __init__(self) -> None:
        self.counts: Counter[str] = Counter()
        self.worst = np.zeros(2)
        self.examples: list[str] = []

    def add(self, kind: str, wrong: np.ndarray, subject: Subject, how: str, poses: np.ndarray) -> None:
        """Count answers that are wrong in one way, and keep the first as an example."""
        number = int(np.count_nonzero(wrong))
        if number and not self.counts[kind]:
            pose = poses[np.argwhere(wrong)[0][0]].tolist()
            self.examples.append(f"{kind}: {subject.label}, {how}, pose {pose}")
        self.counts[kind] += number


WRONG = ("not finite", "outside limits", "false OK", "false errors", "missed inside")


def check(tally: Tally, subject: Subject, call: Call, make: Make, rng: np.random.Generator) -> None:
    """Ask one chunk of questions, and check every answer."""
    poses = make(subject, rng, CHUNK)
    answers = subject.arm.solve_batch(poses, threads=1, **call.options(subject, rng, CHUNK))
    how = f"poses {make.__name__}, {call.options.__name__.strip('_').replace('_', ' ')}"
    q, ok = answers.q, answers.status == Status.OK
    floats = np.concatenate(
        [q, np.stack([answers.arm_angle, answers.position_error, answers.orientation_error], axis=-1)], axis=-1
    )
    tally.add("not finite", ~np.isfinite(floats).all(axis=-1), subject, how, poses)
    if call.respects:
        outside = ((q < subject.arm.lower) | (q > subject.arm.upper)).any(axis=-1)
        tally.add("outside limits", outside, subject, how, poses)
    wanted = poses.reshape(len(poses), *(1,) * (q.ndim - 2), 4, 4)
    errors = np.stack(distances(wanted, subject.forward.poses(q.reshape(-1, 7)).reshape(*q.shape[:-1], 4, 4)), axis=-1)
    reported = np.stack([answers.position_error, answers.orientation_error], axis=-1)
    tally.add("false OK", ok & (errors > OK).any(axis=-1), subject, how, poses)
    tally.add("false errors", (np.abs(errors - reported) > SAME * (1.0 + errors)).any(axis=-1), subject, how, poses)
    if call.complete and make in (inside, edges):
        tally.add(f"missed {make.__name__}", ~ok, subject, how, poses)
        tally.counts[f"known {make.__name__}"] += CHUNK
    tally.counts["asked"] += CHUNK
    tally.counts["answers"] += ok.size
    tally.counts["OK"] += int(ok.sum())
    if ok.any():
        tally.worst = np.maximum(tally.worst, errors[ok].max(axis=0))


def subjects(files: Sequence[Path], out: Console) -> Iterator[Subject]:
    """Every robot with a name whose file is here, then every arm in the files."""
    for name in srs_ik.robots():
        card = zoo.card(name)
        try:
            arm = srs_ik.load(name)
            path = Path(card.urdf) if name in zoo.robots() else locate(card.places, name).path
        except srs_ik.SrsIkError:
            out.print(f"skipped, for its file is not here: {name}")
            continue
        yield Subject(name, arm, Untouched(path, arm))
    for path in files:
        for report in srs_ik.find_limbs(path):
            if report.limb is not None:
                arm = srs_ik.load(path, base=report.base, tip=report.tip)
                yield Subject(f"{path.name} {report.tip}", arm, Untouched(path, arm))


def plan(arms: Sequence[Subject], count: int) -> list[tuple[Subject, Call, Make]]:
    """One entry a chunk: every call with every way to make poses, for every arm, in turn."""
    cells = [
        (subject, call, make)
        for subject in arms
        for call in CALLS
        for make in POSES
        for _ in range(call.near_share if subject.arm.limb.misses.max() > CLOSED else call.share)
    ]
    chunks = -(-count // CHUNK)
    picked = np.random.default_rng(0).permutation(len(cells))
    return [cells[picked[k % len(cells)]] for k in range(chunks)]


def main(arguments: Sequence[str] | None = None) -> int:
    """Ask, check, and print one line of figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="*", type=Path, help="robot files besides those of the robots with names")
    parser.add_argument("--count", type=int, default=1_000_000, help="poses in all (default: 1000000)")
    parser.add_argument("--seed", type=int, default=1, help="of the random numbers (default: 1)")
    options = parser.parse_args(arguments)
    if options.count < 1:
        parser.error("--count takes a number of poses, at least 1")
    out = Console(stderr=True)
    started = time.perf_counter()
    arms = list(subjects(options.files, out))
    rng, tally = np.random.default_rng(options.seed), Tally()
    for entry in track(
        plan(arms, options.count), "Looking for false answers", console=out, disable=not out.is_terminal
    ):
        check(tally, *entry, rng)
    for example in tally.examples:
        print(example)
    n = tally.counts
    found = ", ".join(f"{n[kind]} {kind}" for kind in WRONG)
    print(
        f"{n['asked']:,} poses, {n['answers']:,} answers of {len(arms)} arms: {found} (of {n['known inside']:,}); "
        f"{n['OK']:,} OK, the worst {tally.worst[0]:.1e} m and {tally.worst[1]:.1e} rad; "
        f"{n['missed edges']} missed on limits (of {n['known edges']:,}); {time.perf_counter() - started:.0f} s"
    )
    return int(any(n[kind] for kind in WRONG))


if __name__ == "__main__":
    sys.exit(main())
