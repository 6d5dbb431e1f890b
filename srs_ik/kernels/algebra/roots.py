"""Where a figure passes zero between two parameters: the secant that does not let one side stand still.

Dowell and Jarratt 1971, "A modified regula falsi method" (the Illinois method). A crossing is a tuple: a parameter at
which the figure is zero or less, the figure, its weight in the secant; one at which it is more, its weight; and which
of them moved last, -1 or 1.
"""

from srs_ik.kernels.jit import kernel

SETTLED = 1e-13
"""A figure this close to zero has crossed it, and so have parameters that are so close together."""

LEAST_SHARE = 1e-3
"""Of the way between two parameters, the next one goes at least this part."""

UNKNOWN = 1e9
"""No figure from here on says how far away zero is."""


@kernel
def start_crossing(x, fx, y, fy):
    """A crossing between x, where the figure is zero or less, and y."""
    return x, fx, fx, y, fy, 0


@kernel
def has_settled(crossing):
    """Whether the first parameter is the crossing up to rounding."""
    x, fx, _, y, _, _ = crossing
    return fx > -SETTLED or abs(y - x) < SETTLED * max(1.0, abs(x))


@kernel
def next_parameter(crossing):
    """The parameter to look at next."""
    x, _, wx, y, wy, _ = crossing
    share = wx / (wx - wy) if wy < UNKNOWN else 0.5
    return x + (y - x) * min(max(share, LEAST_SHARE), 1.0 - LEAST_SHARE)


@kernel
def tell_figure(crossing, m, f):
    """The crossing after the figure at a parameter between is known."""
    x, fx, wx, y, wy, last = crossing
    if f <= 0.0:
        return m, f, f, y, (0.5 * wy if last == -1 else wy), -1
    return x, fx, (0.5 * wx if last == 1 else wx), m, f, 1
