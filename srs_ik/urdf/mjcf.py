"""MJCF files, the format of MuJoCo, as far as Pinocchio reads them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from srs_ik.errors import InvalidRobot


def build(path: Path, label: str, first_complaint: Callable[[], str]) -> Any:
    """The ``pinocchio.Model`` of an MJCF file.

    Args:
        path: the file.
        label: what error messages call it.
        first_complaint: what the parser has printed by now.

    Raises:
        InvalidRobot: Pinocchio does not read it, or its figures are no finite numbers.
    """
    try:
        model = pin.buildModelFromMJCF(str(path))
    except Exception as error:
        complaint = first_complaint() or " ".join(str(error).split())
        raise InvalidRobot(f"{label} is an MJCF file that Pinocchio does not read: {complaint}", label) from None
    for joint, placement in enumerate(model.jointPlacements):
        if not np.isfinite(placement.homogeneous).all():
            raise InvalidRobot(f"{label}: joint {model.names[joint]!r} is not placed by finite numbers", label)
    return model
