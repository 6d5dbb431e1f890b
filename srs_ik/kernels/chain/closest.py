"""The configuration closest to a pose that limits and reach together forbid: the least of one smooth measure.

The measure is the square of the distance in parts of the arm's reach, plus that of the angle, the latter as 2 - 2 cos.
From many starts, Newton's method with the true second derivatives, on the limits where they hold, finds the bottoms of
valleys. Along a single joint the measure is a cosine, whose least value between two limits is known: every other start
is taken there joint by joint first, which saves steps, but never leads into some valleys.
Where limits leave room to stretch, lengths weigh so little that the rotation is kept (`closer_upright`, `put_upright`).
"""

import math

from srs_ik.kernels.algebra.joint_vectors import with_joint
from srs_ik.kernels.algebra.linear import solve_downhill, solve_linear
from srs_ik.kernels.algebra.vectors import apply, cross, dot, norm, scale, sub, times_transposed
from srs_ik.kernels.chain.kinematics import joint_lines, point_velocity
from srs_ik.kernels.chain.newton import clipped
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import FAR, LOWER, UPPER

STARTS = 160
STEPS = 150
FLAT = 1e-11
"""Slope of the measure, per radian, at the bottom of a valley."""

FULL = 1e-6
"""Damping below which a step counts as a full one."""

ROUNDING = 1e-15
"""What the measure does not tell: a full step that promises less, and gains nothing, is the last."""

LEANING, UPRIGHT, EXACT = 0.03, 1e-3, 1e-5
"""Weights of lengths where the tip's rotation is kept: it gives up their square of the distance, in reaches and rad.

One after the other, since along a narrow valley Newton's steps are short.
"""

ALIKE = 5e-5
"""A posture next to a seed is taken that comes as close as the closest but for this, in reaches and rad."""

GENTLE = 1e-8
UPRIGHT_STEPS = 4
"""Damping of the last steps, which only turn the tip: more than lengths of the last weight curve the measure. Most
postures need one of them, those in a curved valley or on a limit more."""

TOO_FAR = 1e6
"""A pose this many times the reach away is as well answered by any stretched arm."""

STRIDE = (0.8866, 0.7861, 0.6970, 0.6180, 0.5479, 0.4858, 0.4307)
"""Strides, in ranges of the joints, from a start to the next one: they fill the box evenly."""


@kernel
def surroundings(P, q, target, weight, J):
    """What the measure needs at q: M (from the wanted frame to the tip's), e (way to the pose, in reaches), measure.

    `weight` is that of lengths. J gets the velocities of the tip point, so weighed, in rows 0 to 2, and the joint axes
    in rows 3 to 5.
    """
    R, p, _ = target
    x, y, z, position = joint_lines(P, q, J)
    unit = weight / P[FAR]
    for j in range(7):
        v = point_velocity(J, j, position)
        for i in range(3):
            J[i, j] = unit * v[i]
    M = times_transposed((x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]), R)
    e = scale(unit, sub(p, position))
    return M, e, dot(e, e) + 3.0 - (M[0] + M[4] + M[8])


@kernel
def second(M, e, J, i, j):
    """Second derivative of the measure by joints i and j, i the nearer to the base (or the same)."""
    a, b = (J[3, i], J[4, i], J[5, i]), (J[3, j], J[4, j], J[5, j])
    v, w = (J[0, i], J[1, i], J[2, i]), (J[0, j], J[1, j], J[2, j])
    trace = M[0] + M[4] + M[8]
    return 2.0 * (dot(v, w) - dot(e, cross(a, w))) + dot(a, b) * trace - dot(a, apply(M, b))


@kernel
def first(M, e, J, j):
    """Derivative of the measure by joint j."""
    skew = (M[7] - M[5], M[2] - M[6], M[3] - M[1])
    return dot((J[3, j], J[4, j], J[5, j]), skew) - 2.0 * dot(e, (J[0, j], J[1, j], J[2, j]))


@kernel
def bottom_of_joint(slope, curvature, angle, low, high):
    """The angle between two limits where a cosine, known by its derivatives at an angle, is least."""
    best = angle + math.atan2(-slope, curvature)
    turn = 2.0 * math.pi
    if best < low:
        best += turn * math.ceil((low - best) / turn)
    if best > high:
        best -= turn * math.ceil((best - high) / turn)
    if best >= low:
        return best
    # The bottom is outside: the end that is nearer to it around the circle.
    return low if low - best < best + turn - high else high


@kernel
def joint_by_joint(P, q, target, J):
    """Each joint in turn to its best angle."""
    for j in range(7):
        M, e, _ = surroundings(P, q, target, 1.0, J)
        angle = bottom_of_joint(first(M, e, J, j), second(M, e, J, j, j), q[j], P[LOWER + j], P[UPPER + j])
        q = with_joint(q, j, angle)
    return q


