"""A search for the best posture: the state of a search for a minimum, samples in runs, brackets, and the answer."""

from __future__ import annotations

from srs_ik.kernels.layout.answer import MAX_PIECES

# The state of `minimum`.
LOW = 0
HIGH = 1
BEST = 2
SECOND = 3
THIRD = 4
F_BEST = 5
F_SECOND = 6
F_THIRD = 7
STEP = 8
STEP_BEFORE = 9
WANTED = 10
COUNT = 11
RESOLUTION = 12
STATE = 13
"""Places in the state of a search, and its length: ends, best points and values, last two steps, next point ..."""

SMOOTH = 3e-9
"""Resolution for a smooth function, rad: closer points differ by less than its rounding."""

SHARP = 1e-11
"""Resolution for a function whose minimum may be a corner."""

MAX_RUNS = 8 * MAX_PIECES

RUN = 5
"""A run: branch, first and last parameter, first row of its samples, and the row behind the last."""

BRACKET = 8
"""A bracket: value at its middle, run, first, middle and last parameter, values at its ends, a bound below."""

REFUSED = 1e300
"""Value of a posture that does not count."""

MAX_BRACKETS = 64

OUT_VALUE = 0
OUT_SECOND = 1
OUT_LOWER = 2
OUT_UPPER = 3
OUT = 4
"""What an optimum is beside its row: value, value of the second objective, ends of the interval."""

NO_POSTURE = 0
FOUND = 1
