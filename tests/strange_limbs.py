"""Random limbs as nobody builds them: with any axes, and joints that hardly turn, or several times."""

from __future__ import annotations

from oracles import RandomLimb, random_limb

PATTERNS = ("coordinate", "tilted", "oblique")

RANGES = ("mixed", "narrow", "pinched", "locked", "beyond", "turns", "wide")
"""Kinds of joint ranges: of any kind; one to three narrow ones (0.05 to 0.5 rad) among usual ones; one or two of 1e-3
or 1e-6 rad; one or two of no width; on one side of zero; of more than a turn; of almost one."""


def strange_limb(seed: int, kind: str, miss: float) -> RandomLimb:
    """The random limb of a seed, whose axes miss by up to a part of the length shoulder-elbow-wrist."""
    elbow, pattern = ("straight", "offset")[seed % 2], PATTERNS[seed // 2 % 3]
    if kind in ("mixed", "beyond"):
        return random_limb(seed, pattern, elbow, kind, miss)
    limb = random_limb(seed, pattern, elbow, "usual", miss)
    _put_ranges(kind, limb)
    return limb


def _put_ranges(kind: str, limb: RandomLimb) -> None:
    """Put joint ranges of one kind in the place of those of a limb."""
    model, rng = limb.model, limb.rng
    lower, upper = model.lowerPositionLimit, model.upperPositionLimit
    if kind in ("wide", "turns"):
        least, most = (2.5, 3.1) if kind == "wide" else (3.2, 9.0)
        lower[:], upper[:] = -rng.uniform(least, most, 7), rng.uniform(least, most, 7)
    else:
        count = rng.integers(1, 4) if kind == "narrow" else rng.integers(1, 3)
        for j in rng.permutation(7)[:count]:
            width = rng.uniform(0.05, 0.5) if kind == "narrow" else rng.choice([1e-3, 1e-6])
            lower[j] = rng.uniform(lower[j], upper[j])
            upper[j] = lower[j] + (0.0 if kind == "locked" else width)
    model.lowerPositionLimit, model.upperPositionLimit = lower, upper
    limb.lower[:], limb.upper[:] = lower, upper
