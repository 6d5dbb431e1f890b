"""Postures of a near limb at an arm angle, where the curves that are followed on its true chain pass it."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import difference, dot7, short_way, store7
from srs_ik.kernels.algebra.pointers import copy, read7, row
from srs_ik.kernels.algebra.vectors import norm
from srs_ik.kernels.chain.kinematics import pose_error
from srs_ik.kernels.chain.newton import ON_LINE, STEPS, close_at_angle, elbow_across, moved
from srs_ik.kernels.chain.starts import best_row
from srs_ik.kernels.curves import changes as crossing
from srs_ik.kernels.curves.ends import inside_of_blur
from srs_ik.kernels.curves.follow import BLURRED, arc_between, between, tangent_at, vagueness, way_at
from srs_ik.kernels.curves.in_step import SAMPLE, load_end, load_sample, put_sample, share_of_chord
from srs_ik.kernels.curves.lowest import cost_of_turn
from srs_ik.kernels.curves.outreach import EVERY_PAIR
from srs_ik.kernels.curves.runs import certain_runs, samples_of
from srs_ik.kernels.curves.spans import JUST_OUTSIDE, MAX_SPANS
from srs_ik.kernels.curves.told import (
    ARM_ANGLE,
    TOLD,
    TOLD_BRANCH,
    TOLD_PSI,
    TOLD_RATE,
    angle_at,
    goes_past,
    rate_along,
    tell_samples,
    turning_between,
)
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.answer import ROW_COST, SOLVED
from srs_ik.kernels.layout.asked import Samples, Setting
from srs_ik.kernels.layout.limb import FAR
from srs_ik.kernels.layout.search import MAX_RUNS, RUN
from srs_ik.kernels.limb.branches import NO_BRANCH, bit_of, branch_of, is_on_border
from srs_ik.kernels.limb.goal import NO_SEED, turned
from srs_ik.kernels.limb.surface import has_surface
from srs_ik.kernels.limb.triangle import elbow_side
from srs_ik.kernels.near import arcs
from srs_ik.kernels.near.band import band_of, may_predict
from srs_ik.kernels.near.scan import view_with

HALVINGS = 30
"""Steps that close in on an arm angle between two samples, before Newton's method takes over."""

NEAR_TURN = 0.5
FASTER = 4.0
WELL_BENT = 0.2
SAME_ANGLE = 1e-9
"""An arm angle that turns around is looked for this close to the one that is wanted, rad; farther away, and where the
elbow's bend has no smaller sine, only if it may come there at so many times its rate. There it is the one, up to the
last: rounding decides about limits and branches within it."""

UNTOLD = 1e-3
OF_ROUNDING = 0.025
APART = 4.0
"""Rounding moves the arm angle of an almost straight elbow by the first at most, rad, where that is still told at all,
and by the second of what all roundings make of a posture together. Where limits cut the curves it may move it farther:
by the third times what it does by the step that `vagueness` takes, of errors of alternate signs."""

CLOSE_CALL = 1e-4
"""Where a curve turns around or goes over into another branch so close to an arm angle, rad, rounding may decide."""

CLOSE_BY = 1e-4
"""Newton's method moves a posture no farther than this, rad, squared."""

SAME_POSTURE = 1e-12
"""Postures this close together, rad squared, are one where rounding decides: samples on either side of a change of
branch, and what Newton's method makes of an arm angle that is met."""

SAME_CURVE = 1e-18
"""A posture that it leads to at once is this close to the curve, rad squared: others may cross it nearby."""


EVERY_BRANCH = 0b11111111
"""The branches, as bits."""


class Followed(NamedTuple):
    """Curves of a pose, whatever the limits."""

    rows: Any  # their samples
    runs: Any  # the rows of each
    told: Any  # (n, TOLD), of every sample
    are_all: Any  # whether these are for certain all of the branches that are asked for


@kernel
def setting_of(P, target, J, A):
    """The setting in which all curves of a pose are followed, whatever the limits."""
    return Setting(target, elbow_side(P, target.place, 0), False, J, A)


@kernel
def no_curves():
    """No curves, as long as none have been followed."""
    return Followed(np.empty((0, SAMPLE)), np.empty((0, RUN)), np.empty((0, TOLD)), False)


@kernel
def put_beside(P, by, place_, branch, n, followed):
    """Append a place of a branch; the number of rows."""
    if n >= followed.rows.shape[0]:
        return n
    put_sample(followed.rows, n, place_.at[0], turned(P, place_.q, False, NO_SEED, by.respect))
    told = followed.told[n]
    told[TOLD_BRANCH], told[TOLD_PSI], told[TOLD_RATE] = branch, place_.at[1], place_.at[2]
    return n + 1


