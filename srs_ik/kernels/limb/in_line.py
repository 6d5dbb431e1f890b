"""Where the outer axes of a shoulder or a wrist come into line, so that a pose fixes only a sum of their joints."""

import math

from srs_ik.kernels.algebra.pointers import copy
from srs_ik.kernels.algebra.vectors import add, apply, dot, load3, norm, rotate
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import limb as at

NEARLY_IN_LINE = 1e-4
"""Outer axes that come this close to one line, rad, are searched as if they did; wider apart, the curves tell all."""

CLOSE_GAP = 0.5 * NEARLY_IN_LINE**2
"""Axes that lean come no closer to one line than 1 - the cosine says: below this, within `NEARLY_IN_LINE`."""

ROUNDED = 1e-5
"""A limb that misses by less than this part of its reach has postures all along a free split, or next to it."""

SMALLEST_REACH = 1e-300
"""Stands for a reach of zero."""


@kernel
def comes_in_line(P, k, end):
    """Whether some turns of a spherical joint bring its outer axes into line, or almost.

    The end says whether they point the same way there (0) or opposite ways (1).
    """
    return P[k + (at.TOP_GAP if end == 0 else at.BOTTOM_GAP)] < CLOSE_GAP


@kernel
def in_line(x, y, P, k, width):
    """Whether two axes at cosines x and y from a line that one of them turns about come into line, but for a width."""
    return (comes_in_line(P, k, 0) and abs(x - y) < width) or (comes_in_line(P, k, 1) and abs(x + y) < width)


@kernel
def may_line_up(P, place_, width):
    """Whether the outer axes of the shoulder or the wrist may come into line at some arm angle: a quick test.

    One of the two stands still while the arm angle turns the other about the line S-W; they meet if both are at the
    same angle from it, up to some width.
    """
    t, _, c, s, hand, _ = place_
    still_s = dot(load3(P, at.SHOULDER + at.A1), t)
    still_w = dot(apply(hand, load3(P, at.WRIST + at.A3)), t)
    a4 = load3(P, at.AXES + 9)
    for elbow in range(2):
        sine = -s if elbow == 1 else s
        to_wrist = add(load3(P, at.UPPER_ARM), rotate(a4, c, sine, load3(P, at.FOREARM)))
        share = 1.0 / max(norm(to_wrist), SMALLEST_REACH)
        if in_line(still_s, share * dot(to_wrist, load3(P, at.SHOULDER + at.A3)), P, at.SHOULDER, width):
            return True
        c4 = P[at.COS_STRAIGHT] * c - P[at.SIN_STRAIGHT] * sine
        s4 = P[at.SIN_STRAIGHT] * c + P[at.COS_STRAIGHT] * sine
        if in_line(still_w, share * dot(to_wrist, rotate(a4, c4, s4, load3(P, at.WRIST + at.A1))), P, at.WRIST, width):
            return True
    return False


@kernel
def may_split(P, place_):
    """Whether a limb that misses by little may have outer axes in line, or almost, at some arm angle of a pose."""
    return P[at.MISS] <= ROUNDED * P[at.FAR] and may_line_up(P, place_, NEARLY_IN_LINE)


@kernel
def closest(P, k, motion, end):
    """Arm angle at which the outer axes of a spherical joint come closest to one line: it, and how close, rad.

    The end says whether they point the same way there (0) or opposite ways (1). Last, how close they are elsewhere.
    """
    circle = motion[0]
    a1 = load3(P, k + at.A1)
    sign = 1.0 if end == 0 else -1.0
    constant = sign * dot(a1, circle[0])
    c = sign * dot(a1, circle[1])
    s = sign * dot(a1, circle[2])
    r = math.sqrt(c * c + s * s)
    least = math.sqrt(max(2.0 * (1.0 - constant - r), 0.0))
    most = math.sqrt(max(2.0 * (1.0 - constant + r), 0.0))
    return math.atan2(s, c), least, most


@kernel
def toward_of(P, k, q2):
    """1.0 where the outer axes of a spherical joint next to its singularity point the same way, else -1.0."""
    return 1.0 if math.cos(q2 - P[k + at.PHASE]) > 0.0 else -1.0


@kernel
def is_in_line(P, k, q2, width):
    """Whether the outer axes of a spherical joint are within some angle of one line."""
    end = 0 if toward_of(P, k, q2) > 0.0 else 1
    return comes_in_line(P, k, end) and abs(math.sin(q2 - P[k + at.PHASE])) < width


@kernel
def wide_limb(P, wide):
    """Copy the packed limb to `wide`, which takes axes for parallel that are almost so."""
    copy(P, wide, at.SIZE)
    wide[at.SLACK_SINGULAR] = NEARLY_IN_LINE
