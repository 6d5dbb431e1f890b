"""First derivatives of the arm angle by the joints, and of the joints by the arm angle while the tip stands still."""

import math

import numpy as np

from srs_ik.kernels.algebra.linear import solve_linear
from srs_ik.kernels.algebra.vectors import across, along, cross, dot, load3, norm, rotate, scale, sub
from srs_ik.kernels.chain.kinematics import joint_lines, point_velocity
from srs_ik.kernels.chain.newton import ON_LINE, elbow_position, load_system, longest, moved
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import limb as at
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.limb.self_motion import rates
from srs_ik.kernels.limb.triangle import REFERENCE_SINE, arm_frame, straight_offset

FASTEST = 1e9
"""Joint rates above this, rad/rad, belong to a posture at which the arm angle stands still."""


@kernel
def bend_rate(P, c, s, arm_h):
    """Rate at which the elbow's side of S-W turns about S-W in the upper arm's frame, by the elbow angle.

    c and s are cosine and sine of q4 - STRAIGHT. It is zero where the elbow's axis is across upper arm and forearm, and
    stays finite where the arm is straight.
    """
    kind = P[at.NORMAL_KIND]
    if kind == 0.0:
        return 0.0
    n_s = load3(P, at.NORMAL_S)
    n_c = load3(P, at.NORMAL_C)
    if kind == 1.0:
        # The normal is (1 + c) n_s + s n_c up to a factor, which vanishes where the arm is folded.
        half_c = math.sqrt(0.5 * (1.0 + c)) if c > -0.5 else 0.5 * abs(s) / math.sqrt(0.5 * (1.0 - c))
        half_s = 0.5 * s / half_c if c > -0.5 else math.copysign(math.sqrt(0.5 * (1.0 - c)), s)
        sign = 1.0 if s >= 0.0 else -1.0
        n = scale(sign, along(scale(half_c, n_s), half_s, n_c))
        slope = scale(sign, along(scale(-0.5 * half_s, n_s), 0.5 * half_c, n_c))
    else:
        n = along(along(load3(P, at.NORMAL_0), s, n_s), 1.0 - c, n_c)
        slope = along(scale(c, n_s), s, n_c)
    length = norm(n)
    return dot(arm_h, slope) / length if length > 0.0 else 0.0


@kernel
def gradient(P, q, J, g):
    """Write the seven derivatives of the arm angle into g; fills J with the joint lines at q.

    Returns the tip position, the direction S-W, and whether the derivatives exist: g is zero where the wrist is on the
    shoulder, where S-W is along the reference direction, and on a near limb where the elbow is on S-W.
    """
    x, y, z, p = joint_lines(P, q, J)
    for joint in range(7):
        g[joint] = 0.0
    inner = load3(P, at.WRIST_IN_TIP)
    wrist = along(along(along(p, inner[0], x), inner[1], y), inner[2], z)
    sw = sub(wrist, load3(P, at.SHOULDER_CENTRE))
    d = norm(sw)
    least = ON_LINE * P[at.FAR]
    t = scale(1.0 / max(d, least), sw)
    if d < least:
        return p, t, False
    reference = load3(P, at.REFERENCE)
    h0 = across(reference, t)
    sine = norm(h0)
    if sine < REFERENCE_SINE:
        return p, t, False
    # When S-W tilts, the zero direction turns about it.
    turn = scale(dot(t, reference) / (sine * sine * d), cross(t, h0))
    if P[at.IS_CLOSED] == 1.0:
        bend = straight_offset(P, q[3])
        c = math.cos(bend)
        s = math.sin(bend)
        _, arm_h, _ = arm_frame(P, c, s)
        for joint in range(3):
            g[joint] = dot((J[3, joint], J[4, joint], J[5, joint]), t) + dot(turn, point_velocity(J, joint, wrist))
        g[3] = bend_rate(P, c, s, arm_h) + dot(turn, point_velocity(J, 3, wrist))
        return p, t, True
    elbow = elbow_position(P, q)
    reach = sub(elbow, load3(P, at.SHOULDER_CENTRE))
    h = across(reach, t)
    r = norm(h)
    if r < least:
        return p, t, False
    b = scale(1.0 / (r * r), cross(t, h))
    turn = along(turn, -dot(t, reach) / d, b)
    for joint in range(7):
        g[joint] = dot(turn, point_velocity(J, joint, wrist))
        if joint < 3:
            g[joint] += dot(b, point_velocity(J, joint, elbow))
    return p, t, True


@kernel
def tangent(P, q):
    """dq/d(arm angle) with the tip at rest, and whether it exists.

    On an exact limb the arm turns about S-W, stiff in the elbow, also where that is straight. On a near limb they are
    the rates v with J v = 0 and an arm angle of rate 1, J being the Jacobian of the true chain.
    """
    J = np.empty((6, 7))
    g = np.empty(7)
    A = np.empty((7, 8))
    p, t, exists = gradient(P, q, J, g)
    if exists and P[at.IS_CLOSED] == 1.0:
        bend = straight_offset(P, q[3])
        arm_t, _, _ = arm_frame(P, math.cos(bend), math.sin(bend))
        from_forearm = rotate(load3(P, at.AXES + 9), math.cos(q[3]), -math.sin(q[3]), arm_t)
        v, exists = rates(P, q, t, from_forearm)
        return v if exists else NO_SEED, exists
    if exists:
        for joint in range(7):
            velocity = point_velocity(J, joint, p)
            for i in range(3):
                J[i, joint] = velocity[i]
        load_system(J, g, A)
        A[6, 7] = 1.0
        exists = solve_linear(A, 7) != 0.0 and longest(A) < FASTEST
    return moved(NO_SEED, A, 1.0) if exists else NO_SEED, exists
