"""Whether every question of one pose is answered as well as a posture that is known, on limbs that nobody builds.

Run: python benchmarks/questions.py [--limbs 300] [--poses 4] [--first 0] [--miss 0.005] [--ranges narrow]

Random limbs whose axes miss by up to so much of their lengths (0: exact ones), in all patterns of axes, with joint
ranges of one kind. A pose is that of a random configuration inside the limits, a part of them close to singular. Asked
are: intervals; the posture of a branch at its arm angle, with and without a seed; the nearest to seeds on and around
it, of all and of its branch; the best of all; all branches; the optimum of objectives; without limits as well.
No answer may be none, nor worse than the known posture, nor than the best one of a sweep over the intervals. Every
failure is printed with what it takes to see it again.
"""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from near_limbs import CLOSE, ahead
from oracles import RandomLimb, inside, phases
from strange_limbs import RANGES, strange_limb
from subjects import say

import srs_ik

AROUND = (0.0, 0.05, 0.3, 1.0)
"""How far seeds are from the known posture, rad a joint."""

OFFSETS = (0.0, 1e-6, 1e-4, 1e-3, 1e-2, 0.05)
"""How far joints 2, 4 and 6 are from singular in a part of the poses, rad."""

SINGULAR = 0.3
SWEPT = 8
"""The part of such poses; arm angles of a sweep over an interval."""

WORSE = 1e-7
"""An answer this much farther from its seed, rad, or worse by its objective, has missed something; ..."""

SELF = 1e-9
"""... and one to a seed that is the posture itself, farther than this, or worse by joints this far off, rad."""

SURE, VAGUE = 1e-3, 1e-5
"""Where a singular value or sine is below the first, answers may be so far off, rad: `singular.py` asks of those."""


def posture(limb: RandomLimb, singular: dict[int, float]) -> np.ndarray:
    """A random configuration inside the limits; of a part of them a middle joint or more is close to singular."""
    q, rng = limb.configuration(), limb.rng
    if rng.random() < SINGULAR:
        for j, angle in singular.items():
            there = angle + np.pi * rng.integers(-1, 2) + rng.choice(OFFSETS) * rng.choice([-1.0, 1.0])
            if rng.random() < 0.6 and limb.lower[j] <= there <= limb.upper[j]:
                q[j] = there
    return q


def margin(arm: srs_ik.Arm, q: np.ndarray) -> float:
    """Smallest distance from a limit over half of the joint's range; 1 at most."""
    return float(srs_ik.Objective("limit_margin").values(arm, q)[0])