@kernel
def put_back(P, by, curve, place_, n, followed):
    """Append postures where the arm angle goes back between the last of n rows and a place, if it does: rows."""
    last = followed.rows[n - 1, 0], followed.told[n - 1, TOLD_PSI], followed.told[n - 1, TOLD_RATE]
    branch = int(followed.told[n - 1, TOLD_BRANCH])
    for i in range(crossing.MOST_BACK):
        there, found = crossing.turned_back(P, by, curve, last, place_, i > 0)
        if not found:
            break
        last = there.at
        n = put_beside(P, by, there, branch, n, followed)
    return n


@kernel
def told_runs(P, by, samples, n_samples, runs, are_all):
    """What the samples of runs of curves tell, with more of them where these go from branch to branch."""
    told = np.empty((samples.shape[0], TOLD))
    tell_samples(P, by, Samples(samples, 0, n_samples), told)
    changes, met = np.empty((crossing.MOST_CHANGES, crossing.CHANGE)), np.empty((crossing.MOST_MET, crossing.MET))
    known = told, met[: crossing.meet_changes(P, by, samples, runs, told, met)]
    room = n_samples + 2 * MAX_SPANS
    out = Followed(np.empty((room, SAMPLE)), runs, np.empty((room, TOLD)), are_all)
    n = 0
    for index in range(runs.shape[0]):
        curve = samples_of(samples, runs[index])
        runs[index, 3] = n
        branch = int(told[curve.first, TOLD_BRANCH])
        for i in range(curve.first, curve.last):
            on = i == curve.first or crossing.goes_on(P, curve, i, told, told[i - 1, TOLD_RATE])
            for c in range(0 if on else crossing.find_changes(P, by, curve, i, known, changes)):
                x = changes[c, crossing.CHANGE_AT]
                inside, outside = max(x - JUST_OUTSIDE, samples[i - 1, 0]), min(x + JUST_OUTSIDE, samples[i, 0])
                there = crossing.place_beside(P, by, curve, changes[c], inside)
                n = put_back(P, by, curve, there.at, n, out)
                n = put_beside(P, by, there, branch, n, out)
                branch ^= bit_of(int(changes[c, crossing.CHANGE_MIDDLE]))
                n = put_beside(P, by, crossing.place_beside(P, by, curve, changes[c], outside), branch, n, out)
            if not on:
                n = put_back(P, by, curve, (samples[i, 0], told[i, TOLD_PSI], told[i, TOLD_RATE]), n, out)
            if n < room:
                copy(row(samples, i), row(out.rows, n), SAMPLE)
                copy(row(told, i), row(out.told, n), TOLD)
                n += 1
        runs[index, 4] = n
    return out


@kernel
def followed_curves(P, by, branches):
    """Follow all curves of a pose that branches (bits) need, and look where they go from branch to branch."""
    runs = np.empty((MAX_RUNS, RUN))
    (samples, n_samples, k, _), certain = certain_runs(P, by, (branches | branches >> 4) & EVERY_PAIR, runs)
    return told_runs(P, by, samples, n_samples, runs[:k], certain != 0)


@kernel
def is_certain(by, followed, nearest):
    """Whether no other curve can pass an arm angle: none is left out, and none turns around close to it.

    Where limits cut them, rounding decides. `nearest` is what `find_at_angle` returns.
    """
    return followed.are_all and not by.respect and nearest > CLOSE_CALL


@kernel
def blur_of(by):
    """How far apart, rad, arm angles may be that are the same as well as floats tell.

    Any, where limits cut the curves: these are looked at last, and intervals have such arm angles.
    """
    return math.pi if by.respect else UNTOLD


@kernel
def is_here(P, by, q, ahead):
    """Whether an arm angle that is so far ahead of that of a posture is the same as well as floats tell, rad.

    It is told the worse the closer the elbow is to the line S-W, and the posture itself next to a straight elbow; but
    where the elbow is elsewhere, by more than on the other side of that line, so is the arm angle.
    """
    off_line = norm(elbow_across(P, q, by.target.place[0]))
    elsewhere = off_line * abs(math.sin(0.5 * ahead)) > ON_LINE * P[FAR]
    if abs(ahead) < SAME_ANGLE or abs(ahead) > blur_of(by) or elsewhere:
        return abs(ahead) < SAME_ANGLE
    t, sign = tangent_at(P, by, q)
    vague = vagueness(by.J, t, by.A)
    if sign != 0.0 and abs(ahead) < UNTOLD and abs(ahead) * off_line < OF_ROUNDING * P[FAR] * vague:
        return True
    # The way on which rounding moves the posture is left.
    told = sign != 0.0 and vague < math.inf and by.respect
    return told and abs(ahead) < APART * abs(rate_along(P, by, q, moved(NO_SEED, by.A, 1.0)))


