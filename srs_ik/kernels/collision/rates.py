"""How fast the joints of shoulder and wrist turn at most while the arm turns about the line shoulder-wrist."""

import math

from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.shapes import COSINE, FIXED, SINE, TO_FIRST, TO_LAST


@kernel
def angle_between(outer, k, q):
    """The angle between the outer axes of shoulder (0) or wrist (1) at an angle of the joint between them."""
    cosine = outer[k, FIXED] + outer[k, COSINE] * math.cos(q) + outer[k, SINE] * math.sin(q)
    return math.acos(min(max(cosine, -1.0), 1.0))


@kernel
def fastest(outer, k, q, half):
    """Largest rate of joints 1 and 3 of a spherical joint within half an arm angle, rad/rad; inf for no bound.

    The rates have the triple product of the three axes below them. Its square is a concave function of the cosine of
    the angle between the outer axes, so the smaller of both ends bounds it; and that angle changes no faster than the
    arm turns.
    """
    angle = angle_between(outer, k, q)
    if angle - half <= 0.0 or angle + half >= math.pi:
        return math.inf
    first, last = outer[k, TO_FIRST], outer[k, TO_LAST]
    least = math.inf
    for end in (angle - half, angle + half):
        c = math.cos(end)
        least = min(least, 1.0 - first * first - last * last - c * c + 2.0 * first * last * c)
    return 1.0 / math.sqrt(least) if least > 0.0 else math.inf


@kernel
def middle_rate(outer, k, rate):
    """The same of the joint between them: 1 where it is square to both."""
    return 1.0 if outer[k, TO_FIRST] == 0.0 and outer[k, TO_LAST] == 0.0 else rate


@kernel
def rate_of(outer, shoulder, wrist, joint):
    """Largest rate of a joint, 1 to 7, from those of the outer ones; the elbow stands still."""
    if joint <= 3:
        return middle_rate(outer, 0, shoulder) if joint == 2 else shoulder
    if joint == 4:
        return 0.0
    return middle_rate(outer, 1, wrist) if joint == 6 else wrist


@kernel
def turns(joint):
    """Whether the body of a joint turns with the arm angle."""
    return 2 <= joint <= 5


@kernel
def times_rate(length, rate):
    """A length times a rate that may be infinite."""
    return length * rate if length > 0.0 else 0.0
