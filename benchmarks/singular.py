"""Whether seeded answers at and next to singular poses are the nearest: against descents from all around the seed.

python benchmarks/singular.py [--count 1000] [--seed 0] [--robot iiwa14] [--joints all] [--limits 0.3] [--off next]

A pose is that of a random configuration whose shoulder, elbow or wrist is singular, or almost, and whose other joints
may be on limits. What is nearer to a seed than an answer lies in the ball around the seed through that answer. Starts
all over this ball, the known configuration, the splits of its sums and the seed lead to curves of the pose's postures,
and starts from a dense sweep along these to the minima of the distance inside the limits (`in_ball`), polished by
SciPy: an answer must not be farther than these. Where floats do not tell postures apart, both are closed with more bits
first, or that from the sweep as far as floats can, where more bits close none.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import in_ball
import numpy as np
import pinocchio as pin
from extended import ChainInDigits, ExtendedChain
from scipy.optimize import minimize
from subjects import arms_of, finish, parser, say
from swept import Chain, wrapped

import srs_ik

OFFSETS = (0.0, 1e-12, 1e-11, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4)
BESIDE = tuple(float(off) for off in np.geomspace(1e-4, 0.2, 34))
OFF = {"next": OFFSETS, "beside": BESIDE}
"""How far the singular joints are off, rad: next to where they are singular, or farther beside it."""

TOGETHER = ((1,), (3,), (5,), (1, 5), (1, 3), (3, 5), (1, 3, 5))
"""Which joints are singular at once, counted from 0: 1 the shoulder's, 3 the elbow, 5 the wrist's."""

CLOSED = 1e-13
"""A posture meets its pose if position (m) and orientation (rad) errors are below this."""

WORSE = 1e-6
"""An answer farther from its seed by more than this, rad, than a known posture is a failure."""

ON_LIMITS = 0.3
AROUND = 0.5
"""Part of the cases with other joints on limits, and with a seed around their posture."""

STARTS = 256
SPLITS = 240
BOTH = 48
MOST_SPLITS = 400
"""Starts all over the ball; splits of one sum, of each of two, and of all at most."""

POLISHED = 4
RESTS = 1e-7
"""Postures that are polished at most, and how far their own minimum has to be for that, rad."""

CLOSER = 40
"""Steps that bring a posture as close to its pose as floats can be."""

GIVE = 0.1
BEYOND = 0.5
"""Starts outside the ball, or the limits, by more than the one, and postures by more than the other, are left out."""


@dataclass(frozen=True)
class Case:
    """A posture at or near a singular one, its pose, and a seed."""

    q: np.ndarray
    pose: np.ndarray
    seed: np.ndarray
    joints: tuple[int, ...]
    offset: float
    on_limits: tuple[int, ...] = ()


def middle_phase(a1: np.ndarray, a2: np.ndarray, a3: np.ndarray) -> float:
    """The angle of the middle joint of three that brings the outer two axes as close to one line as can be."""
    at = a1 @ np.cross(a2, a3), a1 @ a3 - (a1 @ a2) * (a2 @ a3)
    return float(np.arctan2(*at))


def straight(limb: srs_ik.SrsLimb) -> float:
    """The elbow angle of the stretched arm."""
    a4 = limb.axes[3]
    back, forth = ((p - limb.elbow) - a4 * (a4 @ (p - limb.elbow)) for p in (limb.shoulder, limb.wrist))
    return float(np.arctan2(a4 @ np.cross(forth, -back), forth @ -back))


def singular_angles(limb: srs_ik.SrsLimb) -> dict[int, float]:
    """Angles of joints 2, 4 and 6 at which the limb is singular; exactly zero where they are but for rounding."""
    found = {1: middle_phase(*limb.axes[:3]), 3: straight(limb), 5: middle_phase(*limb.axes[4:])}
    return {joint: 0.0 if abs(angle) < 1e-12 else angle for joint, angle in found.items()}


def anywhere(arm: srs_ik.Arm, rng: np.random.Generator) -> np.ndarray:
    return rng.uniform(
        np.where(np.isfinite(arm.lower), arm.lower, -np.pi), np.where(np.isfinite(arm.upper), arm.upper, np.pi)
    )


def turned_into(arm: srs_ik.Arm, joint: int, angle: float) -> float:
    """An angle by whole turns inside a joint's limits, where it has one there; else within half a turn of zero."""
    turns = wrapped(angle) + 2.0 * np.pi * np.array([0.0, 1.0, -1.0])
    inside = turns[(turns >= arm.lower[joint]) & (turns <= arm.upper[joint])]
    return float(inside[0] if len(inside) else turns[0])


