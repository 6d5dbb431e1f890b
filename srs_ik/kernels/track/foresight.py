"""Where the joints go in the next second: postures that lie ahead on the way of the target.

They are chosen together. A posture costs what it misses of the pose that is expected at its time, how far a joint is
into the zone at the end of its range, and what velocities and accelerations lead there, by the limits of each joint. So
the arm goes straight through a singular posture in its way or early around it, and the elbow slides before a limit
comes. A plan is two steps of Gauss and Newton from the plan before, on the true chain.
"""

import math

from srs_ik.kernels.algebra.joint_vectors import along7
from srs_ik.kernels.algebra.linear import solve_band
from srs_ik.kernels.algebra.pointers import read7, row
from srs_ik.kernels.algebra.vectors import norm
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import track as at
from srs_ik.kernels.layout.limb import FAR, LOWER, UPPER
from srs_ik.kernels.limb.branches import singular_sines
from srs_ik.kernels.limb.goal import NO_SEED
from srs_ik.kernels.track.closest import column, dot6, error_at
from srs_ik.kernels.track.elbow import keep_elbow, slope, wish
from srs_ik.kernels.track.freedom import whole_rotation
from srs_ik.kernels.track.target import load_pace
from srs_ik.kernels.track.trend import foretold, sure_of

LINEAR, SQUARE = 0.012, 0.021
"""Knot k of a plan is k LINEAR + k^2 SQUARE seconds ahead: the near future in detail, 1.1 s in all."""

UNIT = 0.07
"""Costs of velocities and accelerations are for so many seconds."""

FINE = 2.5e-4
COARSE = 0.01
"""A pose missed by FINE + COARSE t^2, metres, t seconds ahead, costs 1: the future is known less and less."""

TURNING = 2.0
"""Turning by a radian counts as much as moving by so many times the reach."""

FAR_OFF = 5e-3
"""Misses larger than this, m, cost in proportion, not by their square: a jump is no reason to hurry."""

SLOW = 0.05
KEPT_SLOW = 3.0
"""Cost of the largest velocity, the second where the elbow is kept, unless the target is slow; that of the largest
acceleration is 1. For the second the elbow goes to where a motion costs less, the same way as the target comes and as
it goes: on a slow target, which needs none of this, it would wander."""

CALM = 0.3
PACED = 1e-3
"""A target is slow up to about the first, m/s and, by the reach, rad/s. The second is next to nothing."""

INVOLVED = 0.17
"""Sine of a middle joint, away from where it is singular, below which it is close to that."""

BUSY = 0.05
"""A target that is faster than this, m/s and, by the reach, rad/s, does not rest."""

FAST = 0.4
TOO_FAST = 60.0
"""What a joint uses of its velocity beyond this share costs so much more."""

ROOM = 0.3
PRICE = 0.3
"""Cost of a joint on its limit, and how far from it, rad, that begins; it is not paid while the target rests."""

VERGE = 0.1
STEEP = 25.0
THIN = 0.2
"""The same for the last stretch, at rest too. At rest, where something is asked of the elbow, which may lie behind it,
that is only so much as long."""

ASKED = 4
"""The knot at which something is asked of the elbow, 0.38 s ahead: at the end of the plan it would take its time."""

STEPS = 2
"""Steps from one plan to the next. With one, plans swing about the best one where the arm is nearly singular, and the
joints with them; with three they are no better."""

LONGEST = 0.3
"""A joint of a plan changes by no more than this in a step, rad."""


@kernel
def when(k):
    """Seconds to knot k."""
    return k * (LINEAR + SQUARE * k)


@kernel
def pace(P, S):
    """How fast the target moves, m/s and, by the reach, rad/s."""
    v, w = load_pace(S)
    return norm(v) + P[FAR] * norm(w)


@kernel
def busyness(P, S):
    """0 where the target rests, 1 where it moves at a good pace."""
    return min(pace(P, S) / BUSY, 1.0)


