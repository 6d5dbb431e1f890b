"""Eight floats at once: as NumPy has it, their cosines and sines as `math` has them, and what is between them."""

import operator

import numpy as np
import pytest
from numba import njit

from srs_ik.kernels.algebra.lane_trig import seven_turns, small_turn, turn, turned_by
from srs_ik.kernels.algebra.lanes import (
    LANES,
    as_bits,
    as_mask,
    eight_of,
    gather,
    one_of,
    root,
    scatter,
    where,
    whole_number,
)
from srs_ik.kernels.algebra.pointers import keep, row
from srs_ik.kernels.algebra.waves import waves_of, zeros_of

SPECIAL = np.array([0.0, -0.0, 1.0, -2.5, 1e-300, 1e300, np.inf, np.nan])
COMMON = np.array([0.5, -1.5, 2.5, 3.0, -4.0, 7.25, 1e-3, 0.0])


def applied(operation, *arrays):
    """What compiled code makes of eight floats each: floats, or truths as bits."""

    @njit
    def binary(a, b, out):
        scatter(row(out, 0), 0, 1, operation(gather(row(a, 0), 0, 1), gather(row(b, 0), 0, 1)))
        keep(a), keep(b), keep(out)

    @njit
    def unary(a, out):
        scatter(row(out, 0), 0, 1, operation(gather(row(a, 0), 0, 1)))
        keep(a), keep(out)

    out = np.empty(LANES)
    (binary if len(arrays) == 2 else unary)(*arrays, out)
    return out


@pytest.mark.parametrize("operation", [operator.add, operator.sub, operator.mul, operator.truediv])
def test_arithmetic(operation):
    for a, b in ((SPECIAL, COMMON), (COMMON, SPECIAL), (COMMON, COMMON[::-1].copy())):
        with np.errstate(all="ignore"):
            expected = operation(a, b)
        np.testing.assert_array_equal(applied(operation, a, b), expected)


@pytest.mark.parametrize("operation", [operator.neg, abs, root, whole_number])
def test_functions(operation):
    for a in (SPECIAL, COMMON):
        with np.errstate(all="ignore"):
            expected = operation(a)
        result = applied(operation, a)
        np.testing.assert_array_equal(result, expected)
        np.testing.assert_array_equal(np.signbit(result)[:-1], np.signbit(expected)[:-1])


def test_comparisons_and_choices():
    @njit
    def compare(a, b, out):
        x, y = gather(row(a, 0), 0, 1), gather(row(b, 0), 0, 1)
        scatter(row(out, 0), 0, 1, where(x < y, x, y))
        bits = as_bits(x < y), as_bits(x > y), as_bits((x < y) & (y > 1.0)), as_bits((x < y) | (x > y))
        keep(a), keep(b), keep(out)
        return bits

    for a, b in ((SPECIAL, COMMON), (COMMON, SPECIAL), (COMMON, COMMON)):
        out = np.empty(LANES)
        less, more, both, either = compare(a, b, out)
        np.testing.assert_array_equal(out, np.where(a < b, a, b))
        assert (less, more) == (as_bits(a < b), as_bits(a > b))
        assert (both, either) == (as_bits((a < b) & (b > 1.0)), as_bits((a < b) | (a > b)))


def test_numbers_stand_for_eight_equal_ones():
    @njit
    def mixed(a, out):
        x = gather(row(a, 0), 0, 1)
        scatter(row(out, 0), 0, 1, 1.0 - 2 * x / 3.0)
        keep(a), keep(out)

    out = np.empty(LANES)
    mixed(COMMON, out)
    np.testing.assert_array_equal(out, 1.0 - 2 * COMMON / 3.0)


def test_bits_and_masks_are_inverse():
    @njit
    def there_and_back(number):
        return as_bits(as_mask(number))

    for number in range(256):
        assert there_and_back(number) == as_bits(as_mask(number)) == number


def test_columns_are_read_and_written():
    @njit
    def move(source, target):
        scatter(row(target, 1), 2, 3, gather(row(source, 1), 1, 5))
        keep(source), keep(target)

    source = np.arange(50.0).reshape(10, 5)
    target = np.zeros((10, 3))
    move(source, target)
    expected = np.zeros((10, 3))
    expected[1:9, 2] = source[1:9, 1]
    np.testing.assert_array_equal(target, expected)


