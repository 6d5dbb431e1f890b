"""`FreeAxis`: what of a pose's rotation is left free."""

from __future__ import annotations

import math
from functools import cached_property, lru_cache
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from srs_ik.errors import InvalidTask, quoted
from srs_ik.inputs.fixed import Fixed
from srs_ik.inputs.numbers import array_or_empty, real_number
from srs_ik.kernels.layout.freedom import FREE_AXIS, FREE_CONE, FREEDOM
from srs_ik.system.arrays import Array

ANY = "any"
"""Stands for a position alone."""

RINGS_APART, ROLLS = 1.05, 3
"""Directions of a cone at which searches for a posture start are this far apart, rad; turns about each of them."""

NARROW, NARROW_APART, NARROW_ROLLS = 0.5, 2.2, 6
"""In cones up to this, rad: how far apart directions are, by the cone, which makes three; turns about each of them."""

WRITTEN_PI = 1e-4
"""Cones larger than pi by less, rad, are those of a pi with few digits, such as 3.1416."""

WIDE = 0.5 * math.pi
WIDE_APART = 1.5
"""The same for cones this wide, rad."""

FINE_APART, FINE_ROLLS = 0.55, 6
FINE_WIDE_APART, FINE_WIDE_ROLLS = 0.9, 4
"""The same where turns are looked at and not searched from; in wide cones."""

MANY_APART, MANY_ROLLS = 0.7, 12
"""The same where few of those reach, or none has met a pose: how far apart directions are at most, by the cone."""


class FreeAxis(Fixed):
    """A rotation that is not wanted in full: the roll about an axis of the tip is free, and the axis may lean.

    ``FreeAxis([0, 0, 1])`` keeps the direction of the tip's z axis, as drills, torches and suction cups want it.
    ``FreeAxis([0, 0, 1], cone=0.3)`` lets it lean up to 0.3 rad from where the pose has it. ``FreeAxis(cone=math.pi)``
    keeps the position alone.

    Args:
        axis: (3,) direction in the tip frame, of any length but zero.
        cone: how far the axis may lean, rad, from 0 to pi.

    Raises:
        InvalidTask: no direction, or no angle of that range.
        AttributeError: one of them is set afterwards.
    """

    _fixed: ClassVar[frozenset[str]] = frozenset({"axis", "cone"})
    _instead: ClassVar[str] = "make another FreeAxis"

    def __init__(self, axis: ArrayLike = (0.0, 0.0, 1.0), cone: float = 0.0) -> None:
        direction = array_or_empty(axis)
        largest = float(np.abs(direction).max()) if direction.shape == (3,) else math.nan
        if not 0.0 < largest < math.inf:
            raise InvalidTask("free_axis must be a direction in the tip frame, 3 finite numbers that are not all zero")
        # Squares of very large or small numbers are no floats. A power of two takes no digits off.
        scaled = np.ldexp(direction, -math.frexp(largest)[1])
        self.axis = scaled / np.linalg.norm(scaled)
        self.axis.flags.writeable = False
        angle = real_number(cone)
        self.cone = math.pi if math.pi < angle < math.pi + WRITTEN_PI else angle
        if not 0.0 <= self.cone <= math.pi:
            raise InvalidTask(f"the cone of a free axis must be an angle from 0 to pi rad, not {quoted(cone)}")

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self.axis.flags.writeable = False

    @cached_property
    def packed(self) -> Array:
        """(FREEDOM,) for kernels."""
        packed = np.zeros(FREEDOM)
        packed[FREE_AXIS : FREE_AXIS + 3] = self.axis
        packed[FREE_CONE] = self.cone
        return packed

    @cached_property
    def turns(self) -> Array:
        """(n, 9) rotations of the tip, all over what is free, a few first; none of the roll, of which kernels know.

        All of them are needed where few meet a pose: at the end of the reach, above all.
        """
        if self.cone == 0.0:
            return self._first_turns
        return np.concatenate([self._first_turns, self._spread(min(FINE_APART, MANY_APART * self.cone), MANY_ROLLS)])

    @property
    def few(self) -> int:
        """How many of its turns are looked at first, and the others where few of these reach."""
        return len(self._first_turns)

    @cached_property
    def _first_turns(self) -> Array:
        if self.cone == 0.0:
            return np.empty((0, 9))
        if self.cone <= NARROW:
            return self._spread(NARROW_APART * self.cone, NARROW_ROLLS, 0.5)[NARROW_ROLLS:]
        return self._spread(WIDE_APART if self.cone >= WIDE else RINGS_APART, ROLLS)[ROLLS:]

    def _spread(self, apart: float, rolls: int, shift: float = 0.0) -> Array:
        return _turns_of(tuple(self.axis.tolist()), self.cone, apart, rolls, shift)

    def sampled(self, most: int) -> Array:
        """(most, 3, 3) turns that are free, in the tip frame, evenly chosen; the first one is none."""
        if self.cone == 0.0:
            return np.array([self.rolled(2.0 * math.pi * k / most) for k in range(most)])
        fine = (FINE_WIDE_APART, FINE_WIDE_ROLLS) if self.cone >= WIDE else (FINE_APART, FINE_ROLLS)
        turns = self._spread(*fine).reshape(-1, 3, 3)
        return turns[np.linspace(0, len(turns) - 1, most).round().astype(int)]

    def rolled(self, angle: float) -> Array:
        """(3, 3) turn about the axis by an angle, rad, in the tip frame."""
        return _rotations(self.axis, np.array(angle))

    def lean(self, tip: Array, wanted: Array) -> float:
        """How far the axis of a tip (3, 3) is out of the cone about that of a wanted rotation (3, 3), rad."""
        is_axis, ought = tip @ self.axis, wanted @ self.axis
        angle = math.atan2(float(np.linalg.norm(np.cross(is_axis, ought))), float(is_axis @ ought))
        return max(angle - self.cone, 0.0)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, FreeAxis) and self.packed.tolist() == other.packed.tolist()

    def __hash__(self) -> int:
        return hash(tuple(self.packed.tolist()))

    def __repr__(self) -> str:
        return f"FreeAxis({self.axis.tolist()}, cone={self.cone:g})"