class Asked:
    """One pose of one limb, and all that is asked of it."""

    def __init__(self, arm: srs_ik.Arm, q: np.ndarray, rng: np.random.Generator) -> None:
        self.arm, self.q, self.rng = arm, q, rng
        self.pose = arm.forward_kinematics(q)
        self.branch, self.psi = arm.branch(q), arm.arm_angle(q)
        smallest = np.linalg.svd(arm.jacobian(q))[1][5]
        singular = [np.sin(q[j] - angle) for j, angle in phases(arm.limb).items()]
        self.told = min(smallest, *map(abs, singular)) > SURE
        self.vague = VAGUE + min(1e-14 / max(smallest, 1e-300), 1e-2)

    def sweep(self, seed: np.ndarray | None) -> np.ndarray:
        """Postures inside the limits all along the intervals, those nearest to a seed if there is one: (n, 7)."""
        found = []
        for branch in sorted({i.branch for i in self.intervals}):
            own = [i for i in self.intervals if i.branch == branch]
            angles = np.concatenate([np.linspace(i.lower, i.upper, SWEPT + 2)[1:-1] for i in own])
            poses = np.tile(self.pose.homogeneous, (len(angles), 1, 1))
            there = self.arm.solve_batch(poses, arm_angle=angles, seed=seed, branch=branch, threads=1)
            found.append(there.q[there.ok])
        return np.concatenate(found) if found else np.empty((0, 7))

    def seeded(self, around: float, respect: bool) -> Iterator[tuple[str, float]]:
        """By how much answers to a seed are farther than the known posture, or the best of a sweep; rad."""
        arm, free = self.arm, "" if respect else " free"
        seed = self.q + around * self.rng.uniform(-1.0, 1.0, 7)
        if respect:
            seed = np.clip(seed, arm.lower, arm.upper)
        known = float(np.linalg.norm(self.q - seed))
        allowed = (SELF if self.told else self.vague) if around == 0.0 else (WORSE if self.told else self.vague)
        Q = self.sweep(seed) if respect and around > 0.0 else np.empty((0, 7))
        settings = {"": {}, " branch": {"branch": self.branch}}
        if self.told:
            settings |= {" angle": {"arm_angle": self.psi}, " both": {"arm_angle": self.psi, "branch": self.branch}}
        for name, setting in settings.items():
            s = arm.solve(self.pose, seed=seed, respect_limits=respect, **setting)
            away = float(np.linalg.norm(s.q - seed)) if self.is_right(s, respect) else np.inf
            yield f"seed {around:g}{name}{free}", (away - known) / allowed
            if respect and around > 0.0 and name in ("", " branch"):
                least = np.linalg.norm(Q - seed, axis=1) if len(Q) else np.empty(0)
                if name:
                    least = least[[arm.branch(q) == self.branch for q in Q]]
                yield f"seed {around:g}{name}, sweep", (away - min(least, default=np.inf)) / max(allowed, WORSE)

    def is_right(self, s: srs_ik.Solution, respect: bool) -> bool:
        """Whether an answer is one: OK, inside the limits, and where the pose is."""
        limits = not respect or inside(s.q, self.arm.lower, self.arm.upper)
        return bool(s) and limits and max(self.arm.verify(self.pose, s.q)) < 1e-9

    def there(self, respect: bool) -> Iterator[tuple[str, float]]:
        """Whether what is known is there: 0 or inf."""
        arm, q, pose, free = self.arm, self.q, self.pose, "" if respect else " free"
        self.intervals = arm.intervals(pose, respect_limits=respect)
        off = min((ahead(i, self.psi) for i in self.intervals if i.branch == self.branch), default=np.inf)
        if self.told:
            yield f"intervals{free}", off / CLOSE
            branches = [s.branch for s in arm.solve_all(pose, respect_limits=respect)]
            yield f"all{free}", 0.0 if self.branch in branches else np.inf
            at = [s.branch for s in arm.solve_all(pose, arm_angle=self.psi, respect_limits=respect)]
            yield f"all at angle{free}", 0.0 if self.branch in at else np.inf
            for name, wanted in (("angle", None), ("branch at angle", self.branch)):
                s = arm.solve(pose, arm_angle=self.psi, branch=wanted, respect_limits=respect)
                yield f"{name}{free}", 0.0 if self.is_right(s, respect) else np.inf
            s = arm.solve(pose, branch=self.branch, respect_limits=respect)
            yield f"branch{free}", 0.0 if self.is_right(s, respect) else np.inf
        s = arm.solve(pose, respect_limits=respect)
        yield f"best{free}", 0.0 if self.is_right(s, respect) else np.inf
        if not respect:
            return
        Q = np.vstack([q[None], self.sweep(None)])
        narrowest = float((arm.upper - arm.lower).min())
        if self.told and narrowest > SELF:
            lost = max(margin(arm, p) for p in Q) - margin(arm, s.q)
            yield "best, margin", lost / (WORSE + SELF / narrowest)
        for name, parameters in (("manipulability", {}), ("reference_posture", {"reference": q})):
            objective = srs_ik.Objective(name, **parameters)
            o = arm.optimise(pose, objective)
            sign = 1.0 if objective.maximise else -1.0
            values = [sign * objective.values(arm, p)[0] for p in [*Q, o.q]]
            lost = (max(values[:-1]) - values[-1]) / (WORSE * (1.0 + abs(values[-1])))
            lost = lost if self.is_right(o, True) else np.inf
            yield name, lost

    def outside(self) -> Iterator[tuple[str, float]]:
        """Whether the verdict on a pose whose known posture breaks a limit is true, as far as others tell."""
        q = self.q.copy()
        j = int(self.rng.integers(7))
        if not np.isfinite(self.arm.upper[j]):
            return
        q[j] = self.arm.upper[j] + self.rng.uniform(0.01, 0.5)
        pose = self.arm.forward_kinematics(q)
        s, some = self.arm.solve(pose), self.arm.intervals(pose)
        good = bool(s) == bool(some) and s.status != srs_ik.Status.UNREACHABLE
        if s:
            good = good and max(self.arm.verify(pose, s.q)) < 1e-9 and inside(s.q, self.arm.lower, self.arm.upper)
        yield "verdict", 0.0 if good else np.inf

    def all(self) -> Iterator[tuple[str, float]]:
        for respect in (False, True):
            yield from self.there(respect)
            for around in AROUND:
                yield from self.seeded(around, respect)
        yield from self.outside()


def main() -> int:
    """Ask, print a line a failure and a table; the exit status says whether there were any."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--limbs", type=int, default=300)
    parser.add_argument("--poses", type=int, default=4, help="poses a limb (default 4)")
    parser.add_argument("--first", type=int, default=0, help="seed of the first limb (default 0)")
    parser.add_argument("--miss", type=float, default=0.005, help="of the length shoulder-elbow-wrist (default 0.005)")
    parser.add_argument("--ranges", choices=RANGES, default="mixed", help="kind of joint ranges (default mixed)")
    chosen = parser.parse_args()
    asked: dict[str, list[int]] = defaultdict(lambda: [0, 0])
    for seed in range(chosen.first, chosen.first + chosen.limbs):
        limb = strange_limb(seed, chosen.ranges, chosen.miss)
        try:
            arm = srs_ik.load(limb.model, base="base", tip="tool")
        except srs_ik.NotAnSrsLimb:
            continue
        singular = phases(arm.limb)
        for number in range(chosen.poses):
            q = posture(limb, singular)
            for name, lost in Asked(arm, q, np.random.default_rng([seed, number])).all():
                asked[name][0] += 1
                if not lost <= 1.0:
                    asked[name][1] += 1
                    say(f"limb {seed}, pose {number}: {name}, {lost:.2g}; q = {q.tolist()}")
        if sys.stderr.isatty():
            print(f"\r{seed - chosen.first + 1} of {chosen.limbs} limbs", end="", file=sys.stderr, flush=True)
    width = max(map(len, asked))
    for name, (of, failed) in sorted(asked.items()):
        print(f"{name:{width}} {failed:5d} of {of}")
    total = np.array(list(asked.values())).sum(axis=0)
    print(f"{chosen.ranges}, {100.0 * chosen.miss:g} %: {total[1]} of {total[0]} answers fail")
    return int(total[1] > 0)


if __name__ == "__main__":
    sys.exit(main())