@kernel
def begin(S):
    """Let a plan begin now; without a plan before, with all joints at rest."""
    known = S[at.PLANNED] == 1.0
    age = S[at.PLAN_AGE]
    for j in range(7):
        for k in range(at.KNOTS):
            i = at.KNOT + 7 * k + j
            if not known:
                S[i] = S[at.Q + j]
                continue
            last = k + 1 == at.KNOTS
            rise = S[i] - S[i - 7] if last else S[i + 7] - S[i]
            gap = when(k + 1) - when(k) if last else when(k + 2) - when(k + 1)
            S[i] += min(age / gap, 1.0) * rise
        S[at.PLAN_Q + j] = S[at.Q + j]
        S[at.PLAN_V + j] = S[at.V + j]
    S[at.PLANNED], S[at.PLAN_AGE] = 1.0, 0.0


@kernel
def add_square(B, i, first, second, third, price, wanted):
    """Add the price of (first x + second y + third z - wanted)^2, z being unknown i, x and y the same joint before.

    What lies before the first knot is known, and has a factor of zero.
    """
    factors = (first, second, third)
    for m in range(3):
        if factors[m] == 0.0:
            continue
        r = i - 7 * (2 - m)
        B[r, at.BAND + 1] += price * factors[m] * wanted
        for n in range(m + 1):
            if factors[n] != 0.0:
                B[r, at.BAND - 7 * (m - n)] += price * factors[m] * factors[n]


@kernel
def add_motion(S, C, slow, B):
    """Add what accelerations and velocities cost."""
    for j in range(7):
        most = C[at.SPEED + j]
        push = 1.0 / (UNIT * min(C[at.ACCELERATION + j], at.SOFT_START * most) ** 2)
        pace = 1.0 / (UNIT * most * most)
        here, rate, h = S[at.PLAN_Q + j], S[at.PLAN_V + j], 0.0
        for k in range(at.KNOTS):
            i = 7 * k + j
            g = when(k + 1) - when(k)
            x, y, z = 0.0, 0.0, 1.0 / g
            if k > 0:
                y = -1.0 / g
            next_rate = (S[at.KNOT + i] - here) / g
            # The change of velocity from the middle of an interval to that of the next; the first velocity is the
            # present one.
            by = 2.0 / (g + h)
            change = by * (next_rate - rate)
            before = 1.0 / h if k > 0 else 0.0
            if k > 1:
                x = before
            add_square(B, i, by * x, by * (y - before), by * z, 0.5 * (g + h) * push, -change)
            add_square(B, i, 0.0, y, z, slow * g * pace, -next_rate)
            if abs(next_rate) > FAST * most:
                add_square(B, i, 0.0, y, z, TOO_FAST * g * pace, math.copysign(FAST * most, next_rate) - next_rate)
            here, rate, h = S[at.KNOT + i], next_rate, g


@kernel
def add_room(P, S, B, price, verge):
    """Add what joints close to their limits cost."""
    for k in range(at.KNOTS):
        for j in range(7):
            i = 7 * k + j
            up, down = P[UPPER + j] - S[at.KNOT + i], S[at.KNOT + i] - P[LOWER + j]
            side, room = (-1.0, up) if up < down else (1.0, down)
            if room < ROOM:
                add_square(B, i, 0.0, 0.0, 1.0, price / ROOM**2, side * (ROOM - room))
            if room < verge:
                add_square(B, i, 0.0, 0.0, 1.0, STEEP / verge**2, side * (verge - room))


@kernel
def add_poses(P, S, C, sure, J, B):
    """Add what missing the expected poses costs; `sure` is as in `foretold`."""
    for k in range(at.KNOTS):
        q = read7(row(S, at.KNOT + 7 * k))
        t = when(k + 1)
        R, p = foretold(S, t, sure)
        e, size = error_at(P, C, q, (R, p), TURNING * P[FAR], J)
        fine = FINE + COARSE * t * t
        price = 1.0 / (fine * fine * max(1.0, size / max(FAR_OFF, 2.0 * fine)))
        for a in range(7):
            i = 7 * k + a
            of_a = column(J, a)
            B[i, at.BAND + 1] += price * dot6(of_a, e)
            for b in range(a + 1):
                B[i, at.BAND - a + b] += price * dot6(of_a, column(J, b))


