"""The triangle shoulder-elbow-wrist: from a tip pose to the elbow angle, from the arm angle to the arm's rotation."""

import math

from srs_ik.kernels.algebra.vectors import (
    across,
    add,
    along,
    apply,
    apply_transposed,
    cross,
    dot,
    load3,
    load9,
    norm,
    rotate,
    scale,
    sub,
    times_transposed,
)
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import limb as at
from srs_ik.kernels.layout.asked import Target
from srs_ik.kernels.limb.poses import read_pose

REFERENCE_SINE = 1e-8
"""Below this sine between S-W and the reference direction, the second reference direction defines the arm angle."""

ROUNDING = 1e-14
"""Links whose sum leaves less than this along axis 4, in parts of the reach, lie in one plane across it."""


@kernel
def unit_across(a, u, spare):
    """Unit vector of the part of a across the unit vector u; of `spare`, or any, where that vanishes."""
    b = across(a, u)
    length = norm(b)
    size = norm(a)
    if length < REFERENCE_SINE * size or length == 0.0:
        size = 1.0
        b = across(spare, u)
        length = norm(b)
        if length < REFERENCE_SINE:
            b = across((1.0, 0.0, 0.0) if abs(u[0]) < 0.7 else (0.0, 1.0, 0.0), u)
            length = norm(b)
    b = scale(1.0 / length, b)
    if length > 0.1 * size:
        return b
    # Most of a is gone: what rounding left along u counts now.
    b = across(b, u)
    return scale(1.0 / norm(b), b)


@kernel
def shoulder_to_wrist(P, R, p):
    """Vector from the shoulder to the wrist centre for a tip pose (rotation R, position p)."""
    return sub(add(p, apply(R, load3(P, at.WRIST_IN_TIP))), load3(P, at.SHOULDER_CENTRE))


@kernel
def target_frame(P, sw):
    """Distance S-W, its direction t, and the direction h0 across it at which the arm angle is zero."""
    d = norm(sw)
    # A wrist on the shoulder leaves the direction open: take any, the same one always.
    t = scale(1.0 / d, sw) if d > 0.0 else load3(P, at.REFERENCE_2)
    return d, t, unit_across(load3(P, at.REFERENCE), t, load3(P, at.REFERENCE_2))


@kernel
def elbow_bend(P, d):
    """Cosine and sine of the bend |q4 - STRAIGHT| for a length d of S-W; how far d is out of reach (+far, -near)."""
    if d > P[at.FAR]:
        return 1.0, 0.0, d - P[at.FAR]
    if d < P[at.NEAR]:
        return -1.0, 0.0, d - P[at.NEAR]
    far = (P[at.FAR] - d) * (P[at.FAR] + d)
    near = (d - P[at.NEAR]) * (d + P[at.NEAR])
    share = 1.0 / (far + near)
    return (near - far) * share, 2.0 * math.sqrt(far * near) * share, 0.0


@kernel
def read_target(P, T):
    """A pose with what all its configurations share, which says nothing of what is no pose, and the verdict on it."""
    R, p, verdict = read_pose(T)
    return Target(R, p, place(P, R, p)), verdict


@kernel
def target_of(P, T):
    """A pose that is known to be a good one, with what all its configurations share."""
    return read_target(P, T)[0]


@kernel
def upper_arm_to_wrist(P, c, s):
    """S-W in the upper arm's frame; c and s are cosine and sine of q4 - STRAIGHT.

    Of two links of one length that are folded, c leaves nothing but rounding: 1 + c comes from s there.
    """
    a4 = load3(P, at.AXES + 9)
    upper, fore = load3(P, at.UPPER_ARM), load3(P, at.FOREARM)
    if c > -0.5:
        return add(upper, rotate(a4, c, s, fore))
    unfolded = along(scale(s * s / (1.0 - c), across(fore, a4)), s, cross(a4, fore))
    return add(add(upper, rotate(a4, -1.0, 0.0, fore)), unfolded)


