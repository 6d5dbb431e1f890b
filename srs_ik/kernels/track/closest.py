"""Steps of a posture towards a pose inside bounds: the shortest ones, or the closest where the pose cannot be met.

Turning by a radian counts as much as moving by a *lever*: that of `chain.closest` is the reach of the arm.
"""

from srs_ik.kernels.algebra.joint_vectors import along7, between
from srs_ik.kernels.algebra.linear import solve_linear
from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.algebra.vectors import across, dot, norm, scale
from srs_ik.kernels.chain.freedom import read_freedom, turn_left
from srs_ik.kernels.chain.kinematics import forward_kinematics
from srs_ik.kernels.chain.newton import pose_step
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.limb import FAR
from srs_ik.kernels.layout.track import FREE, HAS_FREE, SPEED
from srs_ik.kernels.limb.goal import NO_SEED

DAMPING = 1e-9
"""Weight of the length of a step, m^2: it decides between steps that serve the pose equally."""

ENOUGH = 1e-11
"""A pose this close is met, m and, by the reach, rad."""

ROUNDS = 20
"""Joints are held on their bounds, and set free again, one after the other, at most so often."""

ROUNDING = 1e-15
"""What draws a joint from its bound, m^2/rad, by more than rounding."""


@kernel
def error_at(P, C, q, pose, lever, J):
    """Fill J (6, 7) with the Jacobian of the tip, turns by the lever: the way to the pose, and its size by the reach.

    What the target leaves free is no way, and no motion of the joints leads along it. A cone counts here: the axis of
    the pose is its middle.
    """
    R, p = pose
    linear, angular = pose_step(P, q, R, p, J)
    if C[HAS_FREE] == 1.0:
        angular = leave_free(P, C, q, R, J)
    for i in range(3, 6):
        for j in range(7):
            J[i, j] *= lever
    turn = scale(lever, angular)
    return (linear[0], linear[1], linear[2], turn[0], turn[1], turn[2]), max(norm(linear), P[FAR] * norm(angular))


@kernel
def leave_free(P, C, q, R, J):
    """The turn that is left to a pose that leaves some free; takes the rest out of the last rows of J."""
    freedom = read_freedom(row(C, FREE))
    x, y, z, _ = forward_kinematics(P, q)
    n, angle, u = turn_left(freedom, (x, y, z), R)
    for j in range(7):
        w = (J[3, j], J[4, j], J[5, j])
        w = across(w, u) if freedom.cone == 0.0 else scale(dot(n, w) if angle > 0.0 else 0.0, n)
        for i in range(3):
            J[3 + i, j] = w[i]
    return scale(angle, n)


@kernel
def column(J, j):
    """A column of J (6, 7)."""
    return (J[0, j], J[1, j], J[2, j], J[3, j], J[4, j], J[5, j])


@kernel
def dot6(a, b):
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5]


@kernel
def less(e, f, a):
    """The vector e - f a."""
    return (e[0] - f * a[0], e[1] - f * a[1], e[2] - f * a[2], e[3] - f * a[3], e[4] - f * a[4], e[5] - f * a[5])


@kernel
def fill(C, J, e, wish, held, d, A):
    """Write the normal equations of a step into A (16, 9), joints in the bit set `held` kept at their steps d."""
    liked, damping, care = wish
    rest = e
    for j in range(7):
        if (held >> j) & 1 == 1:
            rest = less(rest, d[j], column(J, j))
    for i in range(7):
        a = column(J, i)
        if (held >> i) & 1 == 1:
            for j in range(8):
                A[i, j] = 0.0
            A[i, i] = 1.0
            A[i, 7] = d[i]
            continue
        for j in range(7):
            A[i, j] = 0.0 if (held >> j) & 1 == 1 else dot6(a, column(J, j))
        # Fast joints move more readily than slow ones.
        short = care * (C[SPEED] / C[SPEED + i]) ** 2
        A[i, i] += damping + short
        A[i, 7] = dot6(a, rest) + short * liked[i]


@kernel
def held_in_vain(C, J, e, wish, held, d, box):
    """The joint on its bound that a step would rather have back inside, most of all; -1 where there is none."""
    liked, damping, care = wish
    rest = e
    for j in range(7):
        rest = less(rest, d[j], column(J, j))
    worst, most = -1, ROUNDING
    for j in range(7):
        if (held >> j) & 1 == 0:
            continue
        short = care * (C[SPEED] / C[SPEED + j]) ** 2
        up = dot6(column(J, j), rest) - damping * d[j] - short * (d[j] - liked[j])
        # On both bounds at once, a joint has no inside.
        pull = up if d[j] < box[1][j] else -up if d[j] > box[0][j] else 0.0
        if pull > most:
            worst, most = j, pull
    return worst


@kernel
def bounded_step(C, e, wish, box, work):
    """The step between bounds that serves the pose best: least |J d - e|^2, and of those the one nearest to `liked`.

    Joints that would pass a bound are held on it, the worst first, and set free where that serves the pose.

    `e` and J come from `error_at`. `wish` is the step that is taken where the pose leaves the choice; damping for poses
    that cannot be met, m^2; and how much the step counts that is liked, m^2. `box` are least and largest steps, rad.
    """
    J, A = work
    low, high = box
    held = 0
    d = wish[0]
    for _ in range(ROUNDS):
        fill(C, J, e, wish, held, d, A)
        solve_linear(A, 7)
        d = (A[0, 7], A[1, 7], A[2, 7], A[3, 7], A[4, 7], A[5, 7], A[6, 7])
        worst = -1
        most = 0.0
        for j in range(7):
            passed = max(low[j] - d[j], d[j] - high[j])
            if (held >> j) & 1 == 0 and passed > most:
                worst = j
                most = passed
        if worst < 0:
            if held > 0:
                worst = held_in_vain(C, J, e, wish, held, d, box)
            if worst < 0:
                return d
        held ^= 1 << worst
        d = between(d, low, high)
    return between(d, low, high)


@kernel
def minus(a, b):
    """The difference a - b, seven figures."""
    return along7(a, -1.0, b)


@kernel
def approach(P, C, pose, q, choice, steps, work):
    """Steps of Gauss and Newton whose sum stays between bounds: the sum, rad, and how far the pose is then.

    `choice` holds a first guess of the sum, the sum that is taken where the pose leaves the choice, the lever (m),
    damping for poses that cannot be met and how much the sum counts that is liked (m^2), least sums, largest sums. A
    pose that is met to `ENOUGH` needs no more steps.
    """
    d, liked, (lever, damping, care), low, high = choice
    e, size = error_at(P, C, along7(q, 1.0, d), pose, lever, work[0])
    wish = minus(liked, d)
    for i in range(steps):
        if i > 0 and size < ENOUGH:
            break
        step = bounded_step(C, e, (wish, damping, care), (minus(low, d), minus(high, d)), work)
        d = between(along7(d, 1.0, step), low, high)
        wish = NO_SEED
        e, size = error_at(P, C, along7(q, 1.0, d), pose, lever, work[0])
    return d, size