def put_on_limits(arm: srs_ik.Arm, q: np.ndarray, free: Sequence[int], rng: np.random.Generator) -> tuple[int, ...]:
    """Put up to three of some joints on limits, or a little inside of them; which ones."""
    bounded = [j for j in free if np.isfinite([arm.lower[j], arm.upper[j]]).all()]
    chosen = rng.permutation(bounded)[: rng.integers(1, 4)]
    offset = OFFSETS[rng.integers(len(OFFSETS))] if rng.random() < 0.5 else 0.0
    for j in chosen:
        above = rng.random() < 0.5
        q[j] = arm.upper[j] - offset if above else arm.lower[j] + offset
    return tuple(int(j) for j in sorted(chosen))


def cases(
    arm: srs_ik.Arm,
    count: int,
    rng: np.random.Generator,
    together: Sequence[tuple[int, ...]] = TOGETHER,
    limits: float = 0.0,
    around: float = 0.0,
    offsets: Sequence[float] = OFFSETS,
) -> Iterator[Case]:
    """Random cases whose posture keeps the limits, a part of them with joints on limits.

    A part of the seeds is around the posture, the others are anywhere.
    """
    angles = singular_angles(arm.limb)
    angles = {j: turned_into(arm, j, angle) for j, angle in angles.items()}
    reached = {j for j in angles if arm.lower[j] <= angles[j] <= arm.upper[j]}
    together = [joints for joints in together if reached.issuperset(joints)]
    made = 0
    while made < count and together:
        joints, offset = together[rng.integers(len(together))], offsets[rng.integers(len(offsets))]
        q, on_limits = anywhere(arm, rng), ()
        if limits > 0.0 and rng.random() < limits:
            on_limits = put_on_limits(arm, q, [j for j in range(7) if j not in joints], rng)
        for joint in joints:
            there = angles[joint] + np.pi * (rng.random() < 0.2)
            q[joint] = turned_into(arm, joint, there) + offset * rng.choice([-1.0, 1.0])
        if ((q < arm.lower) | (q > arm.upper)).any():
            continue
        made += 1
        seed = anywhere(arm, rng)
        if around > 0.0 and rng.random() < around:
            seed = np.clip(q + 10.0 ** rng.uniform(-4.0, -0.3) * rng.uniform(-1.0, 1.0, 7), arm.lower, arm.upper)
        yield Case(q, arm.forward_kinematics(q).homogeneous, seed, joints, offset, on_limits)


