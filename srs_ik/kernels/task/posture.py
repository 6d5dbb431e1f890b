"""The posture that a task asks for, in closed form.

It is that of Tiseo, Charitos and Mistry, eqs. WristPosition, geomOptim (with a grasp) and geomOptimB (without). The
plane of shoulder, elbow and wrist contains the line to the target and lies as nearly as it can in the plane of the
task, which velocity v and force f span. That leaves two elbows, one on each side of the line; the side of the body
chooses, or gravity where neither is to the left of the other.

Where the printed equations do not compute, these do (errata 1, 2, 7, 9 and 10): the radius of the elbow's circle is
sqrt(l_a^2 - a^2), the two cases of the sign are joined by "or", without a grasp the elbow's foot lies on the line to
the target, an arm with a grasp stretches towards its wrist, and where directions are parallel or a target is too near,
there is a rule.
"""

import math

from srs_ik.kernels.algebra.vectors import add, along, cross, dot, load3, norm, scale, store3, sub
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import task as at
from srs_ik.kernels.layout.limb import REFERENCE_2, SHOULDER_CENTRE
from srs_ik.kernels.limb.triangle import arm_angle_of_direction, target_frame, unit_across

PARALLEL = 1e-8
"""Directions at a smaller sine than this leave the plane between them undefined."""

LEVEL = 1e-9
"""An elbow direction with a smaller component than this lies to neither side."""

AT_SHOULDER = 1e-12
"""A target this near to the shoulder, metres, gives no direction."""


@kernel
def unit(a):
    """A vector at unit length, however long or short it is; zero stays zero."""
    largest = max(abs(a[0]), abs(a[1]), abs(a[2]))
    if largest == 0.0:
        return a
    b = (a[0] / largest, a[1] / largest, a[2] / largest)
    return scale(1.0 / norm(b), b)


@kernel
def read_task(raw, given, out):
    """Write a task row with directions of unit length; return what is wrong with it, or 0."""
    for i in range(at.TASK):
        if not math.isfinite(raw[i]):
            return at.NOT_FINITE
    store3(out, 0, load3(raw, 0))
    for k in range(1, 5):
        v = unit(load3(raw, 3 * k))
        asked = k < 3 or (k == 3 and given & at.GRASP != 0) or (k == 4 and given & at.PRONOSUPINATION != 0)
        if asked and v == (0.0, 0.0, 0.0):
            return at.NO_DIRECTION
        store3(out, 3 * k, v)
    if given == at.GRASP | at.PRONOSUPINATION:
        if norm(cross(load3(out, at.TASK_GRASP), load3(out, at.TASK_PRONOSUPINATION))) < PARALLEL:
            return at.ROLL_OPEN
    return 0


@kernel
def task_normal(v, f):
    """Unit normal of the task's plane; where v and f are parallel, of the vertical plane through v, or the x-z plane.

    The paper takes any vector orthogonal to v in place of such a force; no choice is continuous in v and f there.
    """
    n = cross(v, f)
    length = norm(n)
    if length < PARALLEL:
        n = cross(v, (0.0, 0.0, 1.0))
        length = norm(n)
        if length < PARALLEL:
            return (0.0, 1.0, 0.0)
    return scale(1.0 / length, n)


@kernel
def elbow_direction(t, n, side, tie):
    """Unit vector across t on which the elbow lies: in the plane whose normal is as near to n as t allows.

    side is 1.0 for the left arm (elbow towards +y) and -1.0 for the right. Where the elbow is to neither side, tie is
    -1.0 for the lower and 1.0 for the upper one, and where those are level too, for that towards -x and +x. Where t is
    along n every plane is as good, and the elbow lies as far to its side as it can.
    """
    h = cross(t, n)
    length = norm(h)
    h = unit_across((0.0, 1.0, 0.0), t, (0.0, 0.0, 1.0)) if length < PARALLEL else scale(1.0 / length, h)
    towards = side * h[1]
    if abs(h[1]) <= LEVEL:
        towards = tie * (h[2] if abs(h[2]) > LEVEL else h[0])
    return h if towards >= 0.0 else scale(-1.0, h)


@kernel
def elbow_foot(upper, lower, d):
    """Triangle with sides `upper` and `lower` on a base d: how far along the base its apex lies, and how far across."""
    if d < AT_SHOULDER:
        return 0.0, upper
    shortest = upper - lower
    longest = upper + lower
    foot = 0.5 * (d + shortest * longest / d)
    # Heron's form keeps the digits of a flat triangle's height.
    shape = (longest - d) * (longest + d) * (d - shortest) * (d + shortest)
    return min(max(foot, -upper), upper), 0.5 * math.sqrt(max(shape, 0.0)) / d


