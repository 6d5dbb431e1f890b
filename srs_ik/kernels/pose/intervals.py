"""Feasible arm angles of one pose, either kind of limb."""

from __future__ import annotations

import numpy as np

from srs_ik.kernels.algebra.pointers import keep, row
from srs_ik.kernels.exact.flat import ease, intervals_of_bends, is_almost_flat
from srs_ik.kernels.exact.intervals import find_intervals
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import SOLVED
from srs_ik.kernels.layout.limb import FREE, LIMITED, LOOSE, SIZE
from srs_ik.kernels.near.intervals import true_intervals
from srs_ik.kernels.near.predicted import predicted_intervals


@kernel
def all_intervals(family, target, respect, J, A, out):
    """Feasible intervals of one pose on the true chain; none where the pose is out of reach."""
    if J is not None:
        n = predicted_intervals(row(family, LIMITED if respect else FREE), target, out, J, A)
        return n if n >= 0 else true_intervals(row(family, LIMITED), target, respect, out, J, A)
    place_ = target.place
    if abs(place_[5]) >= SOLVED:
        return 0
    n = find_intervals(row(family, LIMITED if respect else FREE), place_, -1, out)
    if is_almost_flat(place_):
        return intervals_of_bends(family, place_, respect, out, n)
    if n == 0 and respect:
        # A pose whose postures all lie on limits leaves room by rounding alone.
        boxes = np.empty((1, SIZE))
        eased = row(boxes, 0)
        ease(row(family, LOOSE), eased)
        n = find_intervals(eased, place_, -1, out)
        keep(boxes)
    return n
