"""Postures of the nearest exact limb along which sums of joints alone are fixed: where outer axes come into line.

They make up a surface where two of shoulder, elbow and wrist are singular at once, a curve where one is. The curves of
the true chain lie next to it, but connect in ways of their own.
"""

import math

from srs_ik.kernels.algebra.joint_vectors import short_way, store7
from srs_ik.kernels.algebra.pointers import row, scratch
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import limb
from srs_ik.kernels.layout.asked import Goal
from srs_ik.kernels.layout.limb import SIZE
from srs_ik.kernels.limb.branches import side_posture
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.limb.in_line import ROUNDED, closest, may_line_up, toward_of, wide_limb
from srs_ik.kernels.limb.splits import with_outer
from srs_ik.kernels.limb.triangle import elbow_side

MOST_MISS = 1e-3
"""A limb that misses by more than this part of its reach has curves that are no more next to a surface ..."""

WIDTH_OF_CURVES = 3.0
MOST_WIDTH_OF_CURVES = 0.08
"""... but small closed ones where shoulder and wrist are so many misses from singular at once, rad, at most."""

LEAST_WIDTH = 3e-4
MOST_WIDTH = 5e-3
WIDTH = 20.0
"""Outer axes are one line if they are so many misses, as parts of the reach, from it, rad, within these bounds."""

BENDS = 4.0
"""Bends of the elbow that differ in reach by so many misses are one."""

IN_LINE = 1e-9
"""Outer axes whose cosine comes this close to that of one line can be in line."""

FIRST = 24
"""So many postures are as they come, at arm angles all around; the others have other splits."""

STARTS, STARTS_ONE = 40, 16
"""So many postures of a part are where curves may be found, and of one with a flat elbow and a single way."""

EVERY_SPLIT = 0b1111
"""All of the splits that `put_starts` names."""

MOST_PARTS = 32
PART = 7
PART_ELBOW, PART_LEVEL, PART_PSI, PART_EVERYWHERE, PART_SIGNS, PART_SHOULDER, PART_WRIST = range(PART)
"""A part of the surface: side of the elbow, whether it is flat, arm angle, whether all arm angles count, bits of the
shoulder and the wrist; whether the sum of joints 1 and 3 may be split anyhow, and that of 5 and 7."""


@kernel
def flat_bend(P, place_):
    """By how much an elbow may be bent, rad, if a pose may be one of a straight or folded one by the limb's misses."""
    reach = P[limb.FAR] if place_[2] > 0.0 else P[limb.NEAR]
    return math.sqrt(8.0 * BENDS * P[limb.MISS] * reach / ((P[limb.FAR] - P[limb.NEAR]) * (P[limb.FAR] + P[limb.NEAR])))


@kernel
def is_flat(P, place_):
    """Whether a pose may be one of a straight or folded elbow, as far as the limb's misses let it tell."""
    return place_[3] < flat_bend(P, place_)


@kernel
def is_free(P, k, q2, width):
    """Whether the outer axes of a spherical joint are as good as in line at an angle of its middle joint."""
    gap = P[k + limb.TOP_GAP] if toward_of(P, k, q2) > 0.0 else P[k + limb.BOTTOM_GAP]
    return gap < IN_LINE and abs(math.sin(q2 - P[k + limb.PHASE])) < width


@kernel
def split(P, k, q, turn):
    """A posture with joint 1 of the spherical joint at block k turned, and joint 3 so that their sum stays."""
    first = 0 if k == limb.SHOULDER else 4
    return with_outer(q, first, q[first] + turn, q[first + 2] - toward_of(P, k, q[first + 1]) * turn)


@kernel
def in_line_width(P):
    """How close outer axes come to one line, rad, where they count as such; 0.0 for limbs without a surface."""
    if P[limb.IS_CLOSED] == 1.0 or P[limb.MISS] > MOST_MISS * P[limb.FAR]:
        return 0.0
    return min(max(LEAST_WIDTH, WIDTH * P[limb.MISS] / P[limb.FAR]), MOST_WIDTH)


