"""A search for the best posture: the state of a search for a minimum, samples in runs, brackets, and the answer."""

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

SPLIT = 8
"""A run of an exact limb whose branch is this or more goes along a free split, not along arm angles."""

LINES = 12
MOST_LINES = 8 * LINES * LINES
"""Runs across a surface, and arm angles if each of them has free splits; in all of a pose, at most."""

MOST_RUNS = MAX_RUNS + 2 * MOST_LINES
"""Room for the runs of a pose, free splits included: a limit may cut each of their lines in two."""

ROUNDS = 12
"""Runs in all directions through the best posture of a surface, at most so many times."""

TIE = 1e-12
"""Objectives that differ by less, relatively, are equal."""

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

# A free split: branch without the sides of what is singular, whether shoulder and wrist both are, arm angle, whether
# any arm angle will do, the first of the two joints (0 or 4), and the postures at both ends.
SPLIT_BRANCH = 0
SPLIT_BOTH = 1
SPLIT_ARM_ANGLE = 2
SPLIT_EVERYWHERE = 3
SPLIT_FIRST = 4
SPLIT_LOWER = 5  # 7
SPLIT_UPPER = 12  # 7
SPLIT_ROW = 19

MOST_SPLITS = 128
"""Room for the free splits of a pose."""

# A point of a way up to a larger margin: what each joint costs there, the rates of that with the arm angle, the arm
# angle, the largest of the costs with its rate, and the joint that has it (-1: none).
CLIMB_COSTS = 0  # 7
CLIMB_RATES = 7  # 7
CLIMB_PSI = 14
CLIMB_COST = 15
CLIMB_RATE = 16
CLIMB_ACTIVE = 17
CLIMB = 18
