"""Whether postures at and next to singular ones are in an interval, and arm angles of intervals are met.

python benchmarks/known.py [--count 1000] [--seed 0] [--robot iiwa14] [--kind singular] [--limits 0.3] [--off next]

Kinds: singular (shoulder, elbow and wrist), outer (shoulder and wrist alone), ordinary (none of them but by chance),
limits (none of them, one to three joints on limits).

Poses are those of random configurations inside the limits, most of whose shoulder, elbow or wrist is singular, or
almost. The arm angle of each must lie in an interval of its branch; where a joint is singular, of either side of it.
A pose is rounded, and so is what forward kinematics makes of a posture. What seems lost is therefore closed with more
bits for the pose as it is given and for others as close to it as such rounding: it is found if one of these postures is
in an interval, and counts as hidden if one of these poses has no posture there at all.
Arm angles of all intervals are then asked for, and the answers measured by Pinocchio's figures of the arm at zero:
pose, limits, and how far the elbow is from where it has that arm angle, for next to a straight one angles are vague.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import islice

import numpy as np
from singular import OFF, ON_LIMITS, TOGETHER, Case, Known, anywhere, cases, put_on_limits, singular_angles, told
from subjects import arms_of, finish, parser, say
from swept import wrapped

import srs_ik

SIDE = 1e-5
"""A middle angle with a sine below this may count for either side of its singularity."""

BESIDE = 1e-6
"""A posture's arm angle may lie so far beside its interval, rad ..."""

ROUNDING = 1e-14
"""... and farther where it is told badly: by so much over the bend of the elbow, or over S-W, by the reach."""

HIDING = 1e-15
"""What rounding makes of a pose, m and rad: forward kinematics in floats are off by up to so much."""

HIDDEN_POSES, STARTS = 12, 12
NEAREST, FARTHEST = -7.0, -2.0
LIMIT_SLACK = 1e-12
"""Poses that far off, postures from which each is closed, powers of ten between which these are from the known one,
rad; and how far outside a limit, rad, what is closed may be: answers are put back that far."""

SHARES = (0.0, 1e-3, 0.2, 0.5, 0.8, 1.0 - 1e-3, 1.0)
"""Where in an interval its postures are asked for, as a part of its width."""

MET = 1e-9
ELSEWHERE = 2e-6
"""Largest error of an answer, m and rad, and how far its elbow may be from its place, by the reach: on the one side of
the line shoulder-wrist instead of the other, where it is as close to that as one that is at every arm angle."""

ELBOW = "another arm angle, the elbow off by"

BLOCK = 200
"""Postures that are asked for together."""


def ordinary(arm: srs_ik.Arm, count: int, rng: np.random.Generator, on_limits: bool) -> Iterator[Case]:
    """Postures that are singular by chance alone; with joints on limits, if they are to be."""
    for _ in range(count):
        q = anywhere(arm, rng)
        which = put_on_limits(arm, q, range(7), rng) if on_limits else ()
        yield Case(q, arm.forward_kinematics(q).homogeneous, q, (), 1.0, which)


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


def closed_next_to(known: Known, case: Case) -> Iterator[np.ndarray | None]:
    """The posture next to a known one for its pose, and for others that rounding does not tell from it; or None."""
    arm, long, rng = known.arm, np.longdouble, np.random.default_rng(0)
    sizes = np.concatenate([[0.0], 10.0 ** np.linspace(NEAREST, FARTHEST, STARTS - 1)])
    lower, upper = arm.lower - LIMIT_SLACK, arm.upper + LIMIT_SLACK
    # The pose itself, then those to either side of it in the direction in which the tip moves least, and others.
    off = rng.uniform(-1.0, 1.0, (HIDDEN_POSES, 6))
    least = np.sign(np.linalg.svd(known.errors_of_one(case.q, case.pose)[1])[0][:, -1])
    off[0], off[1], off[2] = 0.0, least, -least
    for shift, turn in HIDING * off.reshape(-1, 2, 3):
        pose = case.pose.astype(long)
        pose[:3, :3] += np.cross(np.eye(3), -turn).astype(long) @ pose[:3, :3]
        pose[:3, 3] += shift
        starts = case.q + sizes[:, None] * rng.uniform(-1.0, 1.0, (STARTS, 7))
        found = (known.extended.closed(np.clip(start, lower, upper), pose, lower, upper) for start in starts)
        yield next((q.astype(float) for q in found if q is not None), None)


def is_found(known: Known, case: Case, intervals: Sequence[srs_ik.Interval]) -> bool | None:
    """Whether a posture seems lost by rounding alone; None where rounding decides whether the pose has it."""
    hidden = False
    for q in closed_next_to(known, case):
        if q is None:
            hidden = True
        elif beside(known.arm, replace(case, q=q), intervals) <= BESIDE:
            return True
    return None if hidden else False


