"""Attributes that are set once, and objects that take no others than they have."""

from __future__ import annotations

from typing import Any, ClassVar

from srs_ik.errors import did_you_mean


class Fixed:
    """Refuses to set some attributes again: what was computed from them would not know of the new values.

    A class that says `_closed` takes no public attribute that it does not have, so that none is misspelt in silence; a
    class of a caller that is derived from it may.
    """

    _fixed: ClassVar[frozenset[str]] = frozenset()
    _instead: ClassVar[str] = ""

    def __setattr__(self, name: str, value: Any) -> None:
        own = type(self)
        if name in self._fixed and name in self.__dict__:
            raise AttributeError(f"{own.__name__}.{name} cannot be changed: {self._instead}")
        if "_closed" in vars(own) and not (name.startswith("_") or name in self._fixed or hasattr(own, name)):
            known = [each for each in (*self._fixed, *dir(own)) if not each.startswith("_")]
            raise AttributeError(f"{own.__name__} has no attribute {name!r}{did_you_mean(name, known)}")
        super().__setattr__(name, value)
