"""Attributes that are set once."""

from __future__ import annotations

from typing import Any


class Fixed:
    """Refuses to set a public attribute again: what was computed from it would not know of the new value."""

    _instead = "make another one"

    def __setattr__(self, name: str, value: Any) -> None:
        if name in self.__dict__ and not name.startswith("_"):
            raise AttributeError(f"{type(self).__name__}.{name} cannot be changed: {self._instead}")
        super().__setattr__(name, value)