@kernel
def width_for_curves(P):
    """`in_line_width`, or for limbs without a surface how close to one line two pairs of outer axes have to come."""
    if P[limb.MISS] > MOST_MISS * P[limb.FAR]:
        return min(WIDTH_OF_CURVES * P[limb.MISS] / P[limb.FAR], MOST_WIDTH_OF_CURVES)
    return in_line_width(P)


@kernel
def level_place(place_):
    """A place with a flat elbow."""
    t, h0, c, _, hand, miss = place_
    return t, h0, math.copysign(1.0, c), 0.0, hand, miss


@kernel
def ways_of(part):
    """How many ways there are on a part of the surface."""
    return int(part[PART_EVERYWHERE] + part[PART_SHOULDER] + part[PART_WRIST])


@kernel
def put_parts_at(P, wide, side, at, parts, n):
    """Append the parts of the surface at an arm angle of a side of the elbow; their number.

    `at` holds the elbow's side, whether it is flat, the arm angle, whether all arm angles count, and how many of
    shoulder and wrist are free on a part that is wanted: at least and at most.
    """
    elbow, level, psi, everywhere, least, most = at
    width = wide[limb.SLACK_SINGULAR]
    for signs in range(4):
        q, _, _ = side_posture(wide, side, psi, signs >> 1, signs & 1, False, NO_SEED, False)
        free_s, free_w = is_free(P, limb.SHOULDER, q[1], width), is_free(P, limb.WRIST, q[5], width)
        # Where sums are free, the signs are no matter.
        known = (free_s and signs >> 1) or (free_w and signs & 1)
        if known or n >= parts.shape[0] or not least <= int(free_s) + int(free_w) <= most:
            continue
        part = row(parts, n)
        part[PART_ELBOW], part[PART_PSI], part[PART_SIGNS] = elbow, psi, signs
        part[PART_LEVEL] = 1.0 if level else 0.0
        part[PART_EVERYWHERE] = 1.0 if everywhere else 0.0
        part[PART_SHOULDER] = 1.0 if free_s else 0.0
        part[PART_WRIST] = 1.0 if free_w else 0.0
        if level or ways_of(part) > 1 or P[limb.MISS] < ROUNDED * P[limb.FAR]:
            n += 1
    return n


@kernel
def from_line(line, psi):
    """How far from one line outer axes are at an arm angle, squared; `line` is what `closest` says of them."""
    at, least, most = line
    turn = math.sin(0.5 * (psi - at))
    return least * least + (most * most - least * least) * turn * turn


@kernel
def where_equal(a, b):
    """The arm angle at which two pairs of outer axes are as far from one line each, as close as can be, if any."""
    half_a, half_b = 0.5 * (a[2] * a[2] - a[1] * a[1]), 0.5 * (b[2] * b[2] - b[1] * b[1])
    c = half_a * math.cos(a[0]) - half_b * math.cos(b[0])
    s = half_a * math.sin(a[0]) - half_b * math.sin(b[0])
    rest = half_a + a[1] * a[1] - half_b - b[1] * b[1]
    size = math.sqrt(c * c + s * s)
    if abs(rest) >= size:
        return 0.0, False
    middle, half = math.atan2(s, c), math.acos(rest / size)
    first, second = middle - half, middle + half
    return (first if from_line(a, first) < from_line(a, second) else second), True


@kernel
def put_midway(P, place_, near, angles, n):
    """Append arm angles at which shoulder or wrist come closest to singular, and midway between both; their number.

    Not singular, but within `aside` of it, rad, or between two that are closer together than `apart`, rad (`near` is
    both), the true chain may have closed curves of its own.
    """
    aside, apart = near
    width = width_for_curves(P)
    for elbow in range(2 if may_line_up(P, place_, aside) else 0):
        side = elbow_side(P, place_, elbow)
        for i in range(4):
            psi, off, _ = closest(P, limb.SHOULDER if i < 2 else limb.WRIST, side[1] if i < 2 else side[2], i & 1)
            if width <= off < aside and n < angles.shape[0]:
                angles[n] = psi
                n += 1
        for i in range(4):
            s, w = closest(P, limb.SHOULDER, side[1], i >> 1), closest(P, limb.WRIST, side[2], i & 1)
            ahead = short_way(w[0] - s[0])
            if max(s[1], w[1]) < width and abs(ahead) < apart and n < angles.shape[0]:
                angles[n] = s[0] + 0.5 * ahead
                n += 1
    return n


