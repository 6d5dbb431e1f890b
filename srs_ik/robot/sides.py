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
    """The side of a body that more than half of some names speak of, else "either".

    One name is not enough: single arms end in a "right_hand" by habit, and every gripper has a left finger.
    """
    words = [{word.casefold() for word in _WORDS.findall(name)} for name in names]
    if 2 * sum(not said.isdisjoint(_LEFT) for said in words) > len(words):
        return "left"
    return "right" if 2 * sum(not said.isdisjoint(_RIGHT) for said in words) > len(words) else "either"


def is_meant(word: str, names: Iterable[str]) -> bool:
    """True if a limb with these names is meant by a word: "left", "right", or anything that stands in one of them."""
    names = list(names)
    side = side_of(names)
    if word.casefold() in ("left", "right") and side != "either":
        return side == word.casefold()
    return any(word.casefold() in name.casefold() for name in names)
