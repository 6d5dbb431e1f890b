"""What a browser may say to the page with sliders: the few messages of its controls, with sensible numbers."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

FARTHEST = 1e3
"""Metres: no target is farther from the base in any direction, which keeps its squares and sums finite."""

MESSAGE_BYTES = 4096
"""Longest message; those of the controls have a few hundred bytes."""

_LARGEST = 1e6
"""No angle of a control, and no figure of a camera, is larger."""

_TURN = 1e-3
"""A rotation's quaternion has length one up to the rounding of the browser's 32-bit numbers."""

_CAMERA = {
    "wxyz": 4,
    "position": 3,
    "look_at": 3,
    "up_direction": 3,
    "fov": 0,
    "near": 0,
    "far": 0,
    "image_height": 0,
    "image_width": 0,
}
"""Length of each field of a camera's message; 0 for a plain number."""

Check = Callable[[Any], bool]


class Inbox:
    """Reads messages before viser does, and tells those that the page's own controls send from all others."""

    def __init__(self) -> None:
        self._values: dict[str, Check] = {}
        self._movable: set[str] = set()

    def expect(self, uuid: str, check: Check) -> None:
        """Accept values of a control that pass a check."""
        self._values[uuid] = check

    def expect_pose(self, name: str) -> None:
        """Accept poses of handles in the scene."""
        self._movable.add(name)

    def accepts(self, message: object) -> bool:
        """Whether a message is one of the page's."""
        import msgspec

        if not isinstance(message, bytes) or len(message) > MESSAGE_BYTES:
            return False
        try:
            fields = msgspec.msgpack.decode(message)
        except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
            return False
        kinds: dict[Any, Check] = {
            "GuiUpdateMessage": self._is_value,
            "TransformControlsUpdateMessage": self._is_pose,
            "TransformControlsDragStartMessage": self._is_handle,
            "TransformControlsDragEndMessage": self._is_handle,
            "ViewerCameraMessage": _is_camera,
        }
        kind = fields.pop("type", None) if isinstance(fields, dict) else None
        return isinstance(kind, str) and kind in kinds and kinds[kind](fields)

    def _is_value(self, fields: dict[str, Any]) -> bool:
        uuid, updates = fields.get("uuid"), fields.get("updates")
        if set(fields) != {"uuid", "updates"} or not isinstance(uuid, str) or uuid not in self._values:
            return False
        return isinstance(updates, dict) and set(updates) == {"value"} and self._values[uuid](updates["value"])

    def _is_pose(self, fields: dict[str, Any]) -> bool:
        wxyz, position = fields.pop("wxyz", None), fields.pop("position", None)
        return (
            self._is_handle(fields)
            and numbers(position, 3, FARTHEST)
            and numbers(wxyz, 4, 1.0 + _TURN)
            and abs(math.hypot(*wxyz) - 1.0) < _TURN
        )

    def _is_handle(self, fields: dict[str, Any]) -> bool:
        # The owner is that of the whole page: no control belongs to one browser alone.
        name = fields.get("name")
        known = isinstance(name, str) and name in self._movable
        return known and set(fields) <= {"name", "owner"} and not fields.get("owner")


def number(value: Any, largest: float = _LARGEST) -> bool:
    """Whether a value is a finite number of at most a size."""
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= largest


def numbers(value: Any, count: int, largest: float = _LARGEST) -> bool:
    """Whether a value is a list of so many of them."""
    return isinstance(value, list) and len(value) == count and all(number(x, largest) for x in value)


def _is_camera(fields: dict[str, Any]) -> bool:
    return set(fields) == set(_CAMERA) and all(
        numbers(fields[name], count) if count else number(fields[name]) for name, count in _CAMERA.items()
    )
