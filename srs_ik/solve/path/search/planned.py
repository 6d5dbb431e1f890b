"""The search for a joint path: planned at some poses, filled in between, refined, and searched for again about it."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from srs_ik.inputs.poses import refuse_bad_poses
from srs_ik.kernels.entries import path as entries
from srs_ik.kernels.entries.pose import pack_limits
from srs_ik.kernels.layout.limb import LIMITED, LOOSE, SHIFT
from srs_ik.kernels.layout.path import BREAK, BY_CONTINUITY
from srs_ik.solve.path.problem import ROUNDED, Problem, Way, copy, nothing_held, worth
from srs_ik.solve.path.search.around import BESIDE, find_at, search_around, wider
from srs_ik.solve.path.search.blocks import Block, find_way, gone_back, held_in, through
from srs_ik.solve.path.search.bridges import bridged
from srs_ik.solve.path.search.finer import fine_everywhere, finer, is_whole
from srs_ik.solve.path.search.greedy import greedy_where_it_swings
from srs_ik.solve.path.search.missed import is_odd, smoothed_leaps, turned_on_the_spot
from srs_ik.solve.path.search.narrow import (
    Rest,
    costs_to_end,
    dear,
    find_narrow,
    held_about,
    held_below,
    held_between,
    is_in_slivers,
    worse,
)
from srs_ik.solve.path.search.on_curves import worth_of
from srs_ik.solve.path.search.polish import FINE, ROUGHLY, WIDTHS, improve
from srs_ik.solve.path.search.singular import side_by_side

SHORT = 32
"""A path of so many poses at most is planned at each of them, and with strips that are fine everywhere."""

DRAWN_OUT = 30.0
"""That limb is planned with limits drawn out by so many times this: else postures on two limits would be none of it."""

KEYS, NEAR_KEYS = 2, 3
"""Of key poses one after the other a path is planned at one of so many; on the true chain each costs ten times more."""

MOST_PLANNED = 0.6
"""If it is to be planned at a larger part of all poses, it may as well be planned at all."""

AS_PLANNED = 1.006
"""Between planned poses steps are straight, so that a plan costs less than any path: one so close to it is the best."""

CLOSE = 1.001
"""On an exact limb, a path that costs less than so many times its plan is not looked at any closer."""

AS_LITTLE = 0.9999
"""A path that costs less than so much of its plan says that strips miss what it does."""

FAR_ABOVE = 1.02
"""A path that costs so many times its plan is bettered first by poses between planned ones, in coarse strips."""

ROUNDS = 2
"""Poses between planned ones are planned too so often at most, where a path does something of its own there."""

LEFT = 0.002
"""What poses between planned ones add to the cost of a path may be left out up to this part of all."""

OTHER_ENDS = 8
"""So many strips of the last pose at most are tried as ends of a path beside the one that seems best."""

LET_IN = 1.02
"""Through slivers, fine strips hold what costs up to so many times the path at hand."""


def found(problem: Problem) -> Way:
    """The best path, planned at key poses, filled in between, and refined, with velocity limits in what steps cost."""
    if problem.free is None or problem.arm.closed:
        return planned(problem)
    # Strips of a near limb are cut to free intervals where its curves are known; else its nearest exact limb has some.
    way = planned(problem) if problem.held_alone is not None else None
    if way is None or worth(problem, way)[0]:
        other = planned(replace(problem, in_closed_form=True, **nothing_held()))
        close(problem, other)
        improve(problem, other)
        way = other if way is None else min(way, other, key=lambda each: worth_of(problem, each))
    return way


def as_exact(problem: Problem) -> Problem:
    """The problem on the nearest exact limb, its limits drawn out."""
    arm = problem.arm
    more = DRAWN_OUT * float(arm.family[LIMITED, SHIFT])
    lower, upper, family = arm.lower - more, arm.upper + more, arm.family.copy()
    for which in (LIMITED, LOOSE):
        pack_limits(family[which], lower, upper)
    return replace(problem, arm=replace(arm, family=family, lower=lower, upper=upper), in_closed_form=True)


def thinned(marks: NDArray[np.bool_], kept: NDArray[np.bool_], by: int) -> NDArray[np.bool_]:
    """Of poses that are marked one after the other one of so many, with both ends and those that are kept."""
    between = np.append(False, marks[:-1]) & np.append(marks[1:], False)
    return marks & (kept | ~between | (np.arange(len(marks)) % by == 0))


def keys_of(problem: Problem) -> NDArray[np.bool_]:
    """(n,) the poses at which a path is planned."""
    n = len(problem.T)
    marks, verdicts = np.zeros(n, np.bool_), np.zeros(n, np.int64)
    entries.choose_keys(problem.arm.family, problem.T, problem.has_known, marks, verdicts)
    refuse_bad_poses(verdicts)
    return marks


def close(problem: Problem, way: Way, keys: NDArray[np.int64] | None = None) -> NDArray[np.bool_]:
    """Take postures of a path to their poses, on the true chain and inside the limits; which of them could be."""
    keys = np.arange(len(way.q)) if keys is None else keys
    q, met = way.q[keys], np.zeros(len(keys), np.bool_)
    entries.bridge(problem.arm.family, problem.T[keys], q, met)
    way.q[keys] = q
    way.bounds[:] = -np.inf, np.inf
    way.psi[:] = 0.0
    way.branch[~problem.has_known] = 0
    return met


def planned(problem: Problem) -> Way:
    """`found` on the true chain, or on the nearest exact limb."""
    problem = replace(problem, two_turns={})
    way = planned_once(problem)
    more = side_by_side(problem)
    if more is not problem:
        way = min(way, planned_once(more), key=lambda each: worth(problem, each))
    return greedy_where_it_swings(problem, way)


def planned_once(problem: Problem) -> Way:
    """`planned` by the strips of a problem alone."""
    way, rest = planned_at_some(problem)
    if way is None:
        way = planned_everywhere(problem, problem)
    elif rest is not None or way.torn:
        way = min(planned_everywhere(problem, rest or problem, way), way, key=lambda each: worth(problem, each))
    elif is_odd(problem, way):
        way = smoothed_leaps(problem, way)
    return turned_on_the_spot(problem, way)


def planned_at_some(problem: Problem) -> tuple[Way | None, Problem | None]:
    """A path planned at some poses, if there is one without a break; and what is left to plan, if anything is."""
    marks = keys_of(problem)
    if problem.free is not None or len(problem.T) <= SHORT:
        return None, problem
    if not problem.is_near:
        if problem.even:
            return in_closed_form(problem, problem, thinned(marks, problem.has_known, KEYS))
        return in_closed_form(problem, problem, marks) if marks.mean() < MOST_PLANNED else (None, problem)
    if problem.arm.family[LIMITED, SHIFT] < ROUNDED:
        way, rest = in_closed_form(problem, as_exact(problem), thinned(marks, problem.has_known, KEYS))
        if rest is None:
            return way, None
    return sparse(problem, marks), None


def in_closed_form(problem: Problem, plan: Problem, marks: NDArray[np.bool_]) -> tuple[Way | None, Problem | None]:
    """A path planned on an exact limb at the poses that are marked, filled in between; and what is left to plan.

    Where it costs more than planned, it may be that chords of strips cost less, or that poses between planned ones do
    not let the path pass so straight. So strips are made finer, and such poses are planned too, from round to round.
    """
    keys, stands_in = np.flatnonzero(marks), plan is not problem
    told = far(plan, keys)
    way, blocks = through(told, keys, False)
    if not is_whole(way, keys):
        return None, problem
    least = way.cost
    best = filled(problem, way, keys, stands_in)
    if best is None:
        return None, problem
    missed = best.cost <= AS_LITTLE * least
    if not problem.even and (missed or best.cost >= CLOSE * least):
        return (search_around(problem, best), None) if best.cost < AS_PLANNED * least else (best, problem)
    if best.cost < CLOSE * least and not missed:
        improve(problem, best, FINE)
        return best, None
    best, last, torn = in_rounds(problem, plan, Plan(told, keys, blocks, least), best, missed)
    improve(problem, best, FINE)
    narrow = is_in_slivers(best) and not stands_in
    if narrow and (torn or (missed and best.cost >= CLOSE * last.least)):
        rest = last.costs_to_end(LET_IN * best.cost)
        others = ~np.isin(np.arange(len(problem.T)), last.keys)
        other, _ = find_narrow(problem, last.keys, last.blocks, rest, others)
        improve(problem, other, FINE)
        best = min(best, other, key=lambda each: each.cost)
    if best.cost < (CLOSE if narrow else AS_PLANNED) * last.least:
        return search_around(problem, best) if torn else best, None
    if stands_in:
        return best, problem
    rest = last.costs_to_end(best.cost)
    return best, replace(held_between(last.problem, last.keys, last.blocks, rest), settings=problem.settings)


class Plan(NamedTuple):
    """What a path was planned by at some poses, and what it costs by that."""

    problem: Problem  # in which poses between these may be passed
    keys: NDArray[np.int64]  # these poses
    blocks: list[Block]  # their strips
    least: float  # cost of the best way through them

    def costs_to_end(self, most: float) -> Rest:
        """What a path costs from each posture on, of those through which one leads that costs at most so much."""
        return costs_to_end(self.problem, self.blocks, most)


def in_rounds(problem: Problem, plan: Problem, last: Plan, best: Way, missed: bool) -> tuple[Way, Plan, bool]:
    """The best path by a plan that is made finer from round to round, what it was planned by last, whether that broke.

    `plan` is the problem on an exact limb; `best` is the path by the plan so far, `missed` whether it costs far less
    than that says.
    """
    stands_in = plan is not problem
    again, torn, fine = best, False, False
    in_slivers = missed and is_in_slivers(best) and not stands_in
    for _ in range(ROUNDS):
        marks = dear(problem, again, last.keys, LEFT * last.least) & (not in_slivers)
        marks[last.keys] = False
        if fine and (best.cost < AS_PLANNED * last.least or not marks.any()):
            break
        rest = last.costs_to_end(max(best.cost, CLOSE * last.least))
        more = np.union1d(last.keys, np.flatnonzero(marks))
        if fine or (marks.any() and best.cost > FAR_ABOVE * last.least and again is best):
            way, found = through(far(held_between(last.problem, last.keys, last.blocks, rest), more), more, False)
        else:
            way, found = find_narrow(last.problem, last.keys, last.blocks, rest, marks)
            fine = True
        torn = not is_whole(way, more)
        if torn:
            break
        value = way.cost
        again = filled(problem, way, more, stands_in) or copy(again)
        if fine:
            # Beside postures of finer strips, chords of coarse ones cost too much: they tell of a better path alone.
            last = Plan(far(plan, more), more, found, value)
        best = min(best, again, key=lambda each: each.cost)
    return best, last, torn


def filled(problem: Problem, way: Way, keys: NDArray[np.int64], stands_in: bool) -> Way | None:
    """A path that is planned at some poses on an exact limb, filled in between and improved; None where it cannot be.

    `stands_in`: that limb is not the arm's own.
    """
    if stands_in:
        # What the arm itself does not reach inside its limits is filled in like the rest.
        met = close(problem, way, keys)
        way.reached[keys[~met]] = False
        keys = keys[met]
        if not len(keys) or keys[0] > 0 or keys[-1] + 1 < len(way.q):
            return None
    missed = fill(problem, way, keys)
    if not missed.any():
        improve(problem, way, WIDTHS if stands_in else FINE, ROUGHLY)
        return way
    if stands_in:
        return None
    # Branches change there: fine strips about the straight line tell where.
    way.reached[:] = True
    way = find_at(problem, way, wider(missed, BESIDE))
    if way.cost >= 0.5 * BREAK or not way.reached.all():
        return None
    improve(problem, way, FINE, ROUGHLY)
    return way


def sparse(problem: Problem, apart: NDArray[np.bool_]) -> Way | None:
    """A path planned on the true chain at some of the poses `apart` (n,), filled in between; None where it breaks.

    More of these near which it costs more than planned are planned then too, in the end all; what is known of the
    strips of the others is kept. Poses between them come so close one after the other that chords of strips tell
    nothing of a path: they are planned, all of them, where a path through the others does not fit between these alone.
    """
    plan, best, marks = problem, None, thinned(apart, problem.has_known, NEAR_KEYS)
    apart = apart if apart.mean() < MOST_PLANNED else np.ones_like(apart)
    while True:
        keys = np.flatnonzero(marks)
        way, blocks = through(far(plan, keys), keys, False)
        if not is_whole(way, keys):
            # Strips of poses that are planned too may miss what a path touches that is whole.
            return None if best is None else search_around(problem, best)
        least, q = way.cost, way.q[keys]
        missed = fill(problem, way, keys)
        if not missed.any():
            improve(problem, way)
            best = way if best is None or way.cost < best.cost else best
            if best.cost < AS_PLANNED * least or marks[apart].all():
                return search_around(problem, in_finer(problem, best, keys, blocks))
            missed = worse(problem, way, keys, q)
        if best is None:
            plan = held_in(problem, keys, blocks)
        else:
            told = far(problem, keys)
            rest = costs_to_end(told, blocks, best.cost)
            plan = replace(held_about(told, keys, blocks, rest), settings=problem.settings)
        more = np.zeros_like(marks)
        more[apart] = wider(missed[apart])
        if (more & ~marks).any() and marks[apart].mean() < MOST_PLANNED:
            marks = marks | more
        else:
            marks = np.ones_like(marks) if marks[apart].all() else marks | apart


def in_finer(problem: Problem, best: Way, keys: NDArray[np.int64], blocks: list[Block]) -> Way:
    """A path planned at key poses, or a better one in finer strips of what costs no more."""
    told = far(problem, keys)
    fine = finer(held_below(told, keys, blocks, costs_to_end(told, blocks, best.cost), best.cost))
    way = find_way(fine, keys, False)
    if not is_whole(way, keys) or fill(problem, way, keys).any():
        return best
    improve(problem, way)
    return min(best, way, key=lambda each: each.cost)


def far(problem: Problem, keys: NDArray[np.int64]) -> Problem:
    """The problem with steps that are continuous from one pose to the next so far from one key pose to another."""
    settings = problem.settings.copy()
    # Two poses are counted already.
    settings[BY_CONTINUITY] *= max(1.0, 0.5 * float(np.diff(keys).max()))
    return replace(problem, settings=settings)


def fill(problem: Problem, way: Way, keys: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Fill in a path between the poses at which it is planned; (n,) where no posture is near the straight line."""
    missed, place = np.zeros(len(problem.T), np.bool_), (way.q, way.psi, way.branch, way.bounds)
    told = problem.family, problem.T, keys, way.reached, problem.settings
    entries.fill_between(*told, *place, missed)
    return missed


