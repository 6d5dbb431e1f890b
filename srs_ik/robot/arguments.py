"""Arguments of `load` and `find_limbs`: of the right kind, or refused in one line."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

from srs_ik.errors import InvalidRobot, quoted


def check_texts(**given: Any) -> None:
    """Raise InvalidRobot, with the name of the argument, for what is neither text nor None."""
    for name, value in given.items():
        if value is not None and not isinstance(value, str):
            raise InvalidRobot(f"{name} is text, not {quoted(value)}")


def check_path(name: str, value: Any) -> None:
    """Raise InvalidRobot for what is no path or text."""
    if not isinstance(value, str | os.PathLike) or isinstance(os.fspath(value), bytes):
        raise InvalidRobot(f"{name} is a path or text, not {quoted(value)}")


def check_xacro_args(value: Any) -> None:
    """Raise InvalidRobot for what is no mapping of texts."""
    if value is None:
        return
    if not isinstance(value, Mapping) or not all(isinstance(text, str) for pair in value.items() for text in pair):
        raise InvalidRobot(f"xacro_args are given as {{name: text}}, not as {quoted(value)}")
