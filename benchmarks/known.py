"""Whether postures at and next to singular ones are in an interval, and arm angles of intervals are met.

python benchmarks/known.py [--count 1000] [--seed 0] [--robot iiwa14] [--kind singular] [--limits 0.3]

Poses are those of random configurations inside the limits, most of whose shoulder, elbow or wrist is singular, or
almost. The arm angle of each must lie in an interval of its branch; where a joint is singular, of either side of it.
Arm angles of all intervals are then asked for, and the answers measured by Pinocchio's figures of the arm at zero.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice

import numpy as np
from singular import ON_LIMITS, TOGETHER, Case, Known, anywhere, cases, singular_angles, told
from subjects import arms_of, finish, parser, say
from swept import wrapped

import srs_ik

SIDE = 1e-5
"""A middle angle with a sine below this may count for either side of its singularity."""

BESIDE = 1e-6
"""A posture's arm angle may lie so far beside its interval, rad ..."""

ROUNDING = 1e-14
"""... and farther where it is told badly: by so much over the bend of the elbow."""

SHARES = (0.0, 1e-3, 0.2, 0.5, 0.8, 1.0 - 1e-3, 1.0)
"""Where in an interval its postures are asked for, as a part of its width."""

MET = 1e-9
"""Largest error of an answer, m and rad."""

BLOCK = 200
"""Postures that are asked for together."""


def ordinary(arm: srs_ik.Arm, count: int, rng: np.random.Generator) -> Iterator[Case]:
    """Postures that are singular by chance alone."""
    for _ in range(count):
        q = anywhere(arm, rng)
        yield Case(q, arm.forward_kinematics(q).homogeneous, q, (), 1.0)


def beside(arm: srs_ik.Arm, case: Case, intervals: Sequence[srs_ik.Interval]) -> float:
    """How far a posture's arm angle is from the nearest interval of its branch, rad; inf if there is none."""
    singular = singular_angles(arm.limb)
    sides = {joint: np.sin(case.q[joint] - angle) for joint, angle in singular.items()}
    bits = {3: 4, 1: 2, 5: 1}
    either = sum(bits[joint] for joint, side in sides.items() if abs(side) < SIDE)
    psi, branch = arm.arm_angle(case.q), arm.branch(case.q)
    away = [
        max(abs(wrapped(psi - 0.5 * (i.lower + i.upper))) - 0.5 * i.width, 0.0)
        for i in intervals
        if (i.branch | either) == (branch | either)
    ]
    return float(min(away, default=np.inf))


def asked(intervals: Sequence[srs_ik.Interval]) -> np.ndarray:
    """(n, 2) branches and arm angles inside intervals, those at their ends included."""
    return np.array([(i.branch, i.lower + share * i.width) for i in intervals for share in SHARES]).reshape(-1, 2)


def missed(
    arm: srs_ik.Arm, some: Sequence[Case], intervals: Sequence[Sequence[srs_ik.Interval]]
) -> Iterator[tuple[Case, int, float, str]]:
    """Case, branch, arm angle and status of what is asked for inside an interval and not met."""
    rows = [asked(each) for each in intervals]
    of_case = np.repeat(np.arange(len(some)), [len(each) for each in rows])
    branches, angles = np.concatenate(rows).T if len(of_case) else np.empty((2, 0))
    poses, known = np.array([case.pose for case in some]), Known(arm)
    for branch in range(8):
        at = np.flatnonzero(branches == branch)
        if not len(at):
            continue
        found = arm.solve_batch(poses[of_case[at]], arm_angle=angles[at], branch=branch, threads=1)
        _, _, tip, R = known.moved(found.q)
        wanted = poses[of_case[at]]
        off = np.linalg.norm(tip - wanted[:, :3, 3], axis=1)
        turned = np.linalg.norm(R - wanted[:, :3, :3], axis=(1, 2))  # at least the angle, where it is small
        bad = ~found.ok | (off > MET) | (turned > MET) | ((found.q < arm.lower) | (found.q > arm.upper)).any(axis=1)
        for i in np.flatnonzero(bad):
            yield some[of_case[at[i]]], branch, float(angles[at[i]]), str(found[int(i)].status)


def main(arguments: Sequence[str] | None = None) -> None:
    made = parser(__doc__.splitlines()[0], "postures")
    kinds = ("singular", "outer", "ordinary")
    made.add_argument("--kind", choices=kinds, default="singular", help="singular, so but for the elbow, or by chance")
    made.add_argument("--limits", type=float, default=ON_LIMITS, help="part with other joints on limits (0.3)")
    given = made.parse_args(arguments)
    together = TOGETHER if given.kind == "singular" else ((1,), (5,), (1, 5))
    lost, unmet, total, tried = 0, 0, 0, 0
    for arm, count in arms_of(given.robot, given.count, given.seed):
        rng = np.random.default_rng([given.seed, tried])
        singular = cases(arm, count, rng, together, given.limits)
        every = ordinary(arm, count, rng) if given.kind == "ordinary" else singular
        while some := list(islice(every, BLOCK)):
            tried += len(some)
            intervals = list(arm.intervals_batch(np.array([case.pose for case in some]), threads=1))
            total += sum(map(len, intervals)) * len(SHARES)
            for case, of_case in zip(some, intervals, strict=True):
                bend = abs(np.sin(case.q[3] - singular_angles(arm.limb)[3]))
                away = beside(arm, case, of_case)
                if away > BESIDE + ROUNDING / max(bend, 1e-300):
                    lost += 1
                    say(f"{told(arm, case)} {away:.2g} rad beside {len(of_case)} intervals")
            for case, branch, psi, status in missed(arm, some, intervals):
                unmet += 1
                say(f"{told(arm, case)} branch {branch}, arm angle {psi!r}: {status}")
    figures = f"{tried} known postures ({given.kind}), {lost} in no interval; {total} arm angles of intervals, {unmet}"
    finish(given.robot, given.seed, f"{figures} not met", lost + unmet)


if __name__ == "__main__":
    main()
