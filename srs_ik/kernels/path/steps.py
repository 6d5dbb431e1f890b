"""One joint step: from a posture to another, or from between two of a strip, and what it counts."""

import math

from srs_ik.kernels.algebra.lanes import larger, where, whole_number
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import path as at
from srs_ik.kernels.layout.path import Rules
from srs_ik.kernels.path.followed import along_cell

CUTS = 24
"""Most steps of the search for the least time between two postures."""

TOUCHING = 1e-12
"""Relative."""


@kernel
def step_of(settings, j, a, b):
    """Joint step from a to b; the shorter way round for a joint that turns without end."""
    d = b - a
    if abs(d) * settings[7 * at.INVERSE_PERIOD + j] < 0.5:
        return d
    return d - settings[7 * at.PERIOD + j] * math.floor(d * settings[7 * at.INVERSE_PERIOD + j] + 0.5)


@kernel
def steps_between(settings, a, b):
    """The seven joint steps from a to b."""
    if settings[7 * at.ENDLESS] == 0.0:
        return along_cell(a, b)
    return (
        step_of(settings, 0, a[0], b[0]),
        step_of(settings, 1, a[1], b[1]),
        step_of(settings, 2, a[2], b[2]),
        step_of(settings, 3, a[3], b[3]),
        step_of(settings, 4, a[4], b[4]),
        step_of(settings, 5, a[5], b[5]),
        step_of(settings, 6, a[6], b[6]),
    )


@kernel
def product(a, b):
    """Scalar product of joint steps."""
    return ((a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3])) + ((a[4] * b[4] + a[5] * b[5]) + a[6] * b[6])


@kernel
def kept(e, d, t0, t1, settings, kind):
    """The part of t0 to t1 in which no step of e - t d is too long; empty if its end is below its begin."""
    for j in range(7):
        longest = settings[7 * kind + j]
        x, y = e[j], d[j]
        if abs(x) <= longest and abs(x - y) <= longest:
            continue
        if abs(y) < 1e-12:
            if abs(x) > longest * (1.0 + 1e-9):
                return 1.0, 0.0
            continue
        one, other = (x - longest) / y, (x + longest) / y
        t0 = max(t0, min(one, other))
        t1 = min(t1, max(one, other))
    return t0, t1


@kernel
def scale_settings(settings, between, scaled):
    """Write the settings for a step over so many poses: as many times as fast, and twice as far at most."""
    for j in range(7):
        scaled[7 * at.BY_VELOCITY + j] = settings[7 * at.BY_VELOCITY + j] * between
        scaled[7 * at.BY_CONTINUITY + j] = settings[7 * at.BY_CONTINUITY + j] * min(between, 2)


@kernel
def copied(settings, scaled):
    """The settings once more, where there is room for them."""
    for k in range(7 * at.SETTINGS):
        scaled[k] = settings[k]
    return scaled


@kernel
def rules_for(settings, scaled, between, limited):
    """What a step over so many poses counts; `scaled` are the settings with room for its speeds."""
    scale_settings(settings, between, scaled)
    return Rules(scaled, limited, 1.0 / between)


@kernel
def step_value(settings, e, share):
    """What a step counts: its squares, for all joints together, or the time that the slowest joint takes."""
    if settings[7 * at.INVERSE_SPEED] == 0.0:
        return share * product(e, e)
    longest = 0.0
    for j in range(7):
        longest = max(longest, abs(e[j]) * settings[7 * at.INVERSE_SPEED + j])
    return longest


@kernel
def step_cost(e, d, ends, t0, t1, rules):
    """Least of va + t (vb - va) - sag t (1 - t) and the value of the step e - t d, t from t0 to t1, and where it is."""
    va, vb, sag = ends
    if rules.settings[7 * at.INVERSE_SPEED] != 0.0:
        return quickest(e, d, va, vb, t0, t1, rules.settings)
    share = rules.share
    size = product(d, d) * share
    across = product(e, d) * share
    slope = across + 0.5 * (sag - (vb - va))
    t = t0
    if size + sag > 1e-18:
        t = min(max(slope / (size + sag), t0), t1)
    elif slope > 0.0:
        t = t1
    return va + t * (vb - va) - sag * t * (1.0 - t) + share * product(e, e) - t * (2.0 * across - t * size), t


