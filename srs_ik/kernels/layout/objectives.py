"""Objectives that are kernels: their numbers, and their parameters."""

from srs_ik.kernels.layout.weights import WEIGHTS

RATIO = 0  # (f'JpJp'f) / (v'JpJp'v)
FORCE = 1  # f'JpJp'f
VELOCITY = 2  # -(v'JpJp'v)
TWIST = 3  # -(t'JJ't)
WRENCH = 4  # w'JJ'w
MANIPULABILITY = 5  # -sqrt(det JJ')
LIMIT_MARGIN = 6  # minus the smallest distance from a limit, over half of the joint's range
REFERENCE = 7  # sum of squared differences from the posture in places 0 to 6 of params

GRAVITY = 8  # sum of squared gravity torques

RESPECT = 7
"""Place in params that says whether turns have to keep the limits (1.0) or not."""

WEIGHT = 8
"""Place in params from which on the figures of `gravity` lie."""

PARAMS = WEIGHT + WEIGHTS

SMALLEST = 1e-300
"""Stands for a denominator of zero."""
