"""The posture nearest to a seed where several parts of an almost exact limb are singular at once.

The nearest exact limb then has a surface of postures, along which sums of joints are split and a flat elbow swings. The
true chain's postures are curves next to that surface, and far from most of its points. So the surface tells what is too
far from the seed. From postures spread over the rest of it, shortest steps lead to the curves, and steps along these to
the nearest posture around.
"""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import along7
from srs_ik.kernels.algebra.pointers import keep, row
from srs_ik.kernels.chain.descent import QUICK, THOROUGH, close_fully, descend, slid
from srs_ik.kernels.chain.newton import CLOSED, LEFT, clipped, close_gently
from srs_ik.kernels.chain.rank_five import ALONE, steadily_closer, to_rank_five
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import SIZE
from srs_ik.kernels.limb import surface
from srs_ik.kernels.limb.branches import branch_of
from srs_ik.kernels.limb.goal import cost, turned

TRIES = (64, 384, 768)
"""Postures of the surface that are looked at, by how many ways there are on it."""

GIVE = 0.02
"""A curve may be closer to the seed than the surface by so much, rad."""

AROUND = 0.3
"""From postures farther from the seed than the nearest so far by more than this, rad, no steps lead to a nearer one."""

NEARLY = 1e-3
"""What comes so close to the nearest so far, as a part of the squared distance or in squared rad, is closed in on."""


@kernel
def try_from(P, q, target, goal, best, work):
    """The better of the best posture so far (q, branch, cost) and what is nearest around a posture of the surface."""
    q = turned(P, q, True, goal.seed, goal.respect)
    if math.sqrt(cost(P, q, True, goal.seed, False)) > math.sqrt(best[2]) + GIVE:
        return best
    J, A = work
    if goal.respect:
        q = clipped(P, q)
    q, error = close_gently(P, q, target.R, target.p, goal.respect, J, A)
    if error > LEFT:
        return best
    if error > 0.1 * CLOSED:
        # What is left may be worth more along directions as good as lost than all that steps to the seed gain.
        q, _ = close_fully(P, q, target, goal.respect, J, A)
    q = turned(P, q, True, goal.seed, goal.respect)
    if math.sqrt(cost(P, q, True, goal.seed, False)) > math.sqrt(best[2]) + AROUND:
        return best
    q, value = descend(P, q, target, goal, QUICK, work)
    if value < best[2] * (1.0 + NEARLY) + NEARLY:
        q, value, _ = slid(P, target, q, goal, J, A)
    return (q, branch_of(P, q), value) if value < best[2] else best


@kernel
def try_rank_five(P, target, goal, best, work):
    """The better of the best posture so far and those at or next to the posture of rank five that is next to a seed."""
    q = steadily_closer(P, goal.seed, target, work[0], work[1])
    met, q, past, ways, bends = to_rank_five(P, q, target, work[0], work[1])
    if met and abs(past) < ALONE:
        return try_from(P, q, target, goal, best, work)
    for i in range(4 if met else 0):
        way, square = ways[i // 2], -2.0 * past / bends[i // 2]
        if 0.0 < square < AROUND * AROUND:
            there = along7(q, math.sqrt(square) if i % 2 == 0 else -math.sqrt(square), way)
            best = try_from(P, there, target, goal, best, work)
    return best


@kernel
def nearest_among_splits(P, target, goal, known):
    """The posture nearest to a seed as known so far, or a nearer one where outer axes are in line: q, branch, cost."""
    if not surface.may_have_surface(P, target.place, surface.same_widths(P, target.place, surface.width_for_curves(P))):
        return known
    work = (np.empty((6, 7)), np.empty((16, 9)))
    best = try_from(P, goal.seed, target, goal, try_rank_five(P, target, goal, known, work), work)
    widths = surface.same_widths(P, target.place, surface.in_line_width(P))
    if not surface.may_have_surface(P, target.place, widths):
        return best
    boxes = np.empty((1, SIZE))
    wide = row(boxes, 0)
    parts = np.empty((surface.MOST_PARTS, surface.PART))
    n = surface.find_parts(P, wide, target.place, widths, parts)
    for k in range(n):
        part = row(parts, k)
        for i in range(TRIES[surface.ways_of(part) - 1]):
            best = try_from(P, surface.posture_on((P, wide), target.place, part, i, goal), target, goal, best, work)
    keep(boxes)
    keep(parts)
    if best[2] < known[2]:
        q, value = descend(P, best[0], target, goal, THOROUGH, work)
        best = (q, branch_of(P, q), value)
    return best