def test_floats_are_put_together_and_taken_apart():
    @njit
    def reverse(a, out):
        x = eight_of(a[7], a[6], a[5], a[4], a[3], a[2], a[1], a[0])
        for i in range(LANES):
            out[i] = one_of(x, i)

    out = np.empty(LANES)
    reverse(COMMON, out)
    np.testing.assert_array_equal(out, COMMON[::-1])


def cosines_and_sines(function, angles):
    @njit
    def each(angles, out):
        for i in range(0, len(angles), LANES):
            c, s = function(gather(row(angles, i), 0, 1))
            scatter(row(out, i), 0, 2, c)
            scatter(row(out, i), 1, 2, s)
        keep(angles), keep(out)

    out = np.empty((len(angles), 2))
    each(angles, out)
    return out.T


@pytest.mark.parametrize(("function", "widest"), [(turn, 0.8), (turn, 4.0), (turn, 100.0), (small_turn, 0.8)])
def test_cosines_and_sines(function, widest):
    rng = np.random.default_rng(0)
    quarters = np.arange(-8, 8) * np.pi / 2
    angles = np.concatenate((rng.uniform(-widest, widest, 4000), quarters[np.abs(quarters) <= widest]))
    angles = np.resize(angles, len(angles) // LANES * LANES)
    c, s = cosines_and_sines(function, angles)
    assert np.abs(c - np.cos(angles)).max() < 2.5e-16
    assert np.abs(s - np.sin(angles)).max() < 2.5e-16
    # Small angles keep all their digits.
    small = np.logspace(-300, -3, 64)
    np.testing.assert_allclose(cosines_and_sines(function, small)[1], np.sin(small), rtol=4e-16)


def test_turns_of_seven_joints_and_turns_on_top():
    @njit
    def seven(q, out):
        turns = seven_turns((q[0], q[1], q[2], q[3], q[4], q[5], q[6]))
        for i in range(7):
            out[i, 0], out[i, 1] = turns[i]

    @njit
    def on_top(q, x, out):
        c, s = turned_by(turn(gather(row(q, 0), 0, 1)), gather(row(x, 0), 0, 1))
        scatter(row(out, 0), 0, 2, c)
        scatter(row(out, 0), 1, 2, s)
        keep(q), keep(x), keep(out)

    rng = np.random.default_rng(1)
    q, x, out = rng.uniform(-6.0, 6.0, LANES), rng.uniform(-0.5, 0.5, LANES), np.empty((LANES, 2))
    seven(q, out)
    np.testing.assert_allclose(out[:7], np.column_stack((np.cos(q), np.sin(q)))[:7], atol=3e-16)
    on_top(q, x, out)
    np.testing.assert_allclose(out, np.column_stack((np.cos(q + x), np.sin(q + x))), atol=1e-15)


ON_PIECE = 0.02
"""Part of their size by which waves change between two turns on one piece."""


@njit
def zeros_between(figures):
    found = zeros_of(waves_of(gather(row(figures, 0), 0, 1)))
    keep(figures)
    return found


def test_zeros_of_waves_are_counted():
    rng = np.random.default_rng(1)
    around = np.arange(8) * np.pi / 4.0
    dense = np.linspace(0.0, 2.0 * np.pi, 20001)
    counts = set()
    for _ in range(300):
        parts = rng.normal(size=7) * [1.0, 1.0, 1.0, 0.3, 0.3, 0.1, 0.1]

        def waves(x, parts=parts):
            return parts[0] + sum(parts[2 * n - 1] * np.cos(n * x) + parts[2 * n] * np.sin(n * x) for n in range(1, 4))

        values = waves(dense)
        count, nearest = zeros_between(waves(around))
        turning = np.abs(values[1:-1][np.diff(values)[1:] * np.diff(values)[:-1] <= 0.0])
        # Two turns next to each other, on one piece, come as close to zero as an end of it, but for this much.
        assert 0.0 <= nearest <= turning.min() + ON_PIECE
        if nearest > ON_PIECE:
            assert count == np.count_nonzero(np.diff(np.sign(values)))
            counts.add(count)
    assert counts >= {0, 2, 4}
