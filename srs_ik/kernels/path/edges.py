"""What the joint steps of a path count, with first and second derivatives, for all arm angles moved at once.

Sums of squares as they are; limits of the steps, the largest step and the largest of each pose by logarithmic barriers
(Boyd and Vandenberghe 2004, chapter 11): steps x lie within -t and t, and a weight times the sum of -log(t^2 - x^2) is
added to what is to be least. The less the weight, the closer to the corner that the best one is.
"""

import math

from srs_ik.kernels.algebra.joint_vectors import largest
from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.path import BREAK, BY_CONTINUITY, BY_VELOCITY, LARGEST, SLOWEST, SQUARES, TOO_FAST, WITHIN
from srs_ik.kernels.path.steps import step_of, step_value, steps_between

OUTSIDE = 1e300
"""Value of a step beyond its limits."""

TIMES = 30
"""Most steps to the best bound t, which come from below and turn back nowhere."""

GRADIENT = 0
WEIGHT = 1
CROSS = 2
TERMS = 3
"""Rows of the derivatives of a step by its joints: first, second (a diagonal), and mixed with the bound t."""


@kernel
def write_steps(chain, start, settings, q, steps):
    """Write the steps (k, 7) to each posture of a path, that to the first one from the start; zero without one."""
    for c in range(chain.shape[0]):
        for j in range(7):
            if c > 0:
                steps[c, j] = step_of(settings, j, q[chain[c - 1], j], q[chain[c], j])
            elif start.shape[0] > 0:
                steps[c, j] = step_of(settings, j, start[0, j], q[chain[c], j])
            else:
                steps[c, j] = 0.0


@kernel
def share_of(chain, c):
    """By which the squares of a step count: one over the poses that it takes."""
    return 1.0 / (chain[c] - chain[c - 1]) if c > 0 else 1.0


@kernel
def keeps_within(aim, c):
    """Whether limits hold for a step: not for the one from the seed, and not for a break."""
    return aim.kind == WITHIN and c > 0 and not aim.loose[c]


@kernel
def is_left_out(aim, c):
    """Whether a step does not count: a break, where the largest of the others is to be least."""
    return aim.kind == LARGEST and aim.loose[c]


@kernel
def most_of(aim, steps, first, last):
    """What the largest step of rows first to last - 1 counts."""
    most = 0.0
    for c in range(first, last):
        for j in range(7):
            if not is_left_out(aim, c):
                most = max(most, abs(steps[c, j]) * aim.scale[j])
    return most


@kernel
def bound_of(aim, steps, first, last):
    """The bound t that is best for the steps of rows first to last - 1."""
    most = most_of(aim, steps, first, last)
    mu = aim.weight
    t = mu + math.sqrt(mu * mu + most * most)
    for _ in range(TIMES):
        slope, bend = 0.0, 0.0
        for c in range(first, last):
            if is_left_out(aim, c):
                continue
            for j in range(7):
                x = steps[c, j] * aim.scale[j]
                inverse = 1.0 / ((t - x) * (t + x))
                slope += 2.0 * t * inverse
                bend += 2.0 * inverse * (2.0 * t * t * inverse - 1.0)
        off = 1.0 - mu * slope
        t_next = t - off / (mu * bend)
        if not t_next > t * (1.0 + 1e-13):
            break
        t = t_next
    return t


@kernel
def barrier(aim, steps, c, t):
    """Sum of -log(t^2 - x^2) over the joints of a step."""
    product = 1.0
    for j in range(7):
        x = steps[c, j] * aim.scale[j]
        product *= (t - x) * (t + x) / (t * t)
    return -math.log(product) - 14.0 * math.log(t) if product > 0.0 else OUTSIDE


@kernel
def value_of(aim, chain, steps, first):
    """What all steps from number `first` on count, and the bound of the largest one."""
    n = chain.shape[0]
    if aim.kind == LARGEST:
        t = bound_of(aim, steps, first, n)
        total = t
        for c in range(first, n):
            if not is_left_out(aim, c):
                total += aim.weight * barrier(aim, steps, c, t)
        return total, t
    total = 0.0
    for c in range(first, n):
        if aim.kind == SLOWEST:
            t = bound_of(aim, steps, c, c + 1)
            total += t + aim.weight * barrier(aim, steps, c, t)
            continue
        share = share_of(chain, c)
        for j in range(7):
            total += share * steps[c, j] * steps[c, j]
        if keeps_within(aim, c):
            within = barrier_within(aim, steps, c, share)
            if within == OUTSIDE:
                return OUTSIDE, 0.0
            total += aim.weight * within
    return total, 0.0


@kernel
def barrier_within(aim, steps, c, share):
    """Sum of -log(1 - x^2) over the joints of a step."""
    product = 1.0
    for j in range(7):
        x = steps[c, j] * aim.scale[j] * share
        if not abs(x) < 1.0:
            return OUTSIDE
        product *= (1.0 - x) * (1.0 + x)
    return -math.log(product) if product > 0.0 else OUTSIDE


@kernel
def write_terms(aim, chain, steps, c, t, terms):
    """Write the derivatives (TERMS, 7) of a step; returns the second one by its bound t (0: it has none)."""
    share = share_of(chain, c)
    mu = aim.weight
    if is_left_out(aim, c):
        for j in range(7):
            terms[GRADIENT, j], terms[WEIGHT, j], terms[CROSS, j] = 0.0, 0.0, 0.0
        return 0.0
    if aim.kind == SQUARES or aim.kind == WITHIN:
        within = keeps_within(aim, c)
        for j in range(7):
            terms[GRADIENT, j] = 2.0 * share * steps[c, j]
            terms[WEIGHT, j] = 2.0 * share
            terms[CROSS, j] = 0.0
            if within:
                scale = aim.scale[j] * share
                x = steps[c, j] * scale
                inverse = 1.0 / ((1.0 - x) * (1.0 + x))
                terms[GRADIENT, j] += 2.0 * mu * x * inverse * scale
                terms[WEIGHT, j] += 2.0 * mu * inverse * (1.0 + 2.0 * x * x * inverse) * scale * scale
        return 0.0
    by_bound = 0.0
    for j in range(7):
        scale = aim.scale[j]
        x = steps[c, j] * scale
        inverse = 1.0 / ((t - x) * (t + x))
        terms[GRADIENT, j] = 2.0 * mu * x * inverse * scale
        terms[WEIGHT, j] = 2.0 * mu * inverse * (1.0 + 2.0 * x * x * inverse) * scale * scale
        terms[CROSS, j] = -4.0 * mu * x * t * inverse * inverse * scale
        by_bound += 2.0 * mu * inverse * (2.0 * t * t * inverse - 1.0)
    return by_bound


@kernel
def path_cost(chain, start, settings, limited, q):
    """Breaks, steps that are too fast, and the value of all steps of a path."""
    total = 0.0
    for c in range(chain.shape[0]):
        here = row(q, chain[c])
        between = 1
        if c > 0:
            between = chain[c] - chain[c - 1]
            e = steps_between(settings, row(q, chain[c - 1]), here)
        elif start.shape[0] > 0:
            e = steps_between(settings, row(start, 0), here)
        else:
            continue
        total += step_value(settings, e, 1.0 / between)
        if largest(e) > settings[7 * BY_CONTINUITY]:
            total += BREAK
        elif limited:
            if c > 0:
                over = 0.0
                for j in range(7):
                    over = max(over, abs(e[j]) / (between * settings[7 * BY_VELOCITY + j]))
                if over > 1.0 + 1e-9:
                    total += TOO_FAST * over
    return total
