"""Runs of postures across free splits, sampled for the search for an optimum: see `free_splits` and `survey`.

The parameter of such a run is how far joint 1 of the singular shoulder or wrist has turned, joint 3 against it. Where
more than one sum is free at once, many runs cover the surface of postures, and the best is closed in on by runs through
it in all directions of the surface.
"""

import math

import numpy as np

from srs_ik.kernels.algebra.pointers import keep, row
from srs_ik.kernels.algebra.vectors import dot, load3, rotate
from srs_ik.kernels.chain.newton import CLOSED, close_gently
from srs_ik.kernels.curves.follow import put
from srs_ik.kernels.curves.runs import cut
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import limb as at
from srs_ik.kernels.layout.asked import Samples, Setting
from srs_ik.kernels.layout.search import LINES, MOST_LINES, SPLIT
from srs_ik.kernels.limb.branches import NO_BRANCH, side_posture
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.limb.in_line import NEARLY_IN_LINE, closest, comes_in_line, is_in_line, toward_of, wide_limb
from srs_ik.kernels.limb.surface import split
from srs_ik.kernels.limb.triangle import elbow_side

PARTS = 48
"""Parts of a turn into which a segment is sampled."""

NEARLY = 2.0 * NEARLY_IN_LINE
"""Outer axes of a posture within this of one line, rad, may have been closed from such a posture."""

HALF = 2.0 * math.pi / LINES
AROUND = 8
"""Length, to either side, and parts of a run through the best posture of a surface."""

MOST_ROWS = MOST_LINES * (PARTS + 8)
"""Room for the samples of all segments of a pose."""


@kernel
def moved_along(q, x1, x3, x5, x7):
    """A posture with its outer joints turned."""
    return (q[0] + x1, q[1], q[2] + x3, q[3], q[4] + x5, q[5], q[6] + x7)


@kernel
def swung_by(P, q, x):
    """A posture of a straight arm, shoulder to wrist along axes 3 and 5, swung about that line."""
    a5 = rotate(load3(P, at.AXES + 9), P[at.COS_STRAIGHT], P[at.SIN_STRAIGHT], load3(P, at.WRIST + at.A1))
    return moved_along(q, 0.0, x, -math.copysign(x, dot(load3(P, at.SHOULDER + at.A3), a5)), 0.0)


@kernel
def put_line(P, by, q, line_of, line, out, used):
    """Sample a line through a posture and write its feasible runs: rows and runs in use.

    `line_of` holds its way (0 split of the shoulder, 1 of the wrist, 2 and 3 both together and against each other, 4 to
    7 swing of the arm by joints 3 and 5, 1 and 5, 3 and 7, 1 and 7), its length to either side and in how many parts,
    and the branch of its runs.
    """
    way, half, parts, branch = line_of
    count = 0
    for i in range(parts + 1):
        x = half * (2.0 * i / parts - 1.0)
        start = q
        if way >= 4:
            start = swung_by(P, q, x)
            if way & 1 == 1:
                start = split(P, at.SHOULDER, start, toward_of(P, at.SHOULDER, q[1]) * (start[2] - q[2]))
            if way & 2 == 2:
                start = split(P, at.WRIST, start, q[4] - start[4])
        else:
            if way != 1:
                start = split(P, at.SHOULDER, start, x)
            if way != 0:
                start = split(P, at.WRIST, start, -x if way == 3 else x)
        closed, error = close_gently(P, start, by.target.R, by.target.p, False, by.J, by.A)
        if error <= CLOSED:
            count = put(line, count, x, closed)
        if count > 0 and (error > CLOSED or i == parts):
            used = cut(P, by, branch, Samples(line, 0, count), out, used)
            count = 0
    return used


@kernel
def survey_splits(P, by, line, out, used):
    """Sample the free splits of a pose behind the rows and runs in use: rows and runs in use then."""
    boxes = np.empty((1, at.SIZE))
    wide = row(boxes, 0)
    wide_limb(P, wide)
    for elbow in range(2):
        side = elbow_side(P, by.target.place, elbow)
        by = Setting(by.target, side, by.respect, by.J, by.A)
        for i in range(4):
            block = at.SHOULDER if i < 2 else at.WRIST
            if not comes_in_line(P, block, i % 2):
                continue
            psi, least, most = closest(P, block, side[1] if i < 2 else side[2], i % 2)
            if least > NEARLY_IN_LINE:
                continue
            everywhere = most < NEARLY_IN_LINE
            for sign in range(2):
                branch = 4 * elbow + (sign if i < 2 else 2 * sign)
                turns = LINES if everywhere else 1
                for turn in range(turns):
                    angle = psi + turn * 2.0 * math.pi / turns
                    q, _, value = side_posture(wide, side, angle, (branch >> 1) & 1, branch & 1, False, NO_SEED, False)
                    if value >= NO_BRANCH:
                        continue
                    surface = (
                        is_in_line(P, at.WRIST, q[5], NEARLY) if i < 2 else is_in_line(P, at.SHOULDER, q[1], NEARLY)
                    )
                    code = branch + SPLIT
                    lines = LINES if surface else 1
                    for k in range(lines):
                        # A segment of the surface at each of so many splits of the other spherical joint.
                        start = split(P, at.WRIST if i < 2 else at.SHOULDER, q, k * 2.0 * math.pi / lines)
                        used = put_line(P, by, start, (i // 2, math.pi, PARTS, code), line, out, used)
    keep(boxes)
    return used


@kernel
def free_sums(P, q):
    """Whether a posture's shoulder and wrist leave a sum free each, and whether its elbow is on the line S-W."""
    straight = abs(math.sin(q[3] - P[at.STRAIGHT])) < NEARLY_IN_LINE
    return is_in_line(P, at.SHOULDER, q[1], NEARLY), is_in_line(P, at.WRIST, q[5], NEARLY), straight


@kernel
def is_on_surface(P, q):
    """Whether a posture of an exact limb lies on a surface of postures of its pose."""
    shoulder, wrist, straight = free_sums(P, q)
    return P[at.IS_CLOSED] == 1.0 and int(shoulder) + int(wrist) + int(straight) > 1


@kernel
def put_star(P, by, q, line, out):
    """Write the runs through a posture in all directions of its surface: rows and runs in use."""
    used = (0, 0)
    shoulder, wrist, straight = free_sums(P, q)
    for way in range(8):
        wanted = (shoulder or way == 1) and (wrist or way == 0)
        if way >= 4:
            wanted = straight and (shoulder or way & 1 == 0) and (wrist or way & 2 == 0)
        if wanted:
            used = put_line(P, by, q, (way, HALF, 2 * AROUND, SPLIT), line, out, used)
    return used