def asked(intervals: Sequence[srs_ik.Interval]) -> np.ndarray:
    """(n, 2) branches and arm angles inside intervals, those at their ends included."""
    return np.array([(i.branch, i.lower + share * i.width) for i in intervals for share in SHARES]).reshape(-1, 2)


def elbows_elsewhere(known: Known, found: srs_ik.BatchSolution, psi: np.ndarray) -> np.ndarray:
    """How far the elbows of answers are from where they have the arm angles asked for, as parts of the reach; (n,).

    Less what their errors make of the direction shoulder-wrist, where the wrist is back on the shoulder.
    """
    arm, limb = known.arm, known.arm.limb
    axes, points, tip, R = known.moved(found.q)
    elbow = points[:, 3] + limb.axes[3] @ (limb.elbow - known.chain.points[3]) * axes[:, 3] - limb.shoulder
    line = tip + R @ known.R_tip.T @ (limb.wrist - known.chain.tip) - limb.shoulder
    length, reach = np.linalg.norm(line, axis=1), limb.upper_arm + limb.forearm
    off_line = np.linalg.norm(np.cross(elbow, line), axis=1) / length
    half = 0.5 * (np.array([arm.arm_angle(q) if ok else 0.0 for q, ok in zip(found.q, found.ok, strict=True)]) - psi)
    vague = (found.position_error + ROUNDING * reach) / length
    return np.where(found.ok, np.maximum(2.0 * np.abs(np.sin(half)) * off_line / reach - vague, 0.0), 0.0)


def missed(
    arm: srs_ik.Arm, some: Sequence[Case], intervals: Sequence[Sequence[srs_ik.Interval]]
) -> Iterator[tuple[Case, int, float, str]]:
    """Case, branch, arm angle, and what is wrong with the answer, of what is asked for inside an interval."""
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
        turned = np.sqrt(0.5) * np.linalg.norm(R - wanted[:, :3, :3], axis=(1, 2))  # the angle, where it is small
        bad = ~found.ok | (off > MET) | (turned > MET) | ((found.q < arm.lower) | (found.q > arm.upper)).any(axis=1)
        elsewhere = elbows_elsewhere(known, found, angles[at])
        for i in np.flatnonzero(bad | (elsewhere > ELSEWHERE)):
            what = str(found[int(i)].status) if bad[i] else f"{ELBOW} {elsewhere[i]:.2g} of the reach"
            yield some[of_case[at[i]]], branch, float(angles[at[i]]), what


def main(arguments: Sequence[str] | None = None) -> None:
    made = parser(__doc__.splitlines()[0], "postures")
    kinds = ("singular", "outer", "ordinary", "limits")
    made.add_argument("--kind", choices=kinds, default="singular", help="which postures (singular)")
    made.add_argument("--limits", type=float, default=ON_LIMITS, help="part with other joints on limits (0.3)")
    made.add_argument("--off", choices=tuple(OFF), default="next", help="up to 1e-4 rad, or from there to 0.2 (next)")
    given = made.parse_args(arguments)
    together = TOGETHER if given.kind == "singular" else ((1,), (5,), (1, 5))
    lost, hidden, unmet, other, total, tried = 0, 0, 0, 0, 0, 0
    for arm, count in arms_of(given.robot, given.count, given.seed):
        rng = np.random.default_rng([given.seed, tried])
        singular = cases(arm, count, rng, together, given.limits, offsets=OFF[given.off])
        known, every = Known(arm), singular
        if given.kind in ("ordinary", "limits"):
            every = ordinary(arm, count, rng, given.kind == "limits")
        while some := list(islice(every, BLOCK)):
            tried += len(some)
            intervals = list(arm.intervals_batch(np.array([case.pose for case in some]), threads=1))
            total += sum(map(len, intervals)) * len(SHARES)
            for case, of_case in zip(some, intervals, strict=True):
                bend = abs(np.sin(case.q[3] - singular_angles(arm.limb)[3]))
                away = beside(arm, case, of_case)
                if away > BESIDE + ROUNDING / max(bend, 1e-300):
                    found = is_found(known, case, of_case)
                    lost, hidden = lost + (found is False), hidden + (found is None)
                    if not found:
                        what = "beside" if found is False else "hidden by rounding, beside"
                        say(f"{told(arm, case)} {away:.2g} rad {what} {len(of_case)} intervals")
            for case, branch, psi, what in missed(arm, some, intervals):
                other, unmet = other + what.startswith(ELBOW), unmet + (not what.startswith(ELBOW))
                say(f"{told(arm, case)} branch {branch}, arm angle {psi!r}: {what}")
    figures = f"{tried} known postures ({given.kind}), {lost} in no interval, {hidden} hidden by rounding"
    figures = f"{figures}; {total} arm angles of intervals, {unmet} not met, {other} answers with another one"
    finish(given.robot, given.seed, figures, lost + unmet + other)


if __name__ == "__main__":
    main()