@kernel
def arm_frame(P, c, s):
    """Directions in the upper arm's frame: S-W (t), the elbow across it (h), and h x t.

    c and s are cosine and sine of q4 - STRAIGHT. h is the side of S-W on which the elbow lies. Where the limb can be
    straightened so that S, E and W are collinear, the limit of h from the side of the sign of s is taken, be s zero or
    not: it stays well-defined when the elbow is on the line, and each elbow branch has its own.
    """
    a4 = load3(P, at.AXES + 9)
    w = upper_arm_to_wrist(P, c, s)
    kind = P[at.NORMAL_KIND]
    if kind == 0.0 and abs(dot(a4, add(load3(P, at.UPPER_ARM), load3(P, at.FOREARM)))) < ROUNDING * P[at.FAR]:
        # Next to S = W, what rounding leaves of w along axis 4 is as long as w is.
        w = across(w, a4)
    length = norm(w)
    t = scale(1.0 / length, w) if length > 0.0 else unit_across(cross(a4, load3(P, at.FOREARM)), a4, a4)
    if kind == 0.0:
        n = across(scale(math.copysign(1.0, s), load3(P, at.NORMAL_S)), t)
        return t, cross(t, n), n
    if kind == 1.0:
        half_c = math.sqrt(0.5 * (1.0 + c)) if c > -0.5 else 0.5 * abs(s) / math.sqrt(0.5 * (1.0 - c))
        half_s = 0.5 * s / half_c if c > -0.5 else math.copysign(math.sqrt(0.5 * (1.0 - c)), s)
        sign = math.copysign(1.0, s)
        n = add(scale(sign * half_c, load3(P, at.NORMAL_S)), scale(sign * half_s, load3(P, at.NORMAL_C)))
    else:
        n = along(along(load3(P, at.NORMAL_0), s, load3(P, at.NORMAL_S)), 1.0 - c, load3(P, at.NORMAL_C))
    n = unit_across(n, t, a4)
    return t, cross(t, n), n


@kernel
def hand_rotation(P, R):
    """Rotation of the hand from the zero configuration for a tip rotation R: R TIP_ROTATION'."""
    return times_transposed(R, load9(P, at.TIP_ROTATION))


@kernel
def turned_by_arm(frames, w):
    """Rs(psi) w as constant, cosine, sine part; Rs turns the upper arm, frames = (t, h0, b0, arm t, arm h, arm n)."""
    t, h0, b0, arm_t, arm_h, arm_n = frames
    x = dot(arm_t, w)
    y = dot(arm_h, w)
    z = dot(arm_n, w)
    return scale(x, t), along(scale(y, h0), -z, b0), along(scale(y, b0), z, h0)


@kernel
def turned_back_by_arm(frames, w):
    """Rs(psi)' w as constant, cosine and sine part: with the frames exchanged, the same."""
    t, h0, b0, arm_t, arm_h, arm_n = frames
    return turned_by_arm((arm_t, arm_h, arm_n, t, h0, b0), w)


@kernel
def shoulder_motion(P, frames):
    """What the shoulder has to make: R a3, R ACROSS_3, R'a1 of its rotation R(psi), three circles of three vectors."""
    v = turned_by_arm(frames, load3(P, at.SHOULDER + at.A3))
    y = turned_by_arm(frames, load3(P, at.SHOULDER + at.ACROSS_3))
    r = turned_back_by_arm(frames, load3(P, at.SHOULDER + at.A1))
    return v, y, r


@kernel
def wrist_motion(P, frames, c4, s4, hand):
    """The same for the wrist, whose rotation is (Rs rot(a4, q4))' hand."""
    a4 = load3(P, at.AXES + 9)
    v = turned_back_by_arm(frames, apply(hand, load3(P, at.WRIST + at.A3)))
    y = turned_back_by_arm(frames, apply(hand, load3(P, at.WRIST + at.ACROSS_3)))
    r = turned_by_arm(frames, rotate(a4, c4, s4, load3(P, at.WRIST + at.A1)))
    return (
        (rotate(a4, c4, -s4, v[0]), rotate(a4, c4, -s4, v[1]), rotate(a4, c4, -s4, v[2])),
        (rotate(a4, c4, -s4, y[0]), rotate(a4, c4, -s4, y[1]), rotate(a4, c4, -s4, y[2])),
        (apply_transposed(hand, r[0]), apply_transposed(hand, r[1]), apply_transposed(hand, r[2])),
    )


