"""Whether an error grows or shrinks: what every port has to know first."""

from __future__ import annotations

from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.control import MOVED, SWITCH


@kernel
def grows(port, state, last, size, growth, was_growing):
    """Whether an error of this size grows, whose size was `last` a tick ago (negative: there was none).

    `growth` is the rate of the size for a target at rest (m/s, rad/s). It tells at once what the size itself tells one
    period late; for a target that has moved it says nothing.
    """
    if last < 0.0:
        return True
    if port[SWITCH] >= 0.0 and state[MOVED] == 0.0:
        return growth >= -port[SWITCH]
    if size != last:
        return size > last
    return was_growing
