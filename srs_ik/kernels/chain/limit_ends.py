"""Ends of feasible intervals on the true chain: from postures inside the limits to the first limit that is met.

Newton's method for eight postures of a near limb in step, with the arm angle as one more unknown. Each step closes the
pose to first order and goes with the arm angle, one way or the other, until the first joint is on a limit.
"""

from srs_ik.kernels.algebra.joint_vectors import along7
from srs_ik.kernels.algebra.lane_trig import turn, turned_by, turns_of
from srs_ik.kernels.algebra.lanes import ALL, as_bits, larger, root, smaller, where
from srs_ik.kernels.chain import newton_eight
from srs_ik.kernels.chain.eight import sines_of_eight
from srs_ik.kernels.chain.newton import LAST_STEP, MAX_STEP
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import LOWER, UPPER

FARTHEST = 1.0
"""Of an arm angle at which no limit is met within reach, the next one is this far, rad."""

HARDLY = 1e-11
"""A step foreseen to be this short, rad, is not taken: it would be shorter still, by the square of the last one."""

CLOSE_BY = 1e-5
"""A first step this short, rad, times the root of the least sine of the middle angles, is the last: what it leaves is
its square over that sine, 1e-10 rad. The postures that almost exact limbs start from are that close."""


@kernel
def way_to_limit(P, joint, q, rate, way, least):
    """How much farther in arm angle, in the direction `way` (1.0, -1.0), a joint is on a limit, if before `least`."""
    ahead = way * rate
    there = (where(ahead > 0.0, P[UPPER + joint] + 0.0 * q, P[LOWER + joint] + 0.0 * q) - q) / ahead
    return where((there < least) & (abs(ahead) > 0.0), there, least)


@kernel
def way_to_limits(P, q, rates, way):
    """How much farther the first joint is on a limit."""
    least = FARTHEST + 0.0 * way
    least = way_to_limit(P, 0, q[0], rates[0], way, least)
    least = way_to_limit(P, 1, q[1], rates[1], way, least)
    least = way_to_limit(P, 2, q[2], rates[2], way, least)
    least = way_to_limit(P, 3, q[3], rates[3], way, least)
    least = way_to_limit(P, 4, q[4], rates[4], way, least)
    least = way_to_limit(P, 5, q[5], rates[5], way, least)
    return way_to_limit(P, 6, q[6], rates[6], way, least)


@kernel
def to_limits(P, q, psi, way, target, steps):
    """Newton's method from eight postures inside the limits, at arm angles, to the first limits on their way.

    `way` is the direction of the arm angle in which to go, 1.0 or -1.0. Returns the postures, their arm angles, and as
    bits which of them meet the pose on a limit.
    """
    R, p, place_ = target
    t, h0 = place_[0], place_[1]
    turns = turns_of(q)
    around = turn(psi)
    met = 0
    last = 0.0 * psi
    s2, s4, s6 = sines_of_eight(P, q)
    short = CLOSE_BY * root(smaller(smaller(abs(s2), abs(s4)), abs(s6)))
    for _ in range(steps):
        h, b = newton_eight.half_planes(t, h0, around)
        d, rates, _, right = newton_eight.newton_step(P, turns, R, p, h, b)
        ahead = way * way_to_limits(P, along7(q, 1.0, d), rates, way)
        d = along7(d, ahead, rates)
        size = larger(newton_eight.largest(d), abs(ahead))
        settled = (size < short) | newton_eight.is_foreseen(size, last, HARDLY)
        f = MAX_STEP / larger(size, MAX_STEP + 0.0 * size)
        d = newton_eight.all_times(f, d)
        q = along7(q, 1.0, d)
        psi = psi + f * ahead
        last = size
        short = LAST_STEP + 0.0 * size
        met = as_bits(settled & right)
        if as_bits(settled) == ALL:
            break
        turns = newton_eight.turned_by_all(turns, d)
        around = turned_by(around, f * ahead)
    return q, psi, met
