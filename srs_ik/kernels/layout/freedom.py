"""What a pose leaves free: the turn about an axis of the tip, a cone of directions for that axis, or all turns."""

from __future__ import annotations

from typing import Any, NamedTuple

FREE_AXIS = 0  # 3, unit vector in the tip frame
FREE_CONE = 3  # rad; 0: the turn about the axis alone is free, pi: all turns are
FREEDOM = 4
"""A freedom as an array."""

SYSTEM = 16
"""Rows and columns of the work space of a step: seven joints, up to five equations, a right-hand side."""

MOST_STARTS, MOST_TAKEN = 2048, 256
"""Room for postures that searches start from; most of them that are taken, which are kept in the last rows."""

STRIPS = 6
"""Most strips of rolls on one side of the elbow: two in each of three turns of its joint."""

START_COST = 7
START_LEANS = 8
START_LATE = 9
START = 10
"""A start: seven joint angles, their cost, whether its turn is more than a roll, and its cost to late searches."""

ARM_ANGLES = 24
"""Arm angles at which postures are looked at, all around; a multiple of `LANES`."""

HALF = 4
HALF_COST = 3
"""A solution of shoulder or wrist at all arm angles: three rows of angles, and their costs."""

ELBOW_ANGLE = 4 * HALF * ARM_ANGLES
ELBOW_COST = ELBOW_ANGLE + 1
LINE = ELBOW_ANGLE + 2
SHIFT = LINE + 3
BRANCH_COST = SHIFT + 1
INSIDE = BRANCH_COST + ARM_ANGLES + 2
REACHED = INSIDE + 1
TABLE = REACHED + 1
"""Postures at a turn: both solutions of the shoulder, both of the wrist, and the elbow; the direction from shoulder to
wrist and the shift of the arm angles, for which they were written; what a branch costs at all arm angles, the last
before the first and the first behind the last; what the best start inside the limits costs; how many turns
have reached, each side of the elbow counted."""

WORK = 49 + 3 * SYSTEM * SYSTEM + TABLE
"""Work space of a search."""


class Freedom(NamedTuple):
    """What a pose leaves free: a unit axis of the tip frame, and how far it may lean from the pose's own, rad."""

    axis: Any
    cone: float


class Liking(NamedTuple):
    """What is nearest: seven figures each of a posture, weights of the squared differences from it, and both limits.

    Searches that come to a larger sum than that of a rival are of no use, nor those that come to the rival itself.
    """

    posture: Any
    weights: Any
    lower: Any
    upper: Any
    rival: float
    rival_posture: Any


class Sought(NamedTuple):
    """What starts of searches are for: seven angles of a seed or of the middles, and the best posture that is known.

    Joint 7 is loose where it turns the tip about the free axis: then it is as it is wanted. Arm angles that are looked
    at begin at a shift, rad.
    """

    seeded: bool
    wish: Any
    known: Any
    loose: bool
    shift: float


class Found(NamedTuple):
    """A posture, its cost, and whether it meets its pose inside the limits."""

    q: Any
    cost: float
    met: bool


class Desk(NamedTuple):
    """Work space: J (6, 7) and a row to spare, a system of equations (SYSTEM, SYSTEM), a copy, one for shares, tables.

    These are postures at a turn (TABLE,) and starts (MOST_STARTS, START).
    """

    J: Any
    system: Any
    copy: Any
    shares: Any
    table: Any
    starts: Any