@kernel
def place(P, R, p):
    """What postures of a pose share: S-W direction, arm-angle zero, elbow bend, hand rotation, miss of the reach."""
    d, t, h0 = target_frame(P, shoulder_to_wrist(P, R, p))
    c, s, miss = elbow_bend(P, d)
    return t, h0, c, s, hand_rotation(P, R), miss


@kernel
def elbow_at(P, place_, elbow):
    """The arm in elbow branch 0 or 1: cosine and sine of q4, and `arm_frame`."""
    c = place_[2]
    s = -place_[3] if elbow == 1 else place_[3]
    c4 = P[at.COS_STRAIGHT] * c - P[at.SIN_STRAIGHT] * s
    s4 = P[at.SIN_STRAIGHT] * c + P[at.COS_STRAIGHT] * s
    return c4, s4, arm_frame(P, c, s)


@kernel
def frame_at(place_, cos_psi, sin_psi):
    """The frame of `arm_frame` in the base frame, at an arm angle: S-W, the elbow across it, their normal."""
    t = place_[0]
    h = along(scale(cos_psi, place_[1]), sin_psi, cross(t, place_[1]))
    return t, h, cross(h, t)


@kernel
def elbow_side(P, place_, elbow):
    """Elbow branch 0 or 1: q4, the motions of shoulder and wrist with the arm angle, S-W seen from the forearm."""
    t, h0, _, _, hand, _ = place_
    c4, s4, (arm_t, arm_h, arm_n) = elbow_at(P, place_, elbow)
    frames = (t, h0, cross(t, h0), arm_t, arm_h, arm_n)
    from_forearm = rotate(load3(P, at.AXES + 9), c4, -s4, arm_t)
    return math.atan2(s4, c4), shoulder_motion(P, frames), wrist_motion(P, frames, c4, s4, hand), from_forearm


@kernel
def side_frames(P, place_, elbow, cos_psi, sin_psi):
    """Elbow branch 0 or 1 at one arm angle: `frame_at`, `arm_frame`, and cosine and sine of q4."""
    c4, s4, arm = elbow_at(P, place_, elbow)
    return frame_at(place_, cos_psi, sin_psi), arm, c4, s4


@kernel
def shoulder_columns(P, base, arm):
    """What R a3 and R ACROSS_3 have to be for the shoulder, which takes the frame of the arm to that of the base."""
    return turned_frame(base, arm, load3(P, at.SHOULDER + at.A3)), turned_frame(
        base, arm, load3(P, at.SHOULDER + at.ACROSS_3)
    )


@kernel
def wrist_columns(P, place_, base, arm, c4, s4):
    """The same for the wrist, which is left of the hand's rotation when shoulder and elbow are taken back."""
    hand = place_[4]
    a4 = load3(P, at.AXES + 9)
    v = turned_frame(arm, base, apply(hand, load3(P, at.WRIST + at.A3)))
    y = turned_frame(arm, base, apply(hand, load3(P, at.WRIST + at.ACROSS_3)))
    return rotate(a4, c4, -s4, v), rotate(a4, c4, -s4, y)


@kernel
def turned_frame(to, source, w):
    """A vector turned as the orthonormal frame `source` is turned into `to`."""
    return along(along(scale(dot(source[0], w), to[0]), dot(source[1], w), to[1]), dot(source[2], w), to[2])


@kernel
def straight_offset(P, q4):
    """q4 - STRAIGHT, never -0.0: the angle of a flat elbow does not say on which side it is; it counts as the first."""
    return (q4 - P[at.STRAIGHT]) + 0.0


@kernel
def arm_angle_of_direction(t, h0, h):
    """Arm angle of a direction h across t: right-handed about t, zero at h0."""
    return math.atan2(dot(h, cross(t, h0)), dot(h, h0))