@kernel
def passing(P, by, psi, a, b):
    """The posture between two of a curve at an arm angle that lies between theirs, and whether it is met.

    Postures are given with the way of the curve (`follow.between`) and with how far their arm angles are ahead.
    """
    start, ahead_a = a
    end, ahead_b = b
    q_a, q_b = start[0], end[0]
    R, p, place_ = by.target
    share = ahead_a / (ahead_a - ahead_b)
    chord = difference(q_a, q_b)
    start, end = (q_a, way_at(P, by, q_a, start[1])[0]), (q_b, way_at(P, by, q_b, end[1])[0])
    there = arc_between(P, by, start, end, share)
    q, met = close_at_angle(P, there, R, p, place_[0], place_[1], psi, STEPS, by.A)
    off = difference(q_a, q)
    if met and dot7(chord, chord) < SAME_POSTURE and dot7(off, off) < SAME_POSTURE:
        return q, True
    share = share_of_chord(q_a, q_b, q) if met else 2.0
    if 0.0 <= share <= 1.0:
        there, met = between(P, by, start, end, share)
        off = difference(there, q)
        if met and dot7(off, off) < SAME_CURVE:
            return q, True
    low, high, q, ahead = 0.0, 1.0, q_a, ahead_a
    for i in range(HALVINGS):
        share = low + (high - low) * (ahead_a / (ahead_a - ahead_b) if i % 3 != 2 else 0.5)
        q, met = between(P, by, start, end, share)
        if not met:
            return q, False
        ahead = short_way(angle_at(P, by, q) - psi)
        if abs(ahead) < SAME_ANGLE or high - low < 1e-12:
            break
        if ahead * ahead_a > 0.0:
            low, ahead_a = share, ahead
        else:
            high, ahead_b = share, ahead
    exact, met = close_at_angle(P, q, R, p, place_[0], place_[1], psi, STEPS, by.A)
    off = difference(q, exact)
    if met and dot7(off, off) < (SAME_POSTURE if abs(ahead) < SAME_ANGLE else CLOSE_BY):
        return exact, True
    return q, is_here(P, by, q, ahead)


@kernel
def keep_found(P, by, q, branch, goal, out):
    """Keep a posture in the row of the branch that it is told to be of, if it is the best one there.

    Next to several singularities a sample may be one to which no step comes closer, and yet miss its pose.
    """
    if max(*pose_error(P, q, by.target.R, by.target.p)) > SOLVED:
        return
    branch = branch if is_on_border(P, q, branch) else branch_of(P, q)
    q, value = cost_of_turn(P, q, goal)
    if value < out[branch, ROW_COST]:
        store7(row(out, branch), 0, q)
        out[branch, ROW_COST] = value


@kernel
def put_passing(P, by, psi, branch, ends, goal, out):
    """Keep the posture at an arm angle between two of a curve, given with how far they are ahead, if it lies there."""
    a, b = ends
    if a[1] * b[1] <= 0.0 and a[1] != b[1]:
        q, met = passing(P, by, psi, a, b)
        if met and by.respect:
            inside = inside_of_blur(P, by, q, BLURRED)
            q = inside if is_here(P, by, inside, short_way(angle_at(P, by, inside) - psi)) else q
        if met:
            keep_found(P, by, q, branch, goal, out)


