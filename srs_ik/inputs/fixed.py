"""Attributes that are set once."""

from __future__ import annotations

from typing import Any, ClassVar


class Fixed:
    """Refuses to set some attributes again: what was computed from them would not know of the new values."""

    _fixed: ClassVar[frozenset[str]] = frozenset()
    _instead: ClassVar[str] = ""

    def __setattr__(self, name: str, value: Any) -> None:
        if name in self._fixed and name in self.__dict__:
            raise AttributeError(f"{type(self).__name__}.{name} cannot be changed: {self._instead}")
        super().__setattr__(name, value)
