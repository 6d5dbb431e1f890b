"""What kernels do with eight floats, in Python: an array of NumPy. `lane_types` teaches Numba the same."""

from __future__ import annotations

from typing import Any

import numpy as np

LANES = 8


def where(condition: Any, a: Any, b: Any) -> Any:
    """The figures of a where a condition holds, else those of b."""
    return np.where(condition, a, b)


def root(x: Any) -> Any:
    """Square roots."""
    return np.sqrt(x)


def whole_number(x: Any) -> Any:
    """The nearest whole numbers, the even one half-way."""
    return np.rint(x)


def as_bits(condition: Any) -> Any:
    """Eight truth values as the bits of a number, the first the lowest."""
    return int(np.packbits(condition, bitorder="little")[0])


def as_mask(number: Any) -> Any:
    """The lowest eight bits of a number as truth values."""
    return np.unpackbits(np.array([number & 255], np.uint8), bitorder="little").astype(bool)


def eight_of(a: Any, b: Any, c: Any, d: Any, e: Any, f: Any, g: Any, h: Any) -> Any:
    """Eight floats."""
    return np.array([a, b, c, d, e, f, g, h])


def one_of(x: Any, i: Any) -> Any:
    """One of eight floats."""
    return x[i]


def gather(figures: Any, first: Any, stride: Any) -> Any:
    """Eight figures of an array, from `first` on in steps of `stride`."""
    return figures[first : first + LANES * stride : stride].copy()


def scatter(figures: Any, first: Any, stride: Any, x: Any) -> Any:
    """Write eight floats where `gather` reads them."""
    figures[first : first + LANES * stride : stride] = x
