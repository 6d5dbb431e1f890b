"""A joint path: the postures of its poses as strips, what its steps count, and what travels together."""

from __future__ import annotations

from typing import Any, NamedTuple

ROOMY = 2
ROOMIEST = 3
"""In a path's family, in place of those with loose tolerances: the limb with limits drawn out by rounding, and by what
a bend of the elbow that rounding hides does to the other joints."""

NODE = 10
NODE_PSI = 7
NODE_BRANCH = 8
NODE_SAG = 9
"""A posture of a strip: seven joint angles, arm angle, branch, and how far the costs sag towards the next one."""

STRIP = 17
STRIP_FIRST = 14
STRIP_LAST = 15
STRIP_LEAST = 16
"""A strip: least and largest angle of every joint, the rows of its first and last posture, and what none of its
postures costs less than."""

CELL = 18
CELL_OFF = 14
CELL_FROM = 15
CELL_TO = 16
CELL_BRANCH = 17
"""A piece of the postures of a pose: its first posture and from there to its last one (7 figures each), how far the
postures may be off the straight piece, the arm angles of both, and its branch (`POINT`: one posture, `CURVE`: a piece
of the curve of a near limb)."""

POINT = -1
CURVE = -2

HELD = 10
HELD_PSI = 7
HELD_BRANCH = 8
HELD_LINKED = 9
"""A posture that is known before its strips are looked for: seven joint angles, arm angle, branch (-1: it stays as it
is), and whether it is linked to the next one."""

MEMO = 14
MEMO_STAMP = 0
MEMO_CLEAR = 1
MEMO_SHOULDER = 2
MEMO_WRIST = 8
"""What is known at one arm angle of an elbow branch: of which pose, whether it is clear cut, and both solutions of
shoulder and wrist, three angles each."""

WORTH = 3
WORTH_BEGIN = 0
WORTH_END = 1
WORTH_SAG = 2
"""What a cell costs at least: at its begin, at its end, and between: at a part t of the way, t (1 - t) times the last
figure less than the straight line from one to the other."""

BY_VELOCITY = 0
BY_CONTINUITY = 1
PERIOD = 2
INVERSE_PERIOD = 3
INVERSE_SPEED = 4
LEAST_INVERSE = 5
ENDLESS = 6
SETTINGS = 7
"""Rows of the settings of a path, seven figures each: longest steps, a turn for joints without end or zero, 1 / it.

Where the slowest joint counts in place of the squares of all: by what steps are multiplied, and the least of that;
else zero. And whether any joint turns without end. Kernels know them by a pointer to the first figure.
"""

BREAK = 1e10
"""Cost of a step that is too long to be continuous."""

TOO_FAST = 1e5
"""Cost of a step above a velocity limit."""

IMPOSSIBLE = 1e15

SIDE = 43
SIDE_ELBOW = 0
SIDE_LINE = 1
SIDE_FOREARM = 4
SIDE_SHOULDER = 7
SIDE_WRIST = 25
"""One elbow branch of a pose: elbow angle, direction S-W, the same seen from the forearm, and two circles of three
vectors each for shoulder and wrist (18 figures each)."""

TIP = 12
"""Rotation and position of a pose."""

SQUARES = 0
WITHIN = 1
LARGEST = 2
SLOWEST = 3
"""What all arm angles at once make least: the sum of squared steps, the same within limits of the steps, the largest
step, and the sum of the largest step of each pose. Steps are multiplied by a figure for each joint."""


class Sheet(NamedTuple):
    """Postures (N, NODE), whether each is linked to the next (N,), their costs (N,), strips (M, STRIP)."""

    nodes: Any
    linked: Any
    cost: Any
    strips: Any


class Pages(NamedTuple):
    """Postures, costs and strips of a sheet, as pointers to their first figures."""

    nodes: Any
    cost: Any
    strips: Any


class Desk(NamedTuple):
    """Work space of the strips of a pose: intervals, first arm angles, postures on hold, turns of joints.

    In `memo` (m, MEMO) is what is known at angles of a grid, for the pose of number `stamp[0]`, in `ends` (m, 8) at the
    ends of intervals: arm angle and joint angles.
    Intervals that are allowed (m, 3) may be given, those of a pose from row `given[0]` on; -1: all are.
    """

    found: Any
    targets: Any
    stack: Any
    turns: Any
    allowed: Any
    given: Any
    memo: Any
    stamp: Any
    ends: Any


class Net(NamedTuple):
    """Cells (M, CELL) as they are made: their longest length, whether all turns of joints are wanted, work space."""

    cells: Any
    longest: float
    all_turns: bool
    desk: Desk
    sheet: Sheet


class Span(NamedTuple):
    """The rows of a pose in a sheet: first posture, one behind the last one, and the same of strips."""

    first: int
    last: int
    first_strip: int
    last_strip: int


class Rules(NamedTuple):
    """What a step counts: settings, whether velocity limits do, and by which its squares are taken."""

    settings: Any
    limited: bool
    share: float


class Around(NamedTuple):
    """Where strips are fine: about a posture, so far, joints so far apart, rad; with 0, they are coarse everywhere."""

    q: Any
    radius: float
    spacing: float


class Posture(NamedTuple):
    """One posture of a path: joint angles, arm angle, branch."""

    q: Any
    psi: float
    branch: int


class Course(NamedTuple):
    """Poses (n, 4, 4), those that count (k,), which postures stay (n,), least and largest arm angles (n, 2).

    Of an exact limb, `sides` (n, SIDE) are the elbow branches of the postures, of a near one (n, TIP) the poses.
    """

    poses: Any
    chain: Any
    fixed: Any
    bounds: Any
    sides: Any


class Stop(NamedTuple):
    """What a course tells of one of its poses, as pointers: the pose, its arm angles, and the elbow branch."""

    pose: Any
    bounds: Any
    side: Any


class Line(NamedTuple):
    """Postures of a path: joint angles (n, 7), arm angles (n,), branches (n,)."""

    q: Any
    psi: Any
    branch: Any


class Space(NamedTuple):
    """Work space of a near limb: J (6, 7) and A (16, 9)."""

    J: Any
    A: Any


class Aim(NamedTuple):
    """What is made least: its kind, by which figures (7,) steps are multiplied, and the weight of limits.

    Without limits, the weight is the part of all that may be left to gain.

    Steps that are `loose` (n,) are breaks, for which no limits hold.
    """

    kind: int
    scale: Any
    weight: float
    loose: Any


class System(NamedTuple):
    """A step of all arm angles (k,): a tridiagonal matrix, what is solved for, its border, and work space.

    `terms` (3, 7) are the derivatives of one joint step.
    """

    diagonal: Any
    next_to: Any
    move: Any
    border: Any
    shares: Any
    spare: Any
    terms: Any