class Known:
    """Postures of a pose that are known without the answer in question."""

    def __init__(self, arm: srs_ik.Arm) -> None:
        self.arm = arm
        self.chain = Chain(arm)
        self.R_tip = arm.forward_kinematics(np.zeros(7)).rotation
        self.singular = singular_angles(arm.limb)
        self.crosses = [np.cross(np.eye(3), axis) for axis in self.chain.axes]  # K v = axis x v
        self.data = arm.model.createData()
        self.frames = [arm.model.getFrameId(name) for name in (arm.base, arm.tip)]
        self.extended = ExtendedChain(self.chain.axes, self.chain.points, self.chain.tip, self.R_tip)
        self.in_digits = ChainInDigits(self.chain.axes, self.chain.points, self.chain.tip, self.R_tip)
        squares = np.array([K @ K for K in self.crosses])
        parts = (self.chain.axes, self.chain.points, squares, self.chain.tip, self.R_tip)
        self.parts = tuple(np.ascontiguousarray(part) for part in parts)

    def moved(self, Q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Axes (n, 7, 3), points on them (n, 7, 3), tips (n, 3) and tip rotations (n, 3, 3) at postures (n, 7)."""
        R, shift = np.tile(np.eye(3), (len(Q), 1, 1)), np.zeros((len(Q), 3))
        axes, points = np.empty((len(Q), 7, 3)), np.empty((len(Q), 7, 3))
        sine, versine = np.sin(Q), 2.0 * np.sin(0.5 * Q) ** 2
        for j in range(7):
            axes[:, j], points[:, j] = R @ self.chain.axes[j], R @ self.chain.points[j] + shift
            flat = R.reshape(-1, 3)
            R = R + sine[:, j, None, None] * (flat @ self.crosses[j]).reshape(-1, 3, 3)
            R += versine[:, j, None, None] * (flat @ self.crosses[j] @ self.crosses[j]).reshape(-1, 3, 3)
            shift = points[:, j] - R @ self.chain.points[j]
        return axes, points, R @ self.chain.tip + shift, (R.reshape(-1, 3) @ self.R_tip).reshape(-1, 3, 3)

    def errors_of_one(self, q: np.ndarray, pose: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The twist that leads from a posture (7,) to a pose, by Pinocchio, and the Jacobian: (6,), (6, 7)."""
        model, data = self.arm.model, self.data
        J = pin.computeFrameJacobian(model, data, self.arm.configuration(q), self.frames[1], pin.LOCAL_WORLD_ALIGNED)
        base, tip = (pin.updateFramePlacement(model, data, frame) for frame in self.frames)
        tip, R = base.actInv(tip), base.rotation
        J = np.concatenate([R.T @ J[:3], R.T @ J[3:]])
        return np.concatenate([pose[:3, 3] - tip.translation, pin.log3(pose[:3, :3] @ tip.rotation.T)]), J

    def toward(self, q: np.ndarray, joint: int) -> float:
        """1.0 where the outer axes around a singular middle joint (1 or 5) point the same way, else -1.0."""
        return 1.0 if np.cos(q[joint] - self.singular[joint]) > 0.0 else -1.0

    def is_singular(self, Q: np.ndarray, joint: int) -> np.ndarray:
        return np.abs(np.sin(Q[..., joint] - self.singular[joint])) < 2e-4

    def splits(self, q: np.ndarray) -> np.ndarray:
        """Other splits of the sums that a posture next to a singular one leaves free; (n, 7), not yet closed."""
        free = [joint for joint in (1, 5) if self.is_singular(q, joint)]
        if not free:
            return q[None]
        grids = np.meshgrid(
            *[np.linspace(-np.pi, np.pi, SPLITS if len(free) == 1 else BOTH, endpoint=False)] * len(free)
        )
        Q = np.tile(q, (grids[0].size, 1))
        for joint, grid in zip(free, grids, strict=True):
            Q[:, joint - 1] += grid.ravel()
            Q[:, joint + 1] -= self.toward(q, joint) * grid.ravel()
        return Q

    def swung(self, q: np.ndarray) -> list[np.ndarray]:
        """A straight arm at other arm angles, if axes 3 and 5 lie along it."""
        along = float(self.arm.limb.axes[2] @ self.arm.limb.axes[4])
        if abs(along) < 1.0 - 1e-9:
            return []
        turns = np.linspace(-np.pi, np.pi, 24, endpoint=False)
        return [q + turn * np.array([0.0, 0.0, 1.0, 0.0, -np.sign(along), 0.0, 0.0]) for turn in turns]

    def starts(self, case: Case, within: float, rng: np.random.Generator) -> np.ndarray:
        """Starts all over the ball around a case's seed, some of whose joints are where the case has them; the seed."""
        arm = self.arm
        ways = rng.normal(size=(STARTS, 7))
        Q = case.seed + ways * (within * rng.random(STARTS) / np.linalg.norm(ways, axis=1))[:, None]
        Q[::2, 3] = case.q[3]
        Q[::4, 3] = 2.0 * self.singular[3] - case.q[3]
        for j in case.on_limits:
            Q[rng.random(STARTS) < 0.5, j] = case.q[j]
        return np.clip(np.concatenate([case.seed[None], Q]), arm.lower, arm.upper)

    def splits_of(self, Q: Sequence[np.ndarray], case: Case, within: float, rng: np.random.Generator) -> np.ndarray:
        """Splits of some postures that are close enough to a case's seed, or some of them if there are many."""
        splits = self.close_enough(np.concatenate([self.splits(q) for q in Q]), case, within + GIVE)
        return splits[rng.permutation(len(splits))[:MOST_SPLITS]]

    def postures(self, case: Case, within: float) -> np.ndarray:
        """Postures of a case's pose that keep the limits and are about as close to its seed as a distance, rad."""
        rng, ball = np.random.default_rng(0), (self.parts, case.pose, self.arm.lower, self.arm.upper, case.seed)
        also = [case.q]
        if 3 in case.joints and (self.is_singular(case.q, 1) or self.is_singular(case.q, 5)):
            also += self.swung(case.q)
        splits = self.splits_of(also, case, within, rng)
        starts = np.concatenate([case.q[None], splits, self.starts(case, within, rng)])
        Q = in_ball.settled(*ball, np.concatenate([starts, in_ball.swept(*ball, starts)]), within + BEYOND)
        others = Q[self.is_singular(Q, 1) | self.is_singular(Q, 5)]
        if len(others):
            # One of each branch's is enough: those next to it lie on the same segment.
            _, first = np.unique(np.round(np.exp(1j * others[:, [1, 3, 5]]), 3), axis=0, return_index=True)
            starts = self.splits_of(others[first[:16]], case, within, rng)
            starts = np.concatenate([starts, in_ball.swept(*ball, starts)])
            Q = np.concatenate([Q, in_ball.settled(*ball, starts, within + BEYOND)])
        return Q[np.argsort(np.linalg.norm(Q - case.seed, axis=1))]

    def close_enough(self, Q: np.ndarray, case: Case, within: float) -> np.ndarray:
        """Postures within a distance from a case's seed, rad, and no farther than `GIVE` outside a limit."""
        turns = Q[..., None] + 2.0 * np.pi * np.arange(-3, 4)
        lower, upper = self.arm.lower[:, None] - GIVE, self.arm.upper[:, None] + GIVE
        away = np.where((turns >= lower) & (turns <= upper), np.abs(turns - case.seed[:, None]), np.inf)
        Q = np.take_along_axis(turns, away.argmin(-1)[..., None], -1)[..., 0]
        return Q[np.sqrt((away.min(-1) ** 2).sum(-1)) <= within]

    def polish(self, case: Case, q: np.ndarray) -> np.ndarray:
        """The nearest posture to the seed around one, by SciPy; the posture itself where that does not better it."""
        arm, seed = self.arm, case.seed
        bounds = list(zip(arm.lower, arm.upper, strict=True))
        last: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []

        def met(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            if not last or (last[0][0] != x).any():
                e, J = self.errors_of_one(x, case.pose)
                last[:] = [(x.copy(), e, -J)]
            return last[0][1:]

        constraint = {"type": "eq", "fun": lambda x: met(x)[0], "jac": lambda x: met(x)[1]}
        found = minimize(
            lambda x: float(((x - seed) ** 2).sum()),
            q,
            jac=lambda x: 2.0 * (x - seed),
            bounds=bounds,
            constraints=[constraint],
            method="SLSQP",
            options={"maxiter": 60, "ftol": 1e-14},
        ).x
        if not np.isfinite(found).all():
            return q
        found = np.clip(found, arm.lower, arm.upper)
        error = in_ball.close(self.parts, case.pose, arm.lower, arm.upper, found, in_ball.CLOSING)
        return found if error < CLOSED and np.linalg.norm(found - seed) < np.linalg.norm(q - seed) else q

    def nearest(self, case: Case, within: float) -> np.ndarray | None:
        """The nearest posture to the seed inside the limits that is found from within a distance."""
        ball = (self.parts, case.pose, self.arm.lower, self.arm.upper, case.seed)
        Q, figures = in_ball.minima(*ball, self.postures(case, within))
        order = np.argsort(figures[:, 0])
        unsure = [i for i in order if figures[i, 1] > RESTS][:POLISHED]
        chosen = [*Q[order[:1]], *[self.polish(case, Q[i]) for i in unsure if figures[i, 0] < within + GIVE]]
        met = [q for q in chosen if np.abs(self.errors_of_one(q, case.pose)[0]).max() < 2.0 * CLOSED]
        return min(met, key=lambda q: float(np.linalg.norm(q - case.seed)), default=None)

    def as_close_as_floats(self, case: Case, q: np.ndarray) -> np.ndarray:
        """The posture inside the limits next to one to which steps lead that leave the least error of the pose."""
        best, least, lower, upper = q, np.inf, self.arm.lower, self.arm.upper
        for _ in range(CLOSER):
            e, J = self.errors_of_one(q, case.pose)
            if np.abs(e).max() < least:
                best, least = q, np.abs(e).max()
            free, step = (q > lower) & (q < upper), np.zeros(7)
            step[free] = np.linalg.lstsq(J[:, free], e, rcond=1e-17)[0]
            q = np.clip(q + step * min(1.0, GIVE / max(np.abs(step).max(), GIVE)), lower, upper)
        return best

    def exactly(self, case: Case, q: np.ndarray, in_digits: bool = False) -> float:
        """The distance from the seed of a posture that is closed with more bits; inf where it closes nowhere.

        Joints that are on limits stay there, if it closes so: along its curve they may hardly leave them.
        """
        chain, lower, upper = self.in_digits if in_digits else self.extended, self.arm.lower, self.arm.upper
        closed = chain.closed(q, case.pose, lower, upper, (q == lower) | (q == upper))
        if closed is None:
            closed = chain.closed(q, case.pose, lower, upper)
        return np.inf if closed is None else float(((closed - case.seed) ** 2).sum() ** 0.5)


def farther(arm: srs_ik.Arm, known: Known, case: Case) -> float:
    """By how much the answer is farther from the seed than the nearest known posture, rad; inf if it is none."""
    solution = arm.solve(case.pose, seed=case.seed)
    if not solution:
        return np.inf
    away = float(np.linalg.norm(solution.q - case.seed))
    nearest = known.nearest(case, away)
    if nearest is None:
        return -np.inf
    least = float(np.linalg.norm(nearest - case.seed))
    if away - least <= WORSE:
        return away - least
    answer, posture = known.exactly(case, solution.q), known.exactly(case, nearest)
    if case.offset == 0.0 and not np.isfinite(posture):
        # At an exactly singular pose steps with more bits end nowhere. Floats tell its postures apart, those that are
        # as close to it as floats can be: by an error of 1e-13 one may be nearer by 1e-5.
        return away - float(np.linalg.norm(known.as_close_as_floats(case, nearest) - case.seed))
    more = (answer if np.isfinite(answer) else away) - posture
    if more > WORSE:
        answer, posture = known.exactly(case, solution.q, True), known.exactly(case, nearest, True)
        more = min(more, answer - posture if np.isfinite([answer, posture]).all() else np.inf)
    return more


def told(arm: srs_ik.Arm, case: Case) -> str:
    """A case in words."""
    limits = f", {[j + 1 for j in case.on_limits]} on limits" if case.on_limits else ""
    return f"{arm.name}: joints {[j + 1 for j in case.joints]} off by {case.offset:g}{limits}, q = {case.q.tolist()}:"


def main(arguments: Sequence[str] | None = None) -> None:
    made = parser(__doc__.splitlines()[0], "seeds")
    made.add_argument("--joints", choices=("outer", "all"), default="all", help="shoulder and wrist, or the elbow too")
    made.add_argument("--limits", type=float, default=ON_LIMITS, help="part with other joints on limits (0.3)")
    made.add_argument("--off", choices=tuple(OFF), default="next", help="up to 1e-4 rad, or from there to 0.2 (next)")
    given = made.parse_args(arguments)
    together = TOGETHER if given.joints == "all" else ((1,), (5,))
    worst, failed, tried = -np.inf, 0, 0
    for arm, count in arms_of(given.robot, given.count, given.seed):
        known, rng = Known(arm), np.random.default_rng([given.seed, tried])
        for case in cases(arm, count, rng, together, given.limits, AROUND, OFF[given.off]):
            away, tried = farther(arm, known, case), tried + 1
            failed += away > WORSE
            worst = max(worst, away)
            if away > WORSE:
                say(f"{told(arm, case)} {away:.3g} rad farther; seed = {case.seed.tolist()}")
    figures = f"{tried} seeds, {failed} farther than a known posture (1e-6 rad), the worst by {worst:.1e} rad"
    finish(given.robot, given.seed, figures, failed)


if __name__ == "__main__":
    main()
