"""Feasible arm angles of one pose, either kind of limb."""

from __future__ import annotations

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.exact.flat import intervals_of_bends, is_almost_flat
from srs_ik.kernels.exact.intervals import find_intervals
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import SOLVED
from srs_ik.kernels.layout.limb import FREE, IS_NEAR, LIMITED, LOOSE
from srs_ik.kernels.near.at_angle import may_reach
from srs_ik.kernels.near.intervals import intervals_through, true_intervals
from srs_ik.kernels.near.predicted import predicted_intervals
from srs_ik.kernels.near.second_attempts import found_again


@kernel
def exact_intervals(family, target, respect, out):
    """Feasible intervals of one pose in closed form; none where the pose is out of reach."""
    place_ = target.place
    if abs(place_[5]) >= SOLVED:
        return 0
    n = find_intervals(row(family, LIMITED if respect else FREE), place_, -1, out)
    if is_almost_flat(place_):
        return intervals_of_bends(family, place_, respect, out, n)
    if n == 0 and respect:
        # A pose whose postures all lie on limits leaves room by rounding alone.
        n = find_intervals(row(family, LOOSE), place_, -1, out)
    return n


@kernel
def all_intervals(family, target, respect, J, A, out):
    """Feasible intervals of one pose on the true chain; none where the pose is out of reach."""
    P = row(family, LIMITED)
    if P[IS_NEAR] == 0.0:
        return exact_intervals(family, target, respect, out)
    n = predicted_intervals(row(family, LIMITED if respect else FREE), target, out, J, A)
    if n < 0:
        n = true_intervals(P, target, respect, out, J, A)
        if n == 0 and may_reach(P, target.place):
            q, again = found_again(P, target, respect, J, A)
            n = intervals_through(P, target, q, respect, out, J, A) if again else 0
    return n