@kernel
def eight_step(settings, j, d):
    """`step_of` for eight differences."""
    return d - settings[7 * at.PERIOD + j] * whole_number(d * settings[7 * at.INVERSE_PERIOD + j])


@kernel
def eight_steps(settings, a, q):
    """The seven joint steps from a posture to each of eight."""
    d = along_cell(a, q)
    if settings[7 * at.ENDLESS] == 0.0:
        return d
    return (
        eight_step(settings, 0, d[0]),
        eight_step(settings, 1, d[1]),
        eight_step(settings, 2, d[2]),
        eight_step(settings, 3, d[3]),
        eight_step(settings, 4, d[4]),
        eight_step(settings, 5, d[5]),
        eight_step(settings, 6, d[6]),
    )


@kernel
def are_short(e, settings, limited, more):
    """Which of eight steps are continuous, and within velocity limits where these count, or above by `more` at most."""
    over = abs(e[0]) - settings[7 * at.BY_CONTINUITY]
    for j in range(7):
        longest = settings[7 * at.BY_CONTINUITY + j]
        if limited:
            longest = min(longest, settings[7 * at.BY_VELOCITY + j])
        over = larger(over, abs(e[j]) - longest)
    return over < more


@kernel
def least_of_eight(e, d, ends, t0, t1, rules):
    """`step_cost` for eight steps, nothing limiting them; of times, what they are at least."""
    va, vb, sag = ends
    settings = rules.settings
    if settings[7 * at.INVERSE_SPEED] != 0.0:
        most = 0.0 * e[0]
        for j in range(7):
            most = larger(most, settings[7 * at.INVERSE_SPEED + j] * (abs(e[j] - 0.5 * d[j]) - 0.5 * abs(d[j])))
        return most + min(va, vb), most
    size = product(d, d) * rules.share
    across = product(e, d) * rules.share
    slope = across + 0.5 * (sag - (vb - va))
    t = where(slope > 0.0, t1, t0)
    if size + sag > 1e-18:
        t = slope / (size + sag)
        t = where(t < t0, t0, where(t > t1, t1, t))
    return va + t * (vb - va) - sag * t * (1.0 - t) + rules.share * product(e, e) - t * (2.0 * across - t * size), t


@kernel
def slowest(e, d, t, settings):
    """The time that the slowest joint takes for the step e - t d, and its slope with t."""
    longest, slope = -1.0, 0.0
    for j in range(7):
        inverse = settings[7 * at.INVERSE_SPEED + j]
        x = e[j] - t * d[j]
        if abs(x) * inverse > longest:
            longest = abs(x) * inverse
            slope = -d[j] * inverse if x > 0.0 else d[j] * inverse
    return longest, slope


@kernel
def quickest(e, d, va, vb, t0, t1, settings):
    """`step_cost` for the time: straight pieces, of which those at two ends are followed to where they meet."""
    rise = vb - va
    f0, g0 = slowest(e, d, t0, settings)
    f1, g1 = slowest(e, d, t1, settings)
    f0, f1 = f0 + t0 * rise, f1 + t1 * rise
    g0, g1 = g0 + rise, g1 + rise
    if g0 >= 0.0 or g1 <= 0.0:
        return (va + f0, t0) if f0 <= f1 else (va + f1, t1)
    t, f = t0, f0
    for _ in range(CUTS):
        t = min(max(t0 + (f1 - f0 - g1 * (t1 - t0)) / (g0 - g1), t0), t1)
        least = f0 + g0 * (t - t0)
        f, g = slowest(e, d, t, settings)
        f, g = f + t * rise, g + rise
        if f <= least + TOUCHING * abs(f):
            break
        if g < 0.0:
            t0, f0, g0 = t, f, g
        else:
            t1, f1, g1 = t, f, g
    return va + f, t
