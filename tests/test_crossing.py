"""Where a figure passes zero, against roots that are known."""

import math

import pytest
from numba import njit

from srs_ik.kernels.algebra.roots import UNKNOWN, has_settled, next_parameter, start_crossing, tell_figure


def cubic(x):
    return x**3 - 0.1


def kinked(x):
    return x - 0.3 if x < 0.5 else 0.2 + 40.0 * (x - 0.5)


def steep(x):
    return math.expm1(30.0 * (x - 0.9))


def falling(x):
    return math.cos(x) - 0.7


def unknown_above(x):
    return x - 0.2 if x < 0.6 else 10.0 * UNKNOWN


ROOTS = [
    (cubic, 0.0, 1.0, 0.1 ** (1.0 / 3.0)),
    (kinked, 0.0, 1.0, 0.3),
    (steep, 0.0, 1.0, 0.9),
    (falling, 1.5, 0.0, math.acos(0.7)),
    (unknown_above, 0.0, 1.0, 0.2),
]


@pytest.mark.parametrize(("function", "x", "y", "root"), ROOTS)
def test_crossings_are_found_in_few_steps(function, x, y, root):
    compiled = njit(function)

    @njit
    def find(x, y):
        crossing = start_crossing(x, compiled(x), y, compiled(y))
        for steps in range(200):
            if has_settled(crossing):
                return crossing[0], steps
            m = next_parameter(crossing)
            crossing = tell_figure(crossing, m, compiled(m))
        return crossing[0], 200

    found, steps = find(x, y)
    assert function(found) <= 0.0
    assert found == pytest.approx(root, abs=2e-10)
    # Halving would take 43 steps.
    assert steps <= 20


def test_a_figure_of_zero_is_the_crossing():
    @njit
    def settled(x, fx, y, fy):
        return has_settled(start_crossing(x, fx, y, fy))

    assert settled(0.0, 0.0, 1.0, 1.0)
    assert settled(0.5, -1.0, 0.5 + 1e-14, 1.0)
    assert not settled(0.0, -1.0, 1.0, 1.0)