def as_free_axis(value: Any) -> FreeAxis:
    """What is free, of a direction in the tip frame, "any" or a `FreeAxis`; raises InvalidTask for anything else."""
    if isinstance(value, FreeAxis):
        return value
    if isinstance(value, str):
        if value == ANY:
            return _position_alone()
        raise InvalidTask(f'free_axis must be a direction in the tip frame, "{ANY}" or a FreeAxis, not {quoted(value)}')
    return FreeAxis(value)


@lru_cache(maxsize=1)
def _position_alone() -> FreeAxis:
    return FreeAxis(cone=math.pi)


@lru_cache(maxsize=16)
def _turns_of(axis: tuple[float, float, float], cone: float, apart: float, each: int, shift: float) -> Array:
    """(n, 9) turns into directions of a cone so far apart, and about each of them, read-only.

    Those about every other direction of a ring are shifted by a part of what is between two.
    """
    along = np.array(axis)
    across = np.linalg.svd(along[None])[2][1:]
    leans, azimuths, begins = [], [], []
    rings = max(math.ceil(cone / apart), 1)
    for ring in range(rings + 1):
        lean = cone * ring / rings
        count = max(math.ceil(2.0 * math.pi * math.sin(lean) / apart), 1)
        for k in range(count):
            leans.append(lean)
            azimuths.append(2.0 * math.pi * (k + 0.5 * (ring % 2)) / count)
            begins.append(shift * (k % 2))
    directions = np.stack([np.cos(azimuths), np.sin(azimuths)], axis=1) @ across
    rolls = 2.0 * math.pi * (np.arange(each) + np.array(begins)[:, None]) / each
    turns = (_rotations(directions, np.array(leans))[:, None] @ _rotations(along, rolls)).reshape(-1, 9)
    turns.flags.writeable = False
    return turns


def _rotations(axes: Array, angles: Array) -> Array:
    """(..., 3, 3) turns about unit axes (..., 3) by angles (...), rad."""
    x, y, z = np.moveaxis(axes, -1, 0)
    K = np.zeros((*axes.shape, 3))
    K[..., 0, 1], K[..., 0, 2], K[..., 1, 2] = -z, y, -x
    K[..., 1, 0], K[..., 2, 0], K[..., 2, 1] = z, -y, x
    c, s = np.cos(angles)[..., None, None], np.sin(angles)[..., None, None]
    turned: Array = np.eye(3) + s * K + (1.0 - c) * (K @ K)
    return turned