@kernel
def tip_axes(grasp, across):
    """Rotation matrix, row-major, whose columns are a direction, the part of another one across it, and their product.

    Both have unit length; the second must not be parallel to the first.
    """
    y = along(across, -dot(grasp, across), grasp)
    y = scale(1.0 / norm(y), y)
    z = cross(grasp, y)
    return (grasp[0], y[0], z[0], grasp[1], y[1], z[1], grasp[2], y[2], z[2])


@kernel
def wrist_from_tip(H, g, phi, rolled):
    """Vector from the tip to the wrist centre, for a grasp direction and, if the hand is `rolled`, a pronosupination.

    It is exact where the roll of the hand is known, or where the tip lies on the line through the wrist along the grasp
    direction; else the part along that direction counts.
    """
    if rolled and H[at.HAND_KNOWN] == 1.0:
        axes = tip_axes(g, phi)
        y, z = (axes[1], axes[4], axes[7]), (axes[2], axes[5], axes[8])
        w, a, b = load3(H, at.HAND_WRIST), load3(H, at.HAND_GRASP), load3(H, at.HAND_ACROSS)
        return along(along(scale(dot(w, a), g), dot(w, b), y), dot(w, cross(a, b)), z)
    return scale(-H[at.HAND_ALONG], g)


@kernel
def lengths_of(H, grasped):
    """Lengths of the nearest exact limb: upper arm, forearm, shortest and longest distance of what has to reach."""
    if grasped:
        return H[at.HAND_UPPER_ARM], H[at.HAND_FOREARM], H[at.HAND_NEAR], H[at.HAND_FAR]
    return H[at.HAND_UPPER_ARM], H[at.HAND_FOREARM], H[at.HAND_TIP_NEAR], H[at.HAND_TIP_FAR]


@kernel
def plan(P, H, x, grasped, phi, rolled, side, tie, lengths):
    """The posture of a task: elbow, wrist and tip from the shoulder, arm normal, task normal, hand direction, miss.

    grasped and rolled say whether the grasp direction of the task row x and the pronosupination phi count; lengths are
    as in `lengths_of`. The arm's normal m is signed such that the elbow lies towards m x t from any line t in its plane
    on which it is seen from the shoulder.
    """
    n = task_normal(load3(x, at.TASK_VELOCITY), load3(x, at.TASK_FORCE))
    target = sub(load3(x, at.TASK_POSITION), load3(P, SHOULDER_CENTRE))
    upper, forearm, near, far = lengths
    lower = forearm
    to_wrist = (0.0, 0.0, 0.0)
    if grasped:
        to_wrist = wrist_from_tip(H, load3(x, at.TASK_GRASP), phi, rolled)
        target = add(target, to_wrist)
    else:
        lower += H[at.HAND_LENGTH]
    d = norm(target)
    t = load3(P, REFERENCE_2) if d < AT_SHOULDER else unit(target)
    h = elbow_direction(t, n, side, tie)
    reached = min(max(d, near), far)
    foot, across = elbow_foot(upper, lower, reached)
    elbow = along(scale(foot, t), across, h)
    end = scale(reached, t)
    if grasped:
        return elbow, end, sub(end, to_wrist), cross(t, h), n, load3(x, at.TASK_GRASP), d - reached
    direction = scale(1.0 / lower, sub(end, elbow))
    return elbow, along(elbow, forearm, direction), end, cross(t, h), n, direction, d - reached


@kernel
def plan_given(P, H, x, given, side, tie):
    """The posture of a task row, by what it gives."""
    grasped = given & at.GRASP != 0
    phi = load3(x, at.TASK_PRONOSUPINATION)
    return plan(P, H, x, grasped, phi, given & at.PRONOSUPINATION != 0, side, tie, lengths_of(H, grasped))


@kernel
def planned_arm_angle(t, h0, m):
    """Arm angle, on the line S-W with direction t and zero direction h0, of the plane with signed normal m."""
    return arm_angle_of_direction(t, h0, cross(m, t))


@kernel
def write_posture(P, found, out):
    """Write a posture, its points from the base."""
    elbow, wrist, tip, m, n, direction, miss = found
    S = load3(P, SHOULDER_CENTRE)
    normal = m if dot(m, n) >= 0.0 else scale(-1.0, m)
    _, t, h0 = target_frame(P, wrist)
    store3(out, at.ELBOW, add(S, elbow))
    store3(out, at.WRIST, add(S, wrist))
    store3(out, at.TIP, add(S, tip))
    store3(out, at.NORMAL, normal)
    store3(out, at.TASK_NORMAL, n)
    store3(out, at.DIRECTION, direction)
    out[at.ARM_ANGLE] = planned_arm_angle(t, h0, m)
    out[at.MISS] = miss
