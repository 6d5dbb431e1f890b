"""Which posture is better: farther from the limits, or nearer to a seed.

Both goals split over joints: a margin is the smallest of the joints' margins, a squared distance their sum. So the best
shoulder and the best wrist solution can be chosen each for itself. A cost is lower where better; a part outside its
limits costs more than any part inside.
"""

from srs_ik.kernels.jit import kernel
from srs_ik.kernels.limb.limits import margin, turn_to_middle, turn_to_seed, violation

NO_SEED = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
"""Stands for a seed where there is none."""

OUTSIDE = 1e6
"""Cost of a part outside its limits, plus the largest violation in rad."""

TIE = 1e-9
"""Margins that differ by less, of half a range, are equal; rounding must not choose: of equal ones the lower branch."""

UNMET = 1.5 * OUTSIDE
"""Postures that meet their pose cost less, however far outside their limits; those that do not, more."""


@kernel
def turn(P, joint, q, seeded, seed, respect):
    """The turn of a joint angle that suits the goal."""
    if seeded:
        return turn_to_seed(P, joint, q, seed, respect)
    return turn_to_middle(P, joint, q)


@kernel
def turned(P, q, seeded, seed, respect):
    """Every joint in the turn that suits the goal."""
    return (
        turn(P, 0, q[0], seeded, seed[0], respect),
        turn(P, 1, q[1], seeded, seed[1], respect),
        turn(P, 2, q[2], seeded, seed[2], respect),
        turn(P, 3, q[3], seeded, seed[3], respect),
        turn(P, 4, q[4], seeded, seed[4], respect),
        turn(P, 5, q[5], seeded, seed[5], respect),
        turn(P, 6, q[6], seeded, seed[6], respect),
    )


@kernel
def joint_cost(P, joint, q, seeded, seed):
    """Cost of one joint: minus its margin, or its squared distance from the seed."""
    if seeded:
        return (q - seed) * (q - seed)
    return -margin(P, joint, q)


@kernel
def join(a, b, seeded, respect):
    """Cost of two parts together."""
    if respect and max(a, b) >= OUTSIDE:
        return max(a, b)
    return a + b if seeded else max(a, b)


@kernel
def margin_part(P, first, q, respect):
    """`part` where the goal is the margin to the limits."""
    a = turn_to_middle(P, first, q[0])
    b = turn_to_middle(P, first + 1, q[1])
    c = turn_to_middle(P, first + 2, q[2])
    total = max(-margin(P, first, a), -margin(P, first + 1, b), -margin(P, first + 2, c))
    outside = max(violation(P, first, a), violation(P, first + 1, b), violation(P, first + 2, c))
    return (a, b, c), (OUTSIDE + outside if respect and outside > 0.0 else total)


@kernel
def seed_part(P, first, q, seed, respect):
    """`part` where the goal is a seed."""
    a = turn_to_seed(P, first, q[0], seed[0], respect)
    b = turn_to_seed(P, first + 1, q[1], seed[1], respect)
    c = turn_to_seed(P, first + 2, q[2], seed[2], respect)
    total = (a - seed[0]) ** 2 + (b - seed[1]) ** 2 + (c - seed[2]) ** 2
    outside = max(violation(P, first, a), violation(P, first + 1, b), violation(P, first + 2, c))
    return (a, b, c), (OUTSIDE + outside if respect and outside > 0.0 else total)


@kernel
def part(P, first, q, seeded, seed, respect):
    """Three joints from `first` on: the turns of their angles that suit the goal, and their cost.

    Each goal has a kernel of its own: asked joint by joint, the question of the goal takes most of the time.
    """
    if seeded:
        return seed_part(P, first, q, seed, respect)
    return margin_part(P, first, q, respect)


@kernel
def elbow_part(P, q, seeded, seed, respect):
    """The elbow joint alone: its turn and its cost."""
    a = turn(P, 3, q, seeded, seed, respect)
    outside = violation(P, 3, a)
    if respect and outside > 0.0:
        return a, OUTSIDE + outside
    return a, joint_cost(P, 3, a, seeded, seed)


@kernel
def cost(P, q, seeded, seed, respect):
    """Cost of a whole posture, its turns as they are."""
    worst = 0.0
    total = 0.0 if seeded else -1.0
    for joint in range(7):
        worst = max(worst, violation(P, joint, q[joint]))
        c = joint_cost(P, joint, q[joint], seeded, seed[joint])
        total = total + c if seeded else max(total, c)
    if respect and worst > 0.0:
        return OUTSIDE + worst
    return total


@kernel
def tightest_joint(P, q):
    """The joint (1 to 7) with the smallest margin, or the largest violation if any is outside."""
    best = 0
    smallest = 2.0
    outside = 0.0
    for joint in range(7):
        beyond = violation(P, joint, q[joint])
        m = margin(P, joint, q[joint])
        if beyond > outside:
            outside = beyond
            best = joint
        elif outside == 0.0 and m < smallest:
            smallest = m
            best = joint
    return best + 1
