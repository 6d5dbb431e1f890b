"""The posture nearest to a seed over all turns that a pose leaves free, all branches and all arm angles.

Local searches on the true chain start from a grid (`starts`), the best of it first; what lies next to a start that was
taken is left out.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.joint_vectors import between
from srs_ik.kernels.algebra.vectors import load3, norm
from srs_ik.kernels.chain.freedom import free_error
from srs_ik.kernels.exact.nearest import between_limbs
from srs_ik.kernels.freedom.queue import MOST_ATTEMPTS, NONE_LEFT, line_up, take_next
from srs_ik.kernels.freedom.settle import NO_POSTURE, THIN, distance, onto_pose, settle
from srs_ik.kernels.freedom.starts import is_of_no_use
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import SOLVED
from srs_ik.kernels.layout.freedom import MOST_TAKEN, Found, Freedom, Liking
from srs_ik.kernels.layout.limb import FAR, MISS, PHASE, SHOULDER, STRAIGHT, WRIST, WRIST_IN_TIP

CLOSE = 0.15
CLEAR = 2.0
"""A posture this close to a seed, rad, is the nearest one if no joint is singular within so many times its distance."""

SPREAD = math.sqrt(7.0)
"""Seven joints that turn by one together, each by the same, turn the tip by at most so much."""

ALMOST = 1e-3
"""A search that ends this close to its pose, m and rad, goes on, or is brought onto it."""

MANY = 0.4
"""Once this part of the searches has failed, starts next to one whose search fails are left out, too."""

NO_SHORTER, FEW = 1.0, 8
"""A search does not come so much nearer to the seed than its start is once it is inside the limits, rad: of more
searches than a few, those from such starts are left out."""


@kernel
def beside(P, pose, freedom, liking, desk):
    """The posture that a search from the seed leads to, if any; and whether it is so close that none is nearer."""
    off, turned = free_error(P, liking.posture, pose[0], pose[1], freedom)
    if max(off, turned) < SOLVED and between(liking.posture, liking.lower, liking.upper) == liking.posture:
        return Found(liking.posture, 0.0, True), True
    tip = norm(load3(P, WRIST_IN_TIP))
    if turned > SPREAD * CLOSE or off > SPREAD * CLOSE * (P[FAR] + tip + P[MISS]):
        return Found(liking.posture, NONE_LEFT, False), False
    rival = Liking(liking.posture, liking.weights, liking.lower, liking.upper, CLOSE * CLOSE, NO_POSTURE)
    there, cost, error, at_rest = settle(P, liking.posture, pose, freedom, rival, desk)
    met = at_rest and error < SOLVED
    if not met and freedom.cone <= THIN:
        there, cost, error, at_rest = settle(P, liking.posture, pose, Freedom(freedom.axis, 0.0), rival, desk)
        met = at_rest and error < SOLVED
        return Found(there, cost if met else NONE_LEFT, met), False
    q, distance = liking.posture, math.sqrt(cost)
    s2 = abs(math.sin(q[1] - P[SHOULDER + PHASE]))
    s4 = abs(math.sin(q[3] - P[STRAIGHT]))
    s6 = abs(math.sin(q[5] - P[WRIST + PHASE]))
    alone = distance < CLOSE and min(s2, s4, s6) > CLEAR * distance + between_limbs(P)
    return Found(there, cost if met else NONE_LEFT, met), met and alone


@kernel
def searched(P, start, pose, freedom, rival, desk):
    """`settle`, and once more where it ends close to its pose; from there at least onto that, or onto a roll in it."""
    there, cost, error, at_rest = settle(P, start, pose, freedom, rival, desk)
    if SOLVED <= error < ALMOST:
        there, cost, error, at_rest = settle(P, there, pose, freedom, rival, desk)
    if SOLVED <= error < ALMOST:
        if freedom.cone <= THIN:
            return settle(P, there, pose, Freedom(freedom.axis, 0.0), rival, desk)
        there, error = onto_pose(P, there, pose, freedom, rival, desk)
        cost = distance(there, rival)
    return there, cost, error, at_rest


@kernel
def nearest(P, pose, freedom, liking, sizes, found, desk):
    """The nearest posture that searches from so many starts in `desk` lead to, or the one that is known."""
    attempts, taken, failed = 0, 0, 0
    count, enough = sizes
    known = liking.rival_posture
    line_up(desk.starts, count)
    while attempts + failed < MOST_ATTEMPTS and taken < MOST_TAKEN and not (found.met and attempts + failed >= enough):
        start, least, count = take_next(desk.starts, count, taken)
        reached = math.sqrt(found.cost)
        if least >= NONE_LEFT or is_of_no_use(least, found, True):
            break
        start = between(start, liking.lower, liking.upper)
        if found.met and attempts >= FEW and math.sqrt(distance(start, liking)) > reached + NO_SHORTER:
            taken += 1
            continue
        rival = Liking(liking.posture, liking.weights, liking.lower, liking.upper, found.cost, known)
        there, cost, error, at_rest = searched(P, start, pose, freedom, rival, desk)
        if error < SOLVED and cost < found.cost:
            found, known = Found(there, cost, True), there
        if error < math.inf and not at_rest:
            # Limits stand in its way; not in that of a start beside it, unless many have failed.
            failed += 1
            taken += 1 if failed > MANY * enough else 0
        else:
            taken, attempts = taken + 1, attempts + 1
    return found
