"""Figures and vectors in the text of robot files."""

from __future__ import annotations

import math
import re

from srs_ik.system import bounds

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_TINY = 1e-300


def figure(text: str) -> float:
    """A finite number, tiny ones as 0; NaN for any other text."""
    word = text.strip()
    # The length first: the pattern takes time that grows with its square where it fails.
    value = float(word) if len(word) <= bounds.NUMBER and _NUMBER.fullmatch(word) else math.nan
    if not math.isfinite(value):
        return math.nan
    return value if abs(value) > _TINY else 0.0
