"""Sets of arm angles against membership on a grid, and what is certified against functions whose zeros are known."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from srs_ik.solve.in_scene.spans import FINEST, SPACING, certify, common, merged, turned, width, without

ends = st.integers(-30, 30).map(lambda k: 0.1 * k)
sets = st.lists(st.tuples(ends, ends).map(sorted).map(tuple).filter(lambda e: e[0] < e[1]), max_size=6)
GRID = 0.05 + 0.1 * np.arange(-31, 31)


def holds(spans, x):
    return any(a <= x <= b for a, b in spans)


@given(sets, sets)
def test_sets_are_joined_and_cut(first, second):
    for x in GRID:
        assert holds(merged(first), x) == holds(first, x)
        assert holds(without(first, second), x) == (holds(first, x) and not holds(second, x))
        assert holds(common(first, second), x) == (holds(first, x) and holds(second, x))
    assert width(merged(first)) == pytest.approx(0.1 * sum(holds(first, x) for x in GRID))


@given(sets)
def test_angles_are_turned_into_an_interval(spans):
    for x in np.linspace(1.03, 6.03, 40):
        inside = any(holds(spans, x + k * 2.0 * math.pi) for k in range(-3, 4))
        assert holds(turned(spans, 1.0, 6.1), x) == inside


@pytest.mark.parametrize("knows_depth", [True, False])
def test_what_is_free_is_certified_and_little_is_left_out(knows_depth):
    rng = np.random.default_rng(5)
    for _ in range(40):
        shift, level, turns = rng.uniform(0, 6), rng.uniform(-0.9, 0.9), rng.integers(1, 4)

        def distance(x, shift=shift, level=level, turns=turns):
            return math.sin(turns * x + shift) - level

        looks = 0

        def look(x, half, distance=distance, turns=turns):
            nonlocal looks
            looks += 1
            reach = distance(x) / turns
            return reach if reach > 0.0 or knows_depth else 0.0

        free, unsure = certify(look, -2.0, 2.0)
        x = np.linspace(-2.0, 2.0, 4001)
        truly = np.array([distance(each) > 0.0 for each in x])
        called = np.array([holds(free, each) for each in x])
        assert not (called & ~truly).any()
        ends = int(np.abs(np.diff(truly)).sum())
        assert (truly & ~called).sum() * 1e-3 <= ends * ((FINEST if knows_depth else SPACING) + 2e-3)
        assert width(unsure) <= (ends + 1) * 3 * FINEST
        assert looks < 80 if knows_depth else looks < 400


def test_a_point_is_looked_at():
    assert certify(lambda psi, half: 0.1, 1.0, 1.0) == ([(1.0, 1.0)], [])
    assert certify(lambda psi, half: -0.1, 1.0, 1.0) == ([], [])
    assert without([(1.0, 1.0)], [(0.0, 2.0)]) == []
    assert without([(1.0, 1.0)], [(2.0, 3.0)]) == [(1.0, 1.0)]
