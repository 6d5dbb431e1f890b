"""Which of several limbs is meant by a word: a side, or a part of its names."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Literal

Side = Literal["left", "right", "either"]

_WORDS = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")
"""Words of a name such as ``left_arm``, ``LShoulderPitch`` or ``yumi_joint_1_l``."""

_LEFT = frozenset({"left", "l", "larm", "lhand"})
_RIGHT = frozenset({"right", "r", "rarm", "rhand"})


def side_of(names: Iterable[str]) -> Side:
    """The side of a body that most of some names speak of; "either" where they speak of none, or of both alike."""
    left = right = 0
    for name in names:
        words = {word.casefold() for word in _WORDS.findall(name)}
        left += not words.isdisjoint(_LEFT)
        right += not words.isdisjoint(_RIGHT)
    if left == right:
        return "either"
    return "left" if left > right else "right"


def is_meant(word: str, names: Iterable[str]) -> bool:
    """True if a limb with these names is meant by a word: "left", "right", or anything that stands in one of them."""
    names = list(names)
    if word.casefold() in ("left", "right"):
        return side_of(names) == word.casefold()
    return any(word.casefold() in name.casefold() for name in names)
