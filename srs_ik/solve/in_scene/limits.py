"""Joint limits cut by the ranges of joints that keep bodies apart which they watch."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from srs_ik.collision.links.ranges import JointRange
from srs_ik.solve.packed import pack_family
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.collision.owner import BodyOwner
    from srs_ik.solve.packed import PackedArm

_MOST_MARGINS = 256
"""For so many margins at most, limits are kept: a clearance asks for some of up to 150 steps that a range tells of."""


class TightLimits:
    """Joint limits in which no two bodies meet that the range of a joint watches.

    Attributes:
        lower: (7,) rad.
        upper: (7,) rad.
        family: the limb packed with them.
    """

    def __init__(self, arm: BodyOwner, lower: Array, upper: Array) -> None:
        self.lower, self.upper = lower, np.maximum(lower, upper)
        self.family = pack_family(arm.limb, self.lower, self.upper)


Limits = tuple[tuple[TightLimits | None, TightLimits | None], JointRange | None]
"""Without and with the limits of the arm, None where they need no cut; and the pair that no range keeps apart."""

Cut = Callable[..., tuple[Array, Array, JointRange | None]]
"""How ranges of joints cut limits: `ranges.tightened` or `ranges.loosened`."""


def cut_limits(arm: BodyOwner, packed: PackedArm, ranges: list[JointRange], cut: Cut, margin: float) -> Limits:
    """Limits cut by ranges of joints, see `Limits`; kept for the next question."""
    if not ranges:
        return (None, None), None
    known: dict[Any, Limits] = arm.__dict__.setdefault("_limits_in_scene", {})
    key = cut, margin, tuple((each.first, each.second) for each in ranges)
    if key not in known:
        if len(known) >= _MOST_MARGINS:
            known.clear()
        limits: list[TightLimits | None] = []
        jammed = None
        given: Sequence[tuple[Array, Array]] = ((np.full(7, -np.inf), np.full(7, np.inf)), (packed.lower, packed.upper))
        for lower, upper in given:
            low, high, jammed = cut(ranges, lower, upper, margin)
            same = np.array_equal(low, lower) and np.array_equal(high, upper) and jammed is None
            limits.append(None if same else TightLimits(arm, low, high))
        known[key] = (limits[0], limits[1]), jammed
    return known[key]
