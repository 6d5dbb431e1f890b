"""From a posture to the one around it that is farthest from the joint limits, on a pose up to what that leaves free.

What is brought down is the largest of seven *shares*, along the ways that the pose leaves to first order (`shares`).
The bends of the pose count as in `settle`, so that it converges quadratically.
"""

from __future__ import annotations

import math

from srs_ik.kernels.algebra.joint_vectors import along7
from srs_ik.kernels.freedom import settle
from srs_ik.kernels.freedom.constraints import bends, equations, fill, leaves_cone, on_edge, price
from srs_ik.kernels.freedom.elimination import solve_equations
from srs_ik.kernels.freedom.shares import largest_share, press
from srs_ik.kernels.freedom.system import write_ways
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.freedom import Liking
from srs_ik.kernels.limb.goal import NO_SEED

STEPS = 30
STIFF = 1e-3
STIFFER = 0.1
"""Weight of the length of a step, in shares squared: where bends are known, and where not."""

GAINED = 1e-8
"""A share that falls by less is the least one."""

LITTLE, ALMOST_ON = 1e-6, 1e-5
"""A share that falls by so little, at a posture so close to its pose, m and rad, falls no more to speak of: where no
joint with limits feels a motion, it would go on for long."""

NO_WIDER, BENT = 0.25, 1.0
"""Once bends are known, the largest share falls below what a step promises by no more than so much of it, rad, or of
its square if that is less."""

NO_GAIN = 1e-7
"""A share that is lower than a known one by less is not worth a search."""

NEARLY = 0.02
"""A step that leaves the pose no worse than so, m and rad, is taken if the largest share falls."""


@kernel
def widen(P, q, pose, freedom, rival, desk):
    """The posture around one whose largest share is least: q, that share, and the error of the pose (m, rad).

    Args:
        P: packed limb.
        q: posture to start from.
        pose: rotation and position.
        freedom: what the pose leaves free.
        rival: a share that is known; searches that do not come to a lower one end early.
        desk: work space.
    """
    K, M, J = desk.system, desk.copy, desk.J
    forces, last, asked = settle.NO_FORCE, settle.NO_FORCE, settle.NO_FORCE
    before, step = q, NO_SEED
    known, part, radius, count = 0, 1.0, settle.MAX_STEP, 0
    error, size, worth, best = math.inf, math.inf, math.inf, math.inf
    curved = False
    for _ in range(STEPS):
        m, error, turns = equations(P, q, pose, freedom, forces, desk)
        m = on_edge(m, known, forces)
        share = largest_share(P, q)
        if error < settle.MET and (size < settle.SETTLED or abs(best - share) < GAINED):
            break
        if curved and error < ALMOST_ON and abs(best - share) < LITTLE:
            break
        wider = share < best and error < NEARLY
        if share + price(forces) * error > worth and size > settle.CLOSE_BY and not wider:
            step = along7(NO_SEED, settle.SHORTER, step)
            size *= settle.SHORTER
            part *= settle.SHORTER
            radius = size
            forces = settle.part_way(last, part, asked)
            q = along7(before, 1.0, step)
            continue
        best = share
        radius = min(2.0 * radius, settle.MAX_STEP)
        curve = bends(m, forces, turns, freedom.cone)
        curved = error < settle.ALMOST and known == m
        own = Liking(q, settle.EVEN, NO_SEED, NO_SEED, 0.0, NO_SEED)
        fill(J, K, q, own, curve, (1.0 if curved else 0.0, STIFF if curved else STIFFER, 1.0))
        basic, rank = solve_equations(K, M, m, 0, NO_SEED)
        if basic < 0:
            return q, share, math.inf
        n = write_ways(K, M, rank, basic, 0, NO_SEED)
        step, asked, (ahead, count) = press(P, desk.shares, M, q, (rank, n), count)
        if m == 3 and leaves_cone(K, freedom, step):
            m = 4
            basic, rank = solve_equations(K, M, m, 0, NO_SEED)
            if basic < 0:
                return q, share, math.inf
            n = write_ways(K, M, rank, basic, 0, NO_SEED)
            step, asked, (ahead, count) = press(P, desk.shares, M, q, (rank, n), count)
        last = forces if known == m else asked
        known = m
        worth = share + price(asked) * error
        size, part = 0.0, 1.0
        for j in range(7):
            size = max(size, abs(step[j]))
        if size > radius:
            part = radius / size
            step = along7(NO_SEED, part, step)
            size = radius
        forces = settle.part_way(last, part, asked)
        before = q
        q = along7(q, 1.0, step)
        if curved and ahead - size * min(NO_WIDER, BENT * size) > rival - NO_GAIN:
            return q, share, math.inf
    return q, largest_share(P, q), error
