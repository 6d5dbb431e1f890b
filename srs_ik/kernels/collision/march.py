"""Free arm angles of a limb whose axes miss their centres by more than a little: along its curve, on the true chain.

There is no closed form for where its bodies go. The curve of postures is followed step by step. From the middle of a
step on, bodies move against each other by as much as they do to its ends, and a quarter more; where they are farther
apart than that, the step is free. Else it is halved; what is not shown to be free on the shortest step counts as
forbidden.
"""

import math

from srs_ik.kernels.collision.motion import CLEAR, HIT
from srs_ik.kernels.collision.moved import look_between
from srs_ik.kernels.exact.intervals import write_interval
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.asked import Goal
from srs_ik.kernels.layout.collision import MARGIN
from srs_ik.kernels.limb.goal import NO_SEED, OUTSIDE
from srs_ik.kernels.near.at_angle import solve_at_angle
from srs_ik.kernels.near.led import led_to

ANYWHERE = (math.inf, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
"""Stands for no posture to be near to."""

LONGEST = 0.25
"""Longest step, rad."""

SHORTEST = 2e-3
"""Shortest step, rad."""

SKIPPED = 0.5
"""Of the way that bodies in each other must be moved to come apart, the part that is not looked at."""


@kernel
def posture_on(P, target, psi, branch, near, space):
    """The posture of a branch at an arm angle, in the turns next to another one, and whether there is one."""
    seeded = near[0] < math.inf
    seed = near if seeded else NO_SEED
    q, _, cost = solve_at_angle(P, target, psi, branch, Goal(seeded, seed, False), space.J, space.A)
    return q, cost < OUTSIDE


@kernel
def look_ahead(P, target, around, step, space):
    """Look at a step (branch, arm angle, length, posture before): verdict, how much to skip, rad, posture behind."""
    world, slack, along = around
    branch, psi, length, before = step
    middle, met = led_to(P, target, psi + 0.5 * length, branch, before, space.A)
    behind, also = led_to(P, target, psi + length, branch, middle, space.A)
    if not (met and also) and length <= SHORTEST:
        # Other means take a thousand times as long: only where no shorter step is left.
        middle, met = posture_on(P, target, psi + 0.5 * length, branch, before, space)
        behind, also = posture_on(P, target, psi + length, branch, before, space)
    if not (met and also):
        return HIT, 0.0, before
    verdict, least, moved = look_between(P, (before, middle, behind), world, slack, along)
    skip = 0.0
    if verdict == HIT:
        skip = SKIPPED * 0.5 * length * (slack[MARGIN] - least) / max(moved, 1e-9)
    return verdict, skip, behind


@kernel
def march(P, target, around, interval, space, out, rows):
    """Append the free parts of an interval (branch, lower, upper) to rows (first, count) of out; their number."""
    branch, lower, upper = interval
    first, count = rows
    inside = min(1e-9, 0.25 * (upper - lower))
    psi, last = lower + inside, upper - inside
    before, met = posture_on(P, target, psi, branch, ANYWHERE, space)
    start, length = math.inf, LONGEST
    while psi < last:
        length = min(length, last - psi)
        if not met:
            psi += SHORTEST
            before, met = posture_on(P, target, min(psi, last), branch, ANYWHERE, space)
            continue
        verdict, skip, behind = look_ahead(P, target, around, (branch, psi, length, before), space)
        if verdict == CLEAR:
            start = min(start, psi)
            psi, before = psi + length, behind
            length = min(2.0 * length, LONGEST)
            continue
        if length > SHORTEST and skip < 0.25 * length:
            length = max(0.5 * length, SHORTEST)
            continue
        if start < psi:
            count = write_interval(out, first, count, branch, start, psi)
        start = math.inf
        psi += max(skip, min(length, SHORTEST))
        before, met = posture_on(P, target, min(psi, last), branch, ANYWHERE, space)
        length = max(length, SHORTEST)
    if start < last:
        count = write_interval(out, first, count, branch, start, last)
    return count


@kernel
def march_all(P, target, around, found, space, out):
    """The free parts of all intervals in found (n, 3), sorted by branch, into rows of out; return their number.

    `around` are the bodies: `seen.World`, slack, and `shapes.Along` where shapes count, else None.
    """
    count, first, branch = 0, 0, -1
    for i in range(found.shape[0]):
        b = int(found[i, 0])
        if b != branch:
            branch, first = b, count
        interval = (b, found[i, 1], found[i, 2])
        count = march(P, target, around, interval, space, out, (first, count))
    return count