@kernel
def lines_up_with_shoulder(P, side, line, width):
    """Whether outer axes come within some width of one line where those of the shoulder are closest to theirs."""
    for end in range(2):
        s = closest(P, limb.SHOULDER, side[1], end)
        gap = P[limb.SHOULDER + (limb.BOTTOM_GAP if end else limb.TOP_GAP)]
        if gap < IN_LINE and s[1] < width and from_line(line, s[0]) < width * width:
            return True
    return False


@kernel
def put_parts(P, wide, place_, level, parts, n):
    """Append the parts of the surface with the elbow as it is, or flat; their number."""
    width = wide[limb.SLACK_SINGULAR]
    for elbow in range(1 if level or place_[3] == 0.0 else 2):
        side = elbow_side(P, place_, elbow)
        for i in range(4):
            k = limb.SHOULDER if i < 2 else limb.WRIST
            if P[k + (limb.TOP_GAP if i % 2 == 0 else limb.BOTTOM_GAP)] > IN_LINE:
                continue
            line = closest(P, k, side[1] if i < 2 else side[2], i % 2)
            if line[1] < width:
                # What is singular with the shoulder at its arm angle is known from there.
                most = 1 if i >= 2 and lines_up_with_shoulder(P, side, line, width) else 2
                n = put_parts_at(P, wide, side, (elbow, level, line[0], line[2] < width, 1, most), parts, n)
        for i in range(4):
            # Between the arm angles at which one and the other are closest to singular, both may be.
            s, w = closest(P, limb.SHOULDER, side[1], i >> 1), closest(P, limb.WRIST, side[2], i & 1)
            gaps = max(
                P[limb.SHOULDER + (limb.BOTTOM_GAP if i >> 1 else limb.TOP_GAP)],
                P[limb.WRIST + (limb.BOTTOM_GAP if i & 1 else limb.TOP_GAP)],
            )
            apart = min(from_line(s, w[0]), from_line(w, s[0])) > width * width
            if gaps > IN_LINE or not apart or max(s[1], w[1]) > width:
                continue
            psi, found = where_equal(s, w)
            if found and from_line(s, psi) < width * width:
                n = put_parts_at(P, wide, side, (elbow, level, psi, False, 2, 2), parts, n)
    return n


@kernel
def counts_as_flat(P, place_):
    """Whether the elbow of a limb with a surface may be flat at a pose."""
    return P[limb.MISS] <= MOST_MISS * P[limb.FAR] and is_flat(P, place_)


@kernel
def same_widths(P, place_, width):
    """The width for an elbow that is bent, and for one that may be flat: 0.0 where it may not."""
    return width, (width if counts_as_flat(P, place_) else 0.0)


@kernel
def widths_for_curves(P, place_):
    """`width_for_curves` with the elbow bent, and where it may be flat (0.0 where it may not).

    With a bend in place of a flat elbow, the upper arm is half of it off S-W, and outer axes closer to one line.
    """
    width = width_for_curves(P)
    flat = min(0.5 * flat_bend(P, place_), MOST_WIDTH_OF_CURVES)
    return width, (max(width, flat) if is_flat(P, place_) else 0.0)


@kernel
def may_have_surface(P, place_, widths):
    """Whether outer axes may come within some width of one line at a pose: a quick test, mostly false."""
    bent, flat = widths
    if bent == 0.0:
        return False
    return may_line_up(P, place_, bent) or (flat > 0.0 and may_line_up(P, level_place(place_), flat))