def planned_everywhere(problem: Problem, plan: Problem, known: Way | None = None) -> Way:
    """A path planned at every pose, with postures that strips miss and with breaks where there is no other way.

    `plan` is the problem with what is known of its strips, `known` a path without a break, if there is one.
    """
    arm, keys = problem.arm, np.arange(len(problem.T))
    may_bridge = problem.free is None and (arm.closed or not problem.in_closed_form)
    fine = plan
    if len(keys) <= SHORT:
        fine = fine_everywhere(problem, keys)
    way, blocks = through(fine, keys, False)
    if way.cost < 0.5 * BREAK:
        least, joined, may_join = way.cost, False, problem.even and fine is plan and not problem.is_near
        if may_join and known is not None and known.cost > AS_PLANNED * least:
            # What coarse strips tell of the best path, fine ones tell better; how much one costs is known.
            way = known
        else:
            improve(problem, way)
        if fine is not plan:
            way = with_other_end(problem, way, keys, blocks)
        if may_join and way.cost > AS_PLANNED * least:
            other, _ = find_narrow(problem, keys, blocks, costs_to_end(problem, blocks, way.cost))
            joined = other.cost < 0.5 * BREAK
            if joined:
                improve(problem, other)
                way = min(way, other, key=lambda each: each.cost)
        # Where fine strips of all that may cost as little join, those about a path tell nothing new.
        way = way if joined else search_around(problem, way)
        if not (may_bridge and way.torn):
            return smoothed_leaps(problem, way) if may_bridge and is_odd(problem, way) else way
    if may_bridge:
        more = bridged(problem)
        again = way if more is problem else find_way(more, keys, False)
        if again.cost < 0.5 * BREAK:
            improve(more, again)
            return min(way, search_around(more, again), key=lambda each: each.cost)
        if again.cost < way.cost - 0.5 * BREAK:
            problem, way = more, again
    if way.cost >= 0.5 * BREAK:
        walls = way.walls
        is_short = len(keys) <= SHORT and not problem.is_near
        way = find_way(fine_everywhere(problem, keys) if is_short else problem, keys, True)
        way.walls = walls
        improve(problem, way)
        way = search_around(problem, way)
    return way


def with_other_end(problem: Problem, way: Way, keys: NDArray[np.int64], blocks: list[Block]) -> Way:
    """A path, or one that ends in another strip and is better: before they are improved, two may seem as good."""
    numbers, least = blocks[-1].ends_at()
    for number in numbers[1:][least[1:] < way.cost][:OTHER_ENDS].tolist():
        other = gone_back(problem, keys, blocks, number)
        improve(problem, other)
        way = min(way, other, key=lambda each: worth(problem, each))
    return way
