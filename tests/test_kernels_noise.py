"""Samples of noise in their order, against NumPy."""

import numpy as np
from numba import njit

from srs_ik.kernels.algebra.pointers import keep, row
from srs_ik.kernels.layout.track import WINDOWED
from srs_ik.kernels.track.noise import put_in_order


@njit
def replaced(figures, old, new):
    """One of a row of sorted figures replaced."""
    put_in_order(row(figures, 0), old, new)
    keep(figures)


def test_a_window_stays_in_order():
    rng = np.random.default_rng(6)
    window = np.zeros(WINDOWED)
    ordered = np.zeros((1, WINDOWED))
    for k in range(300):
        new = float(rng.integers(-5, 5)) if k % 2 else rng.normal()
        replaced(ordered, window[k % WINDOWED], new)
        window[k % WINDOWED] = new
        np.testing.assert_array_equal(ordered[0], np.sort(window))
