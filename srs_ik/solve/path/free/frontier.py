"""Joint paths through poses that leave a turn free, by postures all over what these leave, from pose to pose.

Some postures of each pose stand for all that a path may have reached there. From each of them on, its own way and one
beside it are taken to the next pose, and of what is met there those are kept that are far from one another: where a
path has to pass limits or leave its cone in time, some are already on the other side. On the true chain, and as slow as
it is sure: it is asked where paths between sampled turns break.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from srs_ik.inputs.freedom import FreeAxis
from srs_ik.kernels.layout.path import BREAK, BY_CONTINUITY, INVERSE_PERIOD, PERIOD
from srs_ik.solve.freedom import met_batch, solve_batch
from srs_ik.solve.path.free.relaxed import ways_of
from srs_ik.solve.path.problem import Problem, steps_of
from srs_ik.solve.threads import tell
from srs_ik.system.arrays import Array

Keys = NDArray[np.int64]

KEPT, SEARCHED = 64, 256
"""Postures of a pose that are kept, and postures from which they are looked for at a pose where a path begins."""

ASIDE, LEAST_ASIDE = 0.4, 0.2
"""So far joints move aside from one pose to the next, rad, if limits let them, and no less than this part of it."""

LONGEST = 1.0
"""Where poses between two are left out, joints may step so far, rad."""

TURN = 2.0 * np.pi

SAME = 1e-3
"""Postures closer than this, rad, are one."""

TOO_FAST, HOW_FAST = 1e5, 1e3
"""Cost of a step beyond the velocity limits, and what is added to it where it is as many times beyond as can be."""


@dataclass(frozen=True, slots=True)
class Layer:
    """Postures of a pose (k, 7), what a path to each costs, and from which one of the pose before it comes."""

    q: Array
    cost: Array
    parents: Keys


def wandered(problem: Problem, free: FreeAxis, keys: Keys) -> Array:
    """(k, 7) postures of key poses, each of which some posture meets, with as few breaks between them as are found."""
    forth, breaks = _wandered(problem, free, keys)
    if breaks == 0:
        return forth
    back, fewer = _wandered(replace(problem, seed=None), free, keys[::-1])
    return back[::-1] if fewer < breaks else forth


def _wandered(problem: Problem, free: FreeAxis, keys: Keys) -> tuple[Array, int]:
    rng = np.random.default_rng(0)
    layer = _begun(problem, free, keys[0], rng)
    if problem.seed is not None:
        layer = replace(layer, cost=(_apart(problem, problem.seed[None], layer.q)[0] ** 2).sum(axis=1))
    layers = [layer]
    for number in range(1, len(keys)):
        tell(number, len(keys))
        layers.append(_followed(problem, free, layers[-1], (keys[number - 1], keys[number]), rng))
    at = int(layers[-1].cost.argmin())
    breaks = int(layers[-1].cost[at] // BREAK)
    q = np.empty((len(keys), 7))
    for number in range(len(keys) - 1, -1, -1):
        q[number], at = layers[number].q[at], layers[number].parents[at]
    return np.vstack([q[:1], q[0] + np.cumsum(steps_of(problem, q), axis=0)]), breaks


def _begun(problem: Problem, free: FreeAxis, key: int, rng: np.random.Generator) -> Layer:
    """Postures of a pose from anywhere."""
    arm = problem.arm
    upper = np.where(np.isfinite(arm.upper), arm.upper, np.where(np.isfinite(arm.lower), arm.lower + TURN, 0.5 * TURN))
    lower = np.where(np.isfinite(arm.lower), arm.lower, upper - TURN)
    T = np.repeat(problem.T[key : key + 1], SEARCHED, axis=0)
    q, met = met_batch(arm, T, free, rng.uniform(lower, upper, (SEARCHED, 7)))
    alone = solve_batch(arm, T[:1], free, problem.seed, True, 1).q
    q = np.vstack([alone, q[met]])
    q = q[_far_apart(problem, q, 0)]
    return Layer(q, np.zeros(len(q)), np.zeros(len(q), np.int64))


def _followed(
    problem: Problem, free: FreeAxis, before: Layer, keys: tuple[int, int], rng: np.random.Generator
) -> Layer:
    """The postures of a pose that continue those of the one before; if none does, postures from anywhere."""
    arm, (last, key) = problem.arm, keys
    passed = abs(key - last)
    longest = problem.settings[BY_CONTINUITY]
    longest = np.minimum(longest * passed, np.maximum(longest, LONGEST))
    within = problem.settings[: BY_CONTINUITY + 1].min(axis=0) * passed
    T = problem.T[[last, key]]
    ways = ways_of(arm, np.repeat(T[:1], len(before.q), axis=0), free, before.q)[0]
    aside = np.einsum("kji,ki->kj", ways, rng.normal(size=ways.shape[::2]))
    aside *= rng.uniform(LEAST_ASIDE, 1.0, (len(aside), 1))
    aside /= np.abs(aside / np.minimum(within, ASIDE)).max(axis=1)[:, None] + 1e-12
    wanted = np.clip(np.vstack([before.q, before.q + aside]), arm.lower, arm.upper)
    q, met = met_batch(arm, np.repeat(T[1:], len(wanted), axis=0), free, wanted)
    q = q[met]
    cost, parents = _cheapest(problem, before, q, within, longest)
    some = np.flatnonzero(np.isfinite(cost))
    if not len(some):
        q = _begun(problem, free, key, rng).q
        cost, parents = _cheapest(problem, before, q, within, np.full(7, np.inf))
        cost += BREAK
        some = np.arange(len(q))
    # Others have passed the velocity limits more often, and will always have.
    some = some[cost[some] // TOO_FAST == cost[some].min() // TOO_FAST]
    some = some[_far_apart(problem, q[some], int(cost[some].argmin()))]
    return Layer(q[some], cost[some], parents[some])


def _cheapest(problem: Problem, before: Layer, q: Array, within: Array, longest: Array) -> tuple[Array, Keys]:
    """What a path to each of some postures costs at least, infinity where steps are too long, and where it is from."""
    if not len(q):
        return np.empty(0), np.empty(0, np.int64)
    steps = np.abs(_apart(problem, before.q, q))
    cost = before.cost[:, None] + (steps**2).sum(axis=2)
    share = (steps / within).max(axis=2)
    cost += np.where(share > 1.0, TOO_FAST + HOW_FAST * (1.0 - 1.0 / np.maximum(share, 1.0)), 0.0)
    cost[(steps > longest).any(axis=2)] = np.inf
    return cost.min(axis=0), cost.argmin(axis=0)


def _apart(problem: Problem, a: Array, b: Array) -> Array:
    """(k, m, 7) joint steps from postures (k, 7) to others (m, 7)."""
    steps = b - a[:, None]
    return np.asarray(steps - problem.settings[PERIOD] * np.round(steps * problem.settings[INVERSE_PERIOD]))


def _far_apart(problem: Problem, q: Array, first: int) -> Keys:
    """Which of some postures to keep: the first, and one after the other the one that is farthest from all of these."""
    chosen = [first]
    near = np.abs(_apart(problem, q[chosen], q)[0]).max(axis=1)
    while len(chosen) < KEPT and near.max() > SAME:
        chosen.append(int(near.argmax()))
        near = np.minimum(near, np.abs(_apart(problem, q[chosen[-1:]], q)[0]).max(axis=1))
    return np.array(chosen)