@kernel
def look_between(P, by, followed, i, psi, goal, out):
    """Keep what is at an arm angle between the sample i - 1 and the next one.

    Returns how far these are from it, or the turning point between them if that is closer, rad.
    """
    told = followed.told
    at_a, at_b = told[i - 1, TOLD_PSI], told[i, TOLD_PSI]
    ahead_a = short_way(at_a - psi)
    ahead_b = ahead_a + short_way(at_b - at_a)
    start, end = load_end(followed.rows[i - 1]), load_end(followed.rows[i])
    a, b = start[0], end[0]
    rate_a, rate_b = told[i - 1, TOLD_RATE], told[i, TOLD_RATE]
    nearest = min(abs(ahead_a), abs(ahead_b))
    # Where the elbow passes close by the line S-W, the arm angle turns around before it and behind it.
    turns = 1 if rate_a * rate_b <= 0.0 else (2 if rate_a * (ahead_b - ahead_a) < 0.0 else 0)
    if turns == 1 and (nearest > NEAR_TURN or by.target.place[3] > WELL_BENT):
        way = difference(a, b)
        turns = 1 if nearest < FASTER * max(abs(rate_a), abs(rate_b)) * math.sqrt(dot7(way, way)) else 0
    if turns == 0 and ahead_a * ahead_b > 0.0 and nearest > blur_of(by):
        return nearest
    branch, next_branch = int(told[i - 1, TOLD_BRANCH]), int(told[i, TOLD_BRANCH])
    if is_here(P, by, a, ahead_a):
        keep_found(P, by, a, branch, goal, out)
    if is_here(P, by, b, ahead_b):
        keep_found(P, by, b, next_branch, goal, out)
    last, side = (start, ahead_a), 1.0 if rate_a > 0.0 else -1.0
    for _ in range(turns):
        turning = turning_between(P, by, a, b, side, ARM_ANGLE, (rate_a, rate_b))
        turning = inside_of_blur(P, by, turning, BLURRED)
        ahead = ahead_a + short_way(angle_at(P, by, turning) - at_a)
        here = (turning, NO_SEED), ahead
        put_passing(P, by, psi, branch, (last, here), goal, out)
        if is_here(P, by, turning, ahead):
            keep_found(P, by, turning, branch, goal, out)
        last, side, nearest = here, -side, min(nearest, abs(ahead))
    put_passing(P, by, psi, branch, (last, (end, ahead_b)), goal, out)
    return nearest


@kernel
def find_at_angle(P, by, followed, psi, wanted, goal, out):
    """Write the best posture of every branch at an arm angle, and its cost, into the rows of out (8, 8).

    Of one that is wanted (0 to 7), and of others only where they border on it. Returns how far the closest sample or
    turning point is, rad: farther from these, what is next to the arm angle is there too.
    """
    nearest = math.pi
    for branch in range(8):
        out[branch, ROW_COST] = 2.0 * NO_BRANCH
    runs, told, blur = followed.runs, followed.told, blur_of(by)
    for index in range(runs.shape[0]):
        first = int(runs[index, 3])
        last = int(runs[index, 4])
        if last - first == 1:  # a posture between two limits, alone
            q, ahead = load_sample(followed.rows[first]), short_way(told[first, TOLD_PSI] - psi)
            if is_here(P, by, q, ahead):
                keep_found(P, by, q, int(told[first, TOLD_BRANCH]), goal, out)
        for i in range(first + 1, last):
            if wanted < 0 or wanted in (int(told[i - 1, TOLD_BRANCH]), int(told[i, TOLD_BRANCH])):
                past, ahead = goes_past(told, i, psi, blur)
                nearest = min(nearest, ahead if past else look_between(P, by, followed, i, psi, goal, out))
    return nearest


@kernel
def best_found(found, wanted, seed):
    """Best of the postures in the rows of found (8, 8), or that of one branch (0 to 7): q, branch, cost."""
    best = best_row(found, 0, wanted)
    lowest = found[best, ROW_COST]
    return (read7(found[best]) if lowest < NO_BRANCH else seed), best, lowest


@kernel
def best_on_curves(P, by, followed, psi, wanted, goal, out):
    """The best posture at an arm angle over all branches, or in one (0 to 7): q, branch, cost.

    And whether there is no other for certain.
    """
    nearest = find_at_angle(P, by, followed, psi, wanted, goal, out)
    found = best_found(out, wanted, goal.seed)
    if wanted >= 0 and found[2] >= NO_BRANCH:
        # A curve that has just left the branch may come back to it.
        nearest = find_at_angle(P, by, followed, psi, -1, goal, out)
        found = best_found(out, wanted, goal.seed)
    return found, is_certain(by, followed, nearest)


@kernel
def curves_on_arcs(P, by, psi, branches):
    """The curves around an arm angle, as far as branches (bits) need them; none where arcs do not tell all.

    There the band of the nearest exact limb tells all but arcs next to singularities: the curves on these are followed
    alone.
    """
    place_ = by.target.place
    band = band_of(P, place_)
    if may_predict(P, place_, band) and not has_surface(P, place_):
        view = view_with(P, by.target, band)
        found = np.empty((arcs.MOST_ARCS, arcs.ARC))
        n = arcs.find_arcs(P, view, found)
        if n > 0 and arcs.mark_around(found, n, psi, branches):
            _, count = arcs.put_ends_of_arcs(P, view, found, n, 0)
            if count > 0:
                runs = np.empty((MAX_RUNS, RUN))
                samples, k = arcs.follow_arcs(P, by, arcs.LONGEST_ON_ARCS, (view.points, count), runs)
                if k > 0:
                    return told_runs(P, by, samples, int(runs[k - 1, 4]), runs[:k], True)
    return no_curves()
