"""The equations of a pose up to what that leaves free, to first order, and how they bend: what a step has to meet.

A cone is an inequality, and an equation where its axis is at its edge and presses on that.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.lanes import as_mask, gather, scatter, where
from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.algebra.vectors import add, along, apply, cross, dot, norm, scale, sub
from srs_ik.kernels.chain.freedom import any_across, lean, pointing
from srs_ik.kernels.chain.kinematics import joint_lines
from srs_ik.kernels.freedom.elimination import RHS
from srs_ik.kernels.jit import kernel

THIN = 3e-4
"""In a cone up to this, rad, the axis is as good as fixed: it is told where to point, which is where it presses."""

SOFTEST = 30.0
"""Where the axis of a thin cone presses by less than so many times the cone, it may rest inside."""

NONE = (0.0, 0.0, 0.0)


@kernel
def rows_of(J, first):
    """Three rows of J, all joints at once; the eighth figure of each is the first of the next row."""
    lines = row(J, first)
    return gather(lines, 0, 1), gather(lines, 7, 1), gather(lines, 14, 1)


@kernel
def axis_of(J, j):
    """Direction of a joint."""
    return (J[3, j], J[4, j], J[5, j])


@kernel
def within_thin(cone, a, b, turn, forces):
    """A turn that brings an axis into a thin cone, and there to where it presses: its parts about a and b."""
    x, y = forces[3] / SOFTEST - dot(a, turn), forces[4] / SOFTEST - dot(b, turn)
    far = math.sqrt(x * x + y * y)
    share = cone / far if far > cone else 1.0
    return dot(a, turn) + share * x, dot(b, turn) + share * y


@kernel
def equations(P, q, pose, freedom, forces, desk):
    """Fill J with the Jacobian of the tip, and rows 7 on of the system with the equations of the pose.

    The multipliers of the last step, `forces`, tell where the axis of a thin cone is to point.

    Returns:
        Their number; the error of the pose; the direction to which the axis should come, where it points, and the
        rows of turns: two directions across it, or the one in which the cone is left and nothing.
    """
    R, p = pose
    J, K = desk.J, desk.system
    x, y, z, position = joint_lines(P, q, J)
    moments, axes = rows_of(J, 0), rows_of(J, 3)
    velocities = add(moments, cross(axes, position))
    miss = sub(p, position)
    u, t = pointing(freedom.axis, x, y, z), apply(R, freedom.axis)
    n, turn = lean(u, t)
    angle = max(turn - freedom.cone, 0.0)
    # The eighth figure of the last row is the first of the axes.
    last = where(as_mask(0b1111111), velocities[2], moments[2])
    for i in range(3):
        scatter(row(K, 7 + i), 0, 1, velocities[i])
        scatter(row(J, 0), 7 * i, 1, velocities[i] if i < 2 else last)
        K[7 + i, RHS] = miss[i]
    error = max(norm(miss), angle)
    if freedom.cone >= math.pi:
        return 3, error, (t, u, NONE, NONE)
    if freedom.cone > THIN:
        write_turn(axes, K, 10, n, turn - freedom.cone)
        return (3 if turn < freedom.cone else 4), error, (t, u, n, NONE)
    a = any_across(u)
    b = cross(u, a)
    about_a, about_b = within_thin(freedom.cone, a, b, scale(turn, n), forces)
    write_turn(axes, K, 10, a, about_a)
    write_turn(axes, K, 11, b, about_b)
    return 5, error, (t, u, a, b)


@kernel
def write_turn(axes, K, r, n, rest):
    """Write the equation of a turn about a direction into row r."""
    scatter(row(K, r), 0, 1, dot(axes, n))
    K[r, RHS] = rest


@kernel
def bends(m, forces, turns, cone):
    """What multiplies second derivatives of the tip point and of its axis, from the multipliers of the last step."""
    t, u, a, b = turns
    point = (forces[0], forces[1], forces[2])
    if m == 3:
        return point, NONE, u
    if m == 4:
        return point, scale(forces[3] / math.sin(cone), t), u
    return point, cross(along(scale(forces[3], a), forces[4], b), t), u


@kernel
def fill(J, K, q, liking, bend, shares):
    """Write second derivatives of the Lagrangian into rows 0 to 6 of the system, and the slope of the distance.

    The bends of the equations, those of the distance, and its slope count by a share each.
    """
    share, plain, pull = shares
    point, axis, u = bend
    velocities, turns = rows_of(J, 0), cross(rows_of(J, 3), u)
    for i in range(7):
        z = axis_of(J, i)
        along_point, along_axis = scale(share, cross(point, z)), scale(share, cross(axis, z))
        # Right for joints from this one on; those before it have written what is right for them.
        scatter(row(K, i), 0, 1, dot(velocities, along_point) + dot(turns, along_axis))
        for j in range(i):
            K[i, j] = K[j, i]
        K[i, i] += plain * liking.weights[i]
        K[i, RHS] = -pull * liking.weights[i] * (q[i] - liking.posture[i])


@kernel
def on_edge(m, known, forces):
    """The number of equations: one more with the axis held at the edge of its cone, as long as it presses on that.

    Else steps would lead to and fro across the edge, or end there where the axis wants in.
    """
    return m if known != 4 else 4 if forces[3] < 0.0 else 3


@kernel
def leaves_cone(K, freedom, step):
    """Whether a step would take the axis out of its cone."""
    if not 0.0 < freedom.cone < math.pi:
        return False
    inward = 0.0
    for j in range(7):
        inward += K[10, j] * step[j]
    return inward < K[10, RHS]


@kernel
def price(forces):
    """What an error of the pose counts, against distance: more than can be gained by it."""
    point = forces[0] * forces[0] + forces[1] * forces[1] + forces[2] * forces[2]
    return 1.1 * (math.sqrt(point) + math.sqrt(forces[3] * forces[3] + forces[4] * forces[4]))
