"""Answers: the row of a posture, its status, the verdict on a pose, and how many intervals a pose may have."""

# A solution row, the output of the solving kernels.
ROW_Q = 0  # 7
ROW_POSITION_ERROR = 7
ROW_ORIENTATION_ERROR = 8
ROW_ARM_ANGLE = 9
ROW_STATUS = 10
ROW_BRANCH = 11
ROW_JOINT = 12  # the joint (1 to 7) with the smallest margin to its limits
ROW = 13
ROW_COST = ROW_POSITION_ERROR  # of q, in the row of a branch until its errors are measured

# Statuses, numbered as in `srs_ik.Status`.
OK = 0.0
UNREACHABLE = 1.0
OUT_OF_LIMITS = 2.0

SOLVED = 1e-9
"""A posture is a solution if position (m) and orientation (rad) errors on the true chain are below this."""

FARTHEST = 1e300
"""Largest coordinate of a pose, metres: sums of a few such figures are finite."""

NOT_A_ROTATION = 1e-6
"""Largest deviation of R'R from the identity that is taken as rounding and removed."""

GOOD_POSE = 0
NOT_FINITE = 1
NOT_RIGID = 2
TOO_FAR = 3
"""Verdicts on a pose."""

MAX_EVENTS = 40
"""Most arm angles at which one spherical joint can start or stop to be feasible."""

MAX_PIECES = 2 * MAX_EVENTS
"""Most intervals of one branch."""

MOST_INTERVALS = 8 * MAX_PIECES
"""Most intervals of one pose."""
