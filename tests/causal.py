"""How well a target can be followed by one who does not know its future, as a tracker does not.

Two measures beside those of `bounded`, which know what comes:

- *The step at hand*: of all steps within the limits, from where the joints are and how fast they go, the one whose tip
  comes closest to the target at its end. A tracker knows that target, so no knowledge of the future is needed.
- *A follower without foresight*: it expects the target to go on as it did, by polynomials, and every few periods linear
  programmes look for the accelerations within the limits that serve that best. It takes thousands of times as long as a
  tracker, and shares no code with it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin
from bounded import (
    AFTER,
    BEFORE,
    BLOCK,
    FOLLOWED,
    FORESEEN,
    Bounds,
    Run,
    Start,
    begins_anew,
    best_motion,
    kept_to,
    known_motion,
    late,
    leaves,
    run,
)
from scipy.optimize import lsq_linear, minimize_scalar
from tracked import NEAR_TARGET

ORDER, PAST = 3, 16
"""Of the polynomials, and through how many samples of the target."""

AHEAD = 0.2
"""How far the follower plans, seconds: a whole number of blocks."""

ROUNDS = 4
"""Linear programmes for a block."""


def least_error(start: Start, T: Any, noise: np.ndarray) -> float:
    """The least error that any step within the limits leaves, by what counts as on target: place or turn, the larger.

    To first order, which is exact to 1e-9 over a step of 2 ms. The larger of two convex functions is least where the
    least value of their weighted mean is largest.
    """
    dt, (fastest, hardest) = start.dt, start.bounds
    low = np.maximum(dt * np.maximum(-fastest, start.v - dt * hardest), start.arm.lower - start.q)
    high = np.minimum(dt * np.minimum(fastest, start.v + dt * hardest), start.arm.upper - start.q)
    middle, half = 0.5 * (low + high), np.maximum(0.5 * (high - low), 1e-15)
    tip, J = start.forward(start.q + middle), start.arm.jacobian(start.q + middle)
    left = np.concatenate([T.translation - tip.translation, tip.rotation @ pin.log3(tip.rotation.T @ T.rotation)])
    tolerance = np.array(NEAR_TARGET) + noise

    def least(share: float) -> float:
        weights = np.repeat(np.sqrt([share, 1.0 - share]) / tolerance, 3)
        return -2.0 * float(lsq_linear(weights[:, None] * J, weights * left, (-half, half), method="bvls").cost)

    return float(np.sqrt(-minimize_scalar(least, bounds=(0.0, 1.0), method="bounded").fun))


def beyond_the_step_at_hand(arm: Any, forward: Any, found: Run, bounds: Bounds, dt: float) -> np.ndarray:
    """By how much a tip that leaves its target is farther off than the step at hand, by what counts as on target.

    Of all samples on which it leaves, with a target given that has not jumped and had not been gone.
    """
    on, lost, anew = found.on, found.known.lost, begins_anew(found)
    tolerance = np.array(NEAR_TARGET) + found.noise
    out = []
    for k in np.flatnonzero(on[:-1] & ~on[1:] & ~lost[1:] & ~anew[1:]) + 1:
        start = Start(arm, forward, found.q[k], found.v[k], bounds, dt)
        out.append((found.off[k] / tolerance).max() - least_error(start, found.targets[k], found.noise))
    return np.array(out)


def expected(past: list[Any], count: int, dt: float) -> list[Any]:
    """So many poses to come: polynomials through the last ones, and through the last one itself."""
    last = past[-1]
    ways = [
        np.concatenate([T.translation - last.translation, pin.log3(T.rotation @ last.rotation.T)]) for T in past[-PAST:]
    ]
    powers = np.arange(1, ORDER + 1)
    before = dt * np.arange(1 - len(ways), 1)[:, None] ** powers * dt ** (powers - 1)
    by_power = np.linalg.lstsq(before, np.array(ways), rcond=None)[0]
    after = dt * np.arange(1, count + 1)[:, None] ** powers * dt ** (powers - 1)
    return [pin.SE3(pin.exp3(way[3:]) @ last.rotation, last.translation + way[:3]) for way in after @ by_power]


def followed_without_foresight(arm: Any, forward: Any, found: Run, span: slice, bounds: Bounds, dt: float) -> float:
    """The worst error over some samples, by `FOLLOWED`, of the follower that begins where the tracker's joints were.

    At the start of a block it knows the target up to the end of the first period, as a tracker does; but all of it that
    has been, without jitter and losses.
    """
    start, horizon = Start(arm, forward, found.q[span.start], found.v[span.start], bounds, dt), round(AHEAD / dt)
    pushes = np.zeros((horizon // BLOCK, 7))
    worst = 0.0
    for k in range(span.start, span.stop, BLOCK):
        targets = [found.targets[k], *expected(found.targets[k + 1 - PAST : k + 1], horizon - 1, dt)]
        q, v, _ = best_motion(start, targets, pushes, ROUNDS)
        worst = max(worst, start.worst(q[:BLOCK], found.targets[k : k + BLOCK]))
        pushes = np.diff(np.vstack([start.v, v[BLOCK - 1 :: BLOCK], v[-1]]), axis=0)[1:] / (BLOCK * dt)
        start = Start(arm, forward, q[BLOCK - 1], v[BLOCK - 1], bounds, dt)
    return worst


def bound_line(arm: Any, forward: Any, name: str, count: int, seed: int, dt: float) -> str:
    """One line on motions against what the limits imply."""
    counted, on, behind, beyond = 0, 0, 0, [0.0]
    close: dict[float, list[float]] = {BEFORE: [], FORESEEN: []}
    unforeseen: dict[float, list[float]] = {BEFORE: [], FORESEEN: []}
    for k in range(seed, seed + count):
        found, bounds = run(arm, forward, known_motion(arm, k, dt), dt)
        samples = ~found.known.lost
        counted += int(samples.sum())
        on += int((found.on & samples).sum())
        behind += int((late(arm, found, bounds, dt) & samples).sum())
        beyond += beyond_the_step_at_hand(arm, forward, found, bounds, dt).tolist()
        for before, said in close.items():
            for at in leaves(found, before, dt):
                said.append(kept_to(arm, forward, found, at, before, bounds, dt))
                if said[-1] <= 1.0:
                    span = slice(at - round(before / dt), at + round(AFTER / dt))
                    unforeseen[before].append(followed_without_foresight(arm, forward, found, span, bounds, dt))
    loose = NEAR_TARGET[0] / FOLLOWED[0]
    left = "; ".join(
        f"{len(said)} targets left on which it was for {before:g} s, of which a motion stays on "
        f"{sum(np.array(said) <= 1.0)} ({sum(np.array(said) <= loose)} to 1 mm and 10 mrad), and a follower without "
        f"foresight on {sum(np.array(unforeseen[before]) <= loose)} of these"
        for before, said in close.items()
    )
    return (
        f"{name}: seeds {seed} to {seed + count - 1}, {count} motions, {counted} samples: on target "
        f"{100.0 * on / counted:.2f} %, nobody could {100.0 * (counted - on - behind) / counted:.2f} %, somebody might "
        f"{100.0 * behind / counted:.2f} %; {left}; it leaves its target on {len(beyond) - 1} samples, farther off "
        f"than the step at hand by at most {max(beyond):.3f} of 1 mm or 10 mrad"
    )
