"""Things of classes, shapes and values that no argument takes, for tests of what a call says to them."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import srs_ik


class Odd:
    """Nothing in particular."""


WRONG = {
    "text": "nonsense",
    "object": Odd(),
    "class": Odd,
    "dictionary": {"a": 1},
    "complex": 1j,
    "ragged": [[1.0], [1.0, 2.0]],
    "texts": ["a"] * 7,
    "objects": [Odd()] * 7,
    "NaN": float("nan"),
    "NaNs": np.full(7, np.nan),
    "huge integer": 10**400,
    "infinite": float("-inf"),
}

SHAPED = {"None": None, "5 x 5": np.zeros((5, 5)), "2 x 7": np.zeros((2, 7)), "none at all": []}
"""Wrong for most arguments; some have None or arrays of any shape among their values."""


def refuses(call: Callable[..., Any], good: dict[str, Any], names: dict[str, str], takes: dict[str, str]) -> None:
    """Check that a call takes what is good, and raises an error of the package, in a line that names it, for the rest.

    Args:
        call: what is called, with keywords.
        good: an argument of each name.
        names: how messages call an argument, where not by its name.
        takes: names in `SHAPED` of what an argument takes all the same.
    """
    call(**good)
    for name in good:
        wrong = WRONG | {kind: value for kind, value in SHAPED.items() if kind not in takes.get(name, "")}
        for kind, value in wrong.items():
            with pytest.raises(srs_ik.SrsIkError) as caught:
                call(**{**good, name: value})
            message = str(caught.value)
            assert names.get(name, name.replace("_", " ")) in message.replace("_", " "), (name, kind, message)
            assert "\n" not in message
            assert len(message) < 400