@kernel
def add_wish(P, S, C, task, calm, sure, J, B):
    """Add what is asked of the elbow; `calm` is the share by which it is drawn back where it is kept."""
    q = read7(row(S, at.KNOT + 7 * (ASKED - 1)))
    R, p = foretold(S, when(ASKED), sure)
    pose = whole_rotation(P, C, q, R), p
    way, pull = wish(P, S, C, task, q, pose, calm, J)
    if pull == 0.0:
        return
    rise = slope(P, q, pose)
    for a in range(7):
        i = 7 * (ASKED - 1) + a
        B[i, at.BAND + 1] += pull * rise[a] * way
        for b in range(a + 1):
            B[i, at.BAND - a + b] += pull * rise[a] * rise[b]


@kernel
def singular_share(P, S):
    """0 where shoulder, elbow or wrist is singular on the plan, where the elbow has to turn aside; 1 well away."""
    least = INVOLVED
    for k in range(at.KNOTS):
        s2, s4, s6 = singular_sines(P, read7(row(S, at.KNOT + 7 * k)))
        least = min(least, s2, s4, s6)
    return (least / INVOLVED) ** 2


@kernel
def improve(P, S, C, task, sure, work):
    """A step of Gauss and Newton of the plan; arguments as in `foresee`, `sure` as in `foretold`."""
    J, _, B = work
    for i in range(7 * at.KNOTS):
        for k in range(at.BAND + 2):
            B[i, k] = 0.0
    keep, busy = C[at.ELBOW] == at.KEEP, sure[0] * busyness(P, S)
    # Steep, so that what is slower than that is hardly drawn aside, and what is faster as ever.
    fast = 1.0 / (1.0 + (CALM / max(pace(P, S), PACED)) ** 8)
    calm = busy * (1.0 - fast) * singular_share(P, S)
    add_motion(S, C, SLOW + (1.0 - calm) * (KEPT_SLOW - SLOW) if keep else SLOW, B)
    add_room(P, S, B, PRICE * busy, VERGE if keep else max(busy, THIN) * VERGE)
    add_poses(P, S, C, sure, J, B)
    add_wish(P, S, C, task, calm, sure, J, B)
    solve_band(B, 7 * at.KNOTS, at.BAND)
    for j in range(7):
        before = S[at.PLAN_Q + j]
        for k in range(at.KNOTS):
            i = 7 * k + j
            there = S[at.KNOT + i] + min(max(B[i, at.BAND + 1], -LONGEST), LONGEST)
            # A posture that the joint is too slow for, as one in another branch, would draw those before it there.
            far = (when(k + 1) - when(k)) * C[at.SPEED + j]
            there = min(max(there, before - far), before + far)
            before = min(max(there, P[LOWER + j]), P[UPPER + j])
            S[at.KNOT + i] = before


@kernel
def foresee(P, S, C, task, work):
    """Plan anew, from the plan before; `task` are the parameters of the elbow's objective, `work` J, A and B."""
    if S[at.PLANNED] == 0.0 or C[at.ELBOW] != at.KEEP:
        keep_elbow(P, S)
    begin(S)
    sure = sure_of(P, S, C)
    for _ in range(STEPS):
        improve(P, S, C, task, sure, work)
    first = when(1)
    for j in range(7):
        S[at.PLAN_A + j] = 2.0 * (S[at.KNOT + j] - S[at.PLAN_Q + j] - first * S[at.PLAN_V + j]) / first**2


@kernel
def planned_step(S, C):
    """The step that the plan has for the next period, rad: on with the present velocities, and its accelerations.

    Where the tip is brought back to its target, joints are not where the plan has them; to go there is a jerk.
    """
    period = C[at.PERIOD]
    S[at.PLAN_AGE] += period
    straight = along7(NO_SEED, period, read7(row(S, at.V)))
    return along7(straight, period * period, read7(row(S, at.PLAN_A)))