@kernel
def find_parts(P, wide, place_, widths, parts):
    """Write the parts of the surface of a pose into rows of parts; their number.

    `wide` is room for a limb, which takes axes that are within some width of one line for being in it. An elbow that
    may be flat is taken for flat, and if it is bent by more than the width for that, as it is, too.
    """
    wide_limb(P, wide)
    bent, flat = widths
    n = 0
    if flat > 0.0:
        wide[limb.SLACK_SINGULAR] = flat
        n = put_parts(P, wide, level_place(place_), True, parts, n)
    if flat == 0.0 or place_[3] > bent:
        wide[limb.SLACK_SINGULAR] = bent
        n = put_parts(P, wide, place_, False, parts, n)
    return n


@kernel
def posture_on(limbs, place_, part, i, goal):
    """Posture i of those that are spread over a part of the surface: by the goal where it leaves a choice.

    The second of two limbs takes axes almost in line so.
    """
    P, wide = limbs
    if part[PART_LEVEL] == 1.0:
        place_ = level_place(place_)
    side = elbow_side(P, place_, int(part[PART_ELBOW]))
    signs = int(part[PART_SIGNS])
    psi = part[PART_PSI]
    everywhere = part[PART_EVERYWHERE] == 1.0
    if everywhere:
        psi += 2.0 * math.pi * (i / FIRST if i < FIRST else (0.8191725134 * i) % 1.0)
    q, _, _ = side_posture(wide, side, psi, signs >> 1, signs & 1, goal.seeded, goal.seed, goal.respect)
    if i == 0 or (i < FIRST and everywhere):
        return q
    if part[PART_SHOULDER] == 1.0:
        q = split(P, limb.SHOULDER, q, 2.0 * math.pi * ((0.6710436067 * i) % 1.0))
    if part[PART_WRIST] == 1.0:
        q = split(P, limb.WRIST, q, 2.0 * math.pi * ((0.5497004779 * i) % 1.0))
    return q


@kernel
def has_surface(P, place_):
    """Whether several parts of a limb are singular at once, or so close to it that their curves connect anyhow."""
    widths = same_widths(P, place_, width_for_curves(P))
    if not may_have_surface(P, place_, widths):
        return False
    wide, parts = row(scratch(1, SIZE), 0), scratch(MOST_PARTS, PART)
    most = 0
    for i in range(find_parts(P, wide, place_, widths, parts)):
        most = max(most, ways_of(row(parts, i)))
    return most > 1


@kernel
def number_of_starts(part, ends):
    """From how many postures of a part curves are looked for; `ends` are the splits along which a flat elbow may bend.

    With a flat elbow, two curves come together all around, and one more way is enough to connect others.
    """
    signs, level = int(part[PART_SIGNS]), part[PART_LEVEL] == 1.0
    if level and part[PART_SHOULDER] + part[PART_WRIST] == 1.0:
        split_ = signs & 1 if part[PART_SHOULDER] == 1.0 else 2 + (signs >> 1)
        if (ends >> split_) & 1 == 0:
            return 0
    return STARTS if ways_of(part) > 1 else (STARTS_ONE if level else 0)


@kernel
def put_starts(P, place_, ends, starts, n):
    """Append postures of the surface, from which curves may be found; their number.

    `ends` are, as bits, the splits along which the elbow may become flat: of the shoulder, with either sign of the
    wrist, and of the wrist, with either sign of the shoulder.
    """
    widths = widths_for_curves(P, place_)
    if not may_have_surface(P, place_, widths):
        return n
    if place_[3] <= widths[0]:
        # The flat elbow stands for the bent one, too.
        ends = EVERY_SPLIT
    wide, parts = row(scratch(1, SIZE), 0), scratch(MOST_PARTS, PART)
    goal = Goal(False, NO_SEED, False)
    for k in range(find_parts(P, wide, place_, widths, parts)):
        part = row(parts, k)
        for i in range(number_of_starts(part, ends)):
            if n < starts.shape[0]:
                q = posture_on((P, wide), place_, part, i, goal)
                store7(row(starts, n), 0, q)
                n += 1
    return n