@kernel
def newton_step(P, q, local, J, damping, downhill, A):
    """A damped Newton step inside the limits, joints at a limit that they would pass held.

    Where the measure curves downwards, Newton's step leads to where its slope is nothing, be that a saddle or a top;
    if it is to lead `downhill`, it turns around there.

    Returns: where it leads, the largest slope, by how much the slopes alone lower the measure on the way, and whether
    the measure curves upwards all around.
    """
    M, e = local
    held = 0
    slope = gain = 0.0
    slopes = q
    for j in range(7):
        g = first(M, e, J, j)
        slopes = with_joint(slopes, j, g)
        if (g > 0.0 and q[j] <= P[LOWER + j]) or (g < 0.0 and q[j] >= P[UPPER + j]):
            held |= 1 << j
        else:
            slope = max(slope, abs(g))
    for i in range(7):
        still = (held >> i) & 1 == 1
        for j in range(i, 7):
            apart = still or (held >> j) & 1 == 1
            A[i, j] = A[j, i] = 0.0 if apart else second(M, e, J, i, j)
        A[i, i] += 1.0 if still else damping
        A[i, 7] = 0.0 if still else -slopes[i]
    upwards = solve_downhill(A) if downhill else solve_linear(A, 7) > 0.0
    for j in range(7):
        step = min(max(A[j, 7], -0.5), 0.5)
        there = min(max(q[j] + step, P[LOWER + j]), P[UPPER + j])
        gain -= slopes[j] * (there - q[j])
        q = with_joint(q, j, there)
    return q, slope, gain, upwards


@kernel
def to_bottom(P, q, target, weight, lowest, J, A):
    """From a configuration to the bottom of its valley: the configuration and its measure.

    A valley whose bottom stays above a measure that is known is left on the way: at full steps, of which a parabola
    gains half of what its slope says, twice the slope's gain is not enough. Where the measure curves downwards, or
    limits turn the step away from its slope, that tells nothing.
    """
    damping = FULL
    M, e, value = surroundings(P, q, target, weight, J)
    for _ in range(STEPS):
        there, slope, gain, upwards = newton_step(P, q, (M, e), J, damping, True, A)
        if slope < FLAT * weight or (upwards and damping < FULL and 0.0 < 2.0 * gain < value - lowest):
            break
        M_there, e_there, lower = surroundings(P, there, target, weight, J)
        if lower < value:
            q, M, e, value = there, M_there, e_there, lower
            damping = max(0.1 * damping, 1e-12)
        elif damping > 1e3 or (upwards and damping < FULL and abs(gain) < ROUNDING):
            break
        else:
            damping = max(8.0 * damping, 0.1 * weight)
            surroundings(P, q, target, weight, J)
    return q, value


@kernel
def start(P, q, number):
    """A start: the configuration itself, or one of those that strides through the box of the limits lead to."""
    if number == 0:
        return q
    for j in range(7):
        low, high = P[LOWER + j], P[UPPER + j]
        if not (math.isfinite(low) and math.isfinite(high)):
            low, high = q[j] - math.pi, q[j] + math.pi
        part = number * STRIDE[j] + 0.5
        q = with_joint(q, j, low + (high - low) * (part - math.floor(part)))
    return q


@kernel
def is_too_far(P, q, target, J):
    """Whether any stretched arm answers a pose as well as another."""
    _, e, _ = surroundings(P, q, target, 1.0, J)
    return not max(abs(e[0]), abs(e[1]), abs(e[2])) < TOO_FAR


@kernel
def is_closer(P, q, other, target, J):
    """Whether a configuration is closer to a pose than another one."""
    _, _, value = surroundings(P, q, target, 1.0, J)
    _, _, known = surroundings(P, other, target, 1.0, J)
    return value < known


@kernel
def is_alike(value, lowest, weight):
    """Whether a posture of some measure comes as close to a pose as the closest of all, with lengths weighed."""
    return math.sqrt(value) < math.sqrt(lowest) + ALIKE * weight


@kernel
def closest(P, q, target, goal, J, A):
    """The configuration inside the limits that is closest to a pose, or q, which is inside, where none is closer.

    With a seed, the one in its valley where that comes as close.
    """
    if is_too_far(P, q, target, J):
        return q
    best, lowest = q, math.inf
    for i in range(STARTS):
        x = start(P, q, i)
        if i & 1 == 0:
            x = joint_by_joint(P, x, target, J)
        x, value = to_bottom(P, x, target, 1.0, lowest, J, A)
        if value < lowest:
            best, lowest = x, value
    if goal.seeded:
        x, value = to_bottom(P, clipped(P, goal.seed), target, 1.0, math.inf, J, A)
        if is_alike(value, lowest, 1.0):
            return x
    return best


@kernel
def closer_upright(P, q, known, target, J, A):
    """A configuration and its measure, or the bottom of the valley of q if that is lower, with the rotation of a pose.

    As an exact arm stretches itself towards a pose out of reach; the offsets of a near one let it come closer bent.
    """
    x, _ = to_bottom(P, q, target, LEANING, math.inf, J, A)
    x, value = to_bottom(P, x, target, UPRIGHT, known[1], J, A)
    if value < known[1]:
        return x, value
    return known


@kernel
def put_upright(P, q, target, J, A):
    """The closest configuration next to one with the rotation of a pose, but for 1e-10 rad however far it is."""
    _, e, _ = surroundings(P, q, target, 1.0, J)
    weight = EXACT / math.sqrt(max(1.0, norm(e)))
    # The measure does not tell turns below 1e-8 rad, nor whether it curves; its slopes tell them.
    best, least = q, math.inf
    for _ in range(UPRIGHT_STEPS + 1):
        M, e, _ = surroundings(P, q, target, weight, J)
        there, slope, _, _ = newton_step(P, q, (M, e), J, GENTLE, False, A)
        if slope > least:
            break
        best, least = q, slope
        if slope < 10.0 * FLAT:
            break
        q = there
    return best
