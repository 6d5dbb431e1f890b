"""Numbers that know no arm, against NumPy and SciPy: linear systems, minima, seven angles as a vector."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit
from scipy.optimize import minimize_scalar

from srs_ik.kernels.algebra.joint_vectors import along7, difference, dot7, short_way
from srs_ik.kernels.algebra.linear import solve_definite, solve_downhill, solve_linear
from srs_ik.kernels.algebra.minimum import propose, start_search, tell
from srs_ik.kernels.algebra.pointers import copy, row, scratch
from srs_ik.kernels.layout.search import BEST, F_BEST, SHARP, SMOOTH, STATE

ANGLE = st.floats(-20.0, 20.0)
SEVEN = st.tuples(*[ANGLE] * 7)


@njit
def solved(A, n):
    return solve_linear(A, n)


@njit
def solve_as_definite(A, least):
    solve_definite(A, least)


@njit
def downhill(A):
    return solve_downhill(A)


@njit
def vectors(a, s, b):
    return dot7(a, b), along7(a, s, b), difference(a, b)


@njit
def short(angle):
    return short_way(angle)


@njit
def product_on_stack(a, b):
    """a b of two (3, 3) matrices, by copies on the stack."""
    A, B = scratch(3, 3), scratch(3, 3)
    second = row(B, 0)
    for i in range(3):
        for j in range(3):
            A[i, j], second[3 * i + j] = a[i, j], b[i, j]
    return A @ B, A.shape, A.strides


@njit
def moved_down(a, i, count):
    copy(row(a, i), a[i + 1], count)
    return a


def test_so_many_figures_of_a_row_are_copied_and_others_stay():
    a = np.arange(15.0).reshape(3, 5)
    expected = a.copy()
    expected[2, :3] = a[1, :3]
    np.testing.assert_array_equal(moved_down(a.copy(), 1, 3), expected)
    np.testing.assert_array_equal(moved_down(a.copy(), 1, 0), a)


def test_arrays_on_the_stack_are_arrays_and_lie_apart():
    a, b = np.random.default_rng(0).normal(size=(2, 3, 3))
    product, shape, strides = product_on_stack(a, b)
    np.testing.assert_allclose(product, a @ b, rtol=1e-14)
    assert (shape, strides) == ((3, 3), (24, 8))


@settings(deadline=None)  # the first example compiles
@given(st.integers(1, 7), st.integers(0, 2**32 - 1))
def test_linear_systems_are_solved_as_numpy_solves_them(n, seed):
    rng = np.random.default_rng(seed)
    M, b = rng.normal(size=(n, n)), rng.normal(size=n)
    A = np.zeros((n, 9))
    A[:, :n], A[:, n] = M, b
    sign = solved(A, n)
    expected = np.linalg.solve(M, b)
    # Elimination with row pivots loses some digits where a matrix is nearly singular.
    allowed = 1e-13 * np.linalg.cond(M) * max(1.0, np.abs(expected).max())
    np.testing.assert_allclose(A[:, n], expected, rtol=0, atol=allowed)
    assert sign == np.sign(np.linalg.det(M))


@pytest.mark.parametrize("n", range(1, 8))
def test_a_singular_system_is_told(n):
    A = np.zeros((n, 9))
    A[:, : n - 1] = np.eye(n)[:, : n - 1]
    A[:, n] = 1.0
    assert solved(A, n) == 0.0


@settings(deadline=None)  # the first example compiles
@given(st.integers(0, 7), st.integers(0, 2**32 - 1))
def test_steps_lead_downhill_be_the_function_curved_as_it_may(negative, seed):
    rng = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(rng.normal(size=(7, 7)))
    curves = rng.uniform(0.1, 10.0, 7) * np.where(np.arange(7) < negative, -1.0, 1.0)
    H, slope = turn @ np.diag(curves) @ turn.T, rng.normal(size=7)
    A = np.full((7, 9), np.nan)
    A[np.triu_indices(7)], A[:, 7] = H[np.triu_indices(7)], -slope
    assert downhill(A) == (negative == 0)
    assert A[:, 7] @ slope < 0.0
    if negative == 0:
        np.testing.assert_allclose(A[:, 7], np.linalg.solve(H, -slope), rtol=1e-10, atol=1e-10)
    if negative == 7:
        np.testing.assert_allclose(A[:, 7], np.linalg.solve(H, slope), rtol=1e-10, atol=1e-10)


@settings(deadline=None)  # the first example compiles
@given(st.integers(0, 2**32 - 1), st.integers(0, 6), st.sampled_from([0.0, 1e-12, 1e-8, 1e-4]))
def test_definite_systems_are_solved_however_many_directions_are_as_good_as_lost(seed, lost, left):
    rng, least = np.random.default_rng(seed), 1e-16
    J = rng.normal(size=(6, 7))
    J[6 - lost :] = left * J[6 - lost :] + J[6 - lost - 1] if lost < 6 else left * J
    M, b = J @ J.T + least * np.eye(6), J @ rng.normal(size=7)
    A = np.zeros((6, 9))
    A[:, :6], A[:, 6] = M, b
    solve_as_definite(A, least)
    x = A[:, 6]
    assert np.isfinite(x).all()
    # What elimination leaves of the equations is rounding of the numbers in them.
    assert np.abs(M @ x - b).max() <= 1e-13 * (np.abs(M) @ np.abs(x) + np.abs(b)).max()


@settings(deadline=None)  # the first example compiles
@given(SEVEN, ANGLE, SEVEN)
def test_seven_angles_as_a_vector(a, s, b):
    product, moved, steps = vectors(a, s, b)
    assert product == pytest.approx(np.dot(a, b), rel=1e-13, abs=1e-11)
    np.testing.assert_allclose(moved, np.add(a, np.multiply(s, b)), rtol=1e-15, atol=1e-12)
    turned = np.subtract(b, a)
    # The same direction on the circle, and no longer way round than half a turn.
    np.testing.assert_allclose(np.exp(1j * np.array(steps)), np.exp(1j * turned), rtol=0, atol=1e-13)
    assert np.abs(steps).max() <= math.pi + 1e-12


@settings(deadline=None)  # the first example compiles
@given(st.floats(-1e6, 1e6))
def test_the_short_way_is_an_angle_a_whole_number_of_turns_away(angle):
    turns = (angle - short(angle)) / (2.0 * math.pi)
    assert turns == pytest.approx(round(turns), abs=1e-9)
    assert abs(short(angle)) <= math.pi + 1e-9


def quartic(x):
    return (x - 0.3) ** 4 + 0.1 * x


def valley(x):
    return math.cos(3.0 * x) + 0.2 * x * x


def corner(x):
    return abs(x - 0.7) + 0.1 * x


@pytest.mark.parametrize(("function", "bracket"), [(quartic, (-1, 0, 2)), (valley, (0.2, 1, 2)), (corner, (0, 0.5, 2))])
def test_minima_are_those_of_scipy(function, bracket):
    compiled = njit(function)

    @njit
    def search(a, x, b, resolution):
        S = np.empty(STATE)
        start_search(S, a, x, b, compiled(a), compiled(x), compiled(b), resolution)
        for asked in range(200):
            point, wanted = propose(S)
            if not wanted:
                return S[BEST], S[F_BEST], asked
            tell(S, compiled(point))
        return S[BEST], S[F_BEST], 200

    a, x, b = map(float, bracket)
    assert function(x) < min(function(a), function(b))
    at, lowest, asked = search(a, x, b, SHARP if function is corner else SMOOTH)
    expected = minimize_scalar(function, bracket=(a, x, b), method="brent", options={"xtol": 1e-10})
    # A smooth minimum is flat to the square root of rounding, about 1e-8 of its height.
    assert at == pytest.approx(expected.x, abs=2e-4 if function is quartic else 1e-7)
    assert lowest <= expected.fun + 1e-10
    assert asked <= 80
