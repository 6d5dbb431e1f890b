"""Sets of arm angles as sorted lists of (lower, upper), rad: joined, cut, and turned; and how a part is certified."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

Span = tuple[float, float]

FINEST = 5e-4
"""Between what is free and what is not, so much is left undecided, rad."""

SPACING = 0.02
"""Between postures that hit something, and do not tell how deep, free ones are not looked for within this, rad."""

MOST_LOOKS = 400
"""So many arm angles of one part are looked at; what is left is undecided."""

TURN = 2.0 * math.pi


def merged(spans: Iterable[Span]) -> list[Span]:
    """The same set, sorted, of parts that do not touch."""
    out: list[Span] = []
    for a, b in sorted(spans):
        if out and a <= out[-1][1]:
            out[-1] = out[-1][0], max(out[-1][1], b)
        else:
            out.append((a, b))
    return out


def without(spans: Iterable[Span], taken: Iterable[Span]) -> list[Span]:
    """What a set leaves of another one; its single points stay where they are not inside of it."""
    taken = merged(taken)
    out = []
    for a, b in merged(spans):
        at = a
        for lower, upper in taken:
            if upper <= at or lower >= b:
                # A single point is taken with what it lies in.
                if a == b and lower <= a <= upper:
                    at = math.inf
                continue
            if lower > at:
                out.append((at, lower))
            at = max(at, upper)
        if at < b or (at == a == b):
            out.append((at, b))
    return out


def common(first: Iterable[Span], second: Iterable[Span]) -> list[Span]:
    """What two sets share."""
    second = merged(second)
    return [(max(a, c), min(b, d)) for a, b in merged(first) for c, d in second if max(a, c) <= min(b, d)]


def turned(spans: Iterable[Span], lower: float, upper: float) -> list[Span]:
    """A set of angles in the turns in which it overlaps an interval, cut to it."""
    shifted = [(a + k * TURN, b + k * TURN) for a, b in spans for k in (-2, -1, 0, 1, 2)]
    return merged((max(a, lower), min(b, upper)) for a, b in shifted if b >= lower and a <= upper)


def width(spans: Iterable[Span]) -> float:
    """Its width, rad."""
    return sum(b - a for a, b in spans)


def certify(look: Callable[[float, float], float], lower: float, upper: float) -> tuple[list[Span], list[Span]]:
    """The free parts of a part, from its lower to its upper end, rad, and those left undecided.

    `look` tells of an arm angle and half the width that is asked about how far around it all angles are free, rad;
    minus how far around it none is; zero where it is not free, and nothing is known of those around.
    """
    free: list[Span] = []
    unsure: list[Span] = []
    waiting = [(lower, upper, False, False)]
    looks = 0
    while waiting:
        a, b, hit_before, hit_behind = waiting.pop()
        if (looks and b - a < FINEST) or looks >= MOST_LOOKS:
            unsure.append((a, b))
            continue
        if hit_before and hit_behind and b - a < SPACING:
            continue
        middle, looks = 0.5 * (a + b), looks + 1
        reach = look(middle, 0.5 * (b - a))
        if reach > 0.0:
            free.append((max(a, middle - reach), min(b, middle + reach)))
        hit, reach = reach <= 0.0, abs(reach)
        if a < middle - reach:
            waiting.append((a, middle - reach, hit_before, hit))
        if middle + reach < b:
            waiting.append((middle + reach, b, hit, hit_behind))
    return merged(free), unsure
