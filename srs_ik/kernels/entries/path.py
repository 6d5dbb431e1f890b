"""Entry points for joint paths: the strips of all poses, the best way through them, and its refinement.

They take plain arrays, whatever their number; behind them, what travels together goes as one. All over, `poses` are
(n, 4, 4), `keys` (k,) those of them that count, `settings` (SETTINGS, 7), `limited` says whether there are velocity
limits, and `start` (k, 7) is the posture before the first one, or none. A path is `q` (n, 7), its arm angles `psi`
(n,), `branch` (n,), the least and largest arm angle of each, `bounds` (n, 2), the poses that it reaches, `chain` (k,),
and whether a posture has to stay, `fixed` (n,).
"""

import math

import numpy as np

from srs_ik.kernels.algebra.joint_vectors import along7, largest
from srs_ik.kernels.algebra.pointers import keep, read7, row, scratch
from srs_ik.kernels.chain.answer import measure_row
from srs_ik.kernels.chain.kinematics import pose_error
from srs_ik.kernels.chain.newton import CLOSED, LEFT, STEPS, clipped, close_free
from srs_ik.kernels.exact.samples import MAX_SAMPLES
from srs_ik.kernels.jit import entry
from srs_ik.kernels.layout import path as at
from srs_ik.kernels.layout.answer import GOOD_POSE, MAX_PIECES, ROW_ARM_ANGLE
from srs_ik.kernels.layout.limb import IS_CLOSED, IS_NEAR, LIMITED
from srs_ik.kernels.layout.path import Aim, Around, Course, Desk, Line, Rules, Sheet, Space, Span
from srs_ik.kernels.limb.branches import branch_of
from srs_ik.kernels.limb.limits import TURN
from srs_ik.kernels.limb.triangle import read_target, target_of
from srs_ik.kernels.path.between import between_two, follow_on, pose_change, write_own_bounds
from srs_ik.kernels.path.corridor import corridor, course_of, put_on_poses
from srs_ik.kernels.path.edges import most_of, path_cost, write_steps
from srs_ik.kernels.path.pose_strips import list_strips, pose_strips
from srs_ik.kernels.path.programme import advance, cheapest, first_costs, step_back, unbounded
from srs_ik.kernels.path.smoothing import smooth
from srs_ik.kernels.path.splits import put_split
from srs_ik.kernels.path.steps import rules_for
from srs_ik.kernels.path.strips import DEEPEST, GRID, SPACING, put_node, room_for_ends
from srs_ik.kernels.pose.moved import bridge_all

MOST_NODES = 16384
"""Most postures of a pose, with room for those of a run in all its turns."""

MOST_STRIPS = 2048
"""Most strips of a pose."""

KEY_CHANGE = 0.03
"""A path is planned at poses this far apart, rad."""

FARTHEST_KEY = 8
"""And at one of so many at least."""

CLOSES_WITHIN = 1e-6
"""A posture whose joints would move farther than this, rad, keeps the error of rounding that a limit left it with."""


@entry
def choose_keys(family, poses, has_known, keys, verdicts):
    """Mark the poses at which a path is planned: the ends, known ones, and one for every `KEY_CHANGE` of the pose."""
    P = row(family, LIMITED)
    n = poses.shape[0]
    target, verdicts[0] = read_target(P, row(poses, 0))
    if verdicts[0] != GOOD_POSE:
        return
    before = target.place
    keys[0] = True
    keys[n - 1] = True
    last = 0
    for i in range(1, n):
        target, verdicts[i] = read_target(P, row(poses, i))
        if verdicts[i] != GOOD_POSE:
            return
        here = target.place
        if has_known[i]:
            keys[i] = True
        if keys[i] or i - last > FARTHEST_KEY or pose_change(before, here) > KEY_CHANGE:
            if i - last > 1:
                keys[i - 1] = True
                last = i - 1
            if keys[i]:
                last = i
            before = here


@entry
def sweep(
    family,
    poses,
    keys,
    first,
    carried,
    stop,
    known,
    has_known,
    held,
    held_ends,
    held_alone,
    allowed,
    allowed_ends,
    near,
    radius,
    spacing,
    start,
    settings,
    limited,
    exact,
    nodes,
    cost,
    strips,
    ends,
):
    """Costs of all postures of the key poses from number `first` on, until the arrays are full.

    `carried` is the pose before it that is reached, as the arrays hold it already, at `ends[0]`; -1: none. In `ends` is
    then, of each pose from number `first` on, behind the one that is carried, the first row in `nodes`, one behind its
    last, and the same in `strips`. Another thread sets `stop` (1,) where nobody wants the answer any more; the arrays
    are then left as they are.

    Postures `known` (n, 7) are given where `has_known` (n,); `held` (h, HELD) are known, one pose after the other from
    `held_ends` (n + 1,) on, to the others of its strips, or where `held_alone` (n,) they are all there are. Strips have
    only the intervals `allowed` (m, 3), branch, lower and upper end, one pose after the other, of each from
    `allowed_ends` (n, 2) on to one behind its last, where that is not -1; (0, 2): all may be. They are finer around
    postures `near` (n, 7), so far as `radius` (n,), rad, 0: nowhere; joints move there by `spacing` (n,), rad, from one
    posture of a strip to the next at most. With `exact`, breaks are to be the shortest.

    Returns:
        The number of the next key pose, and the row in `ends` of the last one that is reached (0: none).
    """
    J, A = scratch(6, 7), scratch(16, 9)
    sheet = Sheet(nodes, np.zeros(nodes.shape[0], np.bool_), cost, strips)
    found, given = np.empty((8 * MAX_PIECES, 3)), np.full(2, -1)
    on_hold, turns, memo, stamp = (
        np.empty((DEEPEST, at.NODE)),
        np.zeros((3, 7)),
        np.zeros((2 * GRID, at.MEMO)),
        np.zeros(1),
    )
    desk = Desk(found, np.empty(MAX_SAMPLES), on_hold, turns, allowed, given, memo, stamp, room_for_ends(found))
    scales, told = settings.copy(), row(settings, 0)
    scaled = row(scales, 0)
    last = 0
    n, m = ends[0, 1], ends[0, 3]
    i = first
    while i < keys.shape[0] and n + MOST_NODES <= nodes.shape[0] and m + MOST_STRIPS <= strips.shape[0]:
        slot = i - first + 1
        if slot >= ends.shape[0] or stop[0]:
            break
        pose = keys[i]
        if allowed_ends.shape[0] > 0:
            given[0], given[1] = allowed_ends[pose, 0], allowed_ends[pose, 1]
        ends[slot, 0], ends[slot, 2] = n, m
        if has_known[pose]:
            put_node(nodes, n, read7(row(known, pose)), 0.0, -1)
            n += 1
        else:
            if not held_alone[pose]:
                around = Around(read7(row(near, pose)), radius[pose], spacing[pose])
                stamp[0] += 1.0
                n = pose_strips(family, row(poses, pose), around, sheet, n, desk, J, A)
            for k in range(held_ends[pose], held_ends[pose + 1]):
                if n >= nodes.shape[0]:
                    break
                put_node(nodes, n, read7(row(held, k)), held[k, at.HELD_PSI], int(held[k, at.HELD_BRANCH]))
                sheet.linked[n] = held[k, at.HELD_LINKED] != 0.0
                n += 1
                if not held_alone[pose]:
                    n = put_split(row(family, LIMITED), sheet, n - 1, SPACING, n)
        m = list_strips(sheet, ends[slot, 0], n, m)
        ends[slot, 1], ends[slot, 3] = n, m
        if n > ends[slot, 0]:
            now = Span(ends[slot, 0], n, ends[slot, 2], m)
            if carried < 0:
                first_costs(sheet, now, start, told)
            else:
                before = Span(ends[last, 0], ends[last, 1], ends[last, 2], ends[last, 3])
                unbounded(cost, now)
                advance(sheet, before, now, rules_for(told, scaled, pose - carried, limited), exact)
            carried, last = pose, slot
        i += 1
    keep(scales)
    return i, last


@entry
def go_back(keys, first, count, following, settings, limited, nodes, cost, strips, ends, q, psi, branch, bounds):
    """Write the best way's postures of `count` key poses from number `first` on, from the last one to the first.

    Nodes, costs, strips and their ends are those of `sweep`. The posture of the pose `following` behind these is known
    already; -1: the cheapest last posture is taken. Branches are -1 where a posture was given.

    Returns:
        The first pose of these that is reached, or `following`; and the least cost if there was none behind these.
    """
    sheet = Sheet(nodes, cost, cost, strips)
    scales, told = settings.copy(), row(settings, 0)
    scaled = row(scales, 0)
    least = -1.0
    for j in range(count, 0, -1):
        if ends[j, 0] == ends[j, 1]:
            continue
        pose = keys[first + j - 1]
        span = Span(ends[j, 0], ends[j, 1], ends[j, 2], ends[j, 3])
        if following < 0:
            best = float(cheapest(cost, span.first, span.last))
            least = cost[int(best)]
        else:
            _, best = step_back(row(q, following), sheet, span, rules_for(told, scaled, following - pose, limited))
        k = math.floor(best)
        t = best - k
        next_row = k + 1 if t > 0.0 else k
        for i in range(7):
            q[pose, i] = nodes[k, i] + t * (nodes[next_row, i] - nodes[k, i])
        psi[pose] = nodes[k, at.NODE_PSI] + t * (nodes[next_row, at.NODE_PSI] - nodes[k, at.NODE_PSI])
        branch[pose] = int(nodes[k, at.NODE_BRANCH])
        for s in range(span.first_strip, span.last_strip):
            if strips[s, at.STRIP_FIRST] <= k <= strips[s, at.STRIP_LAST]:
                low, high = (
                    nodes[int(strips[s, at.STRIP_FIRST]), at.NODE_PSI],
                    nodes[int(strips[s, at.STRIP_LAST]), at.NODE_PSI],
                )
                # The whole circle has no ends.
                bounds[pose, 0] = low if low > -math.pi else -math.inf
                bounds[pose, 1] = high if abs(high) != math.pi else math.inf
        following = pose
    keep(scales)
    return following, least


@entry
def fill_between(family, poses, keys, reached, settings, q, psi, branch, bounds, missed):
    """Fill in the poses between key poses that are reached: postures near the straight line from one to the other.

    Strips may have been cut: those of an exact limb have the ends of their intervals behind it. Marks in `missed` where
    there is none, and writes the point of that line; other arguments as in `go_back`.
    """
    P, J, A = row(family, LIMITED), scratch(6, 7), scratch(16, 9)
    course = Course(poses, keys, reached, bounds, np.empty((0, at.SIDE)))
    line = Line(q, psi, branch)
    last = -1
    for number in range(keys.shape[0]):
        pose = keys[number]
        if not reached[pose]:
            if last >= 0 or number > 0:
                for i in range(keys[number - 1] + 1, pose):
                    missed[i] = True
            last = -1
            continue
        if P[IS_NEAR] == 0.0:
            write_own_bounds(family, course, line, pose)
        if number > 0 and last < 0:
            for i in range(keys[number - 1] + 1, pose):
                missed[i] = True
        if last >= 0:
            for i in range(last + 1, pose):
                missed[i] = not follow_on(family, course, line, (last, i, pose), row(settings, 0), J, A)
                reached[i] = not missed[i]
                if missed[i]:
                    between_two(line, (last, i, pose), row(settings, 0))
        last = pose


@entry
def refine(family, poses, chain, fixed, bounds, widths, enough, start, settings, limited, q, psi, branch):
    """Move the postures of a path, in place, to the best ones near them.

    `widths` (m,) are those of the corridors, one after the other. Where squared joint steps are all that counts, all
    arm angles move at once in the end, until a part `enough` of the cost is left to gain; with 0 they do not.
    The others are those of `corridor`. Returns the cost.
    """
    space = Space(scratch(6, 7), scratch(16, 9))
    course = course_of(row(family, LIMITED), poses, chain, fixed, bounds, branch)
    line = Line(q, psi, branch)
    told = row(settings, 0)
    rules = Rules(told, limited, 1.0)
    put_on_poses(family, course, line, space)
    lowest = path_cost(chain, start, told, limited, q)
    for width in widths:
        q_before, psi_before = q.copy(), psi.copy()
        corridor(family, course, line, width, start, rules, space)
        total = path_cost(chain, start, told, limited, q)
        if total > lowest:
            q[:] = q_before
            psi[:] = psi_before
        else:
            lowest = total
    if enough > 0.0:
        lowest = smooth(family, course, line, start, Aim(at.SQUARES, told, enough, np.empty(0, np.bool_)), told, space)
        lowest = path_cost(chain, start, told, False, q)
    return lowest


@entry
def polish(family, poses, chain, fixed, loose, bounds, start, settings, kind, scale, weights, enough, q, psi, branch):
    """Move all postures of a path at once, in place, to what makes a kind of sum least, by barriers less and less wide.

    The kind is `WITHIN`, `LARGEST` or `SLOWEST`, of joint steps multiplied by `scale` (7,); steps to poses that are
    `loose` (k,) are breaks, for which no limits hold. Barriers have `weights` (w,), one after the other; none follows
    once the largest step counts no more than `enough`.

    Returns:
        The value with the last barrier; 1e300 where the path begins beyond its limits.
    """
    space = Space(scratch(6, 7), scratch(16, 9))
    course = course_of(row(family, LIMITED), poses, chain, fixed, bounds, branch)
    line = Line(q, psi, branch)
    lowest, steps = 0.0, np.empty((chain.shape[0], 7))
    first = 0 if start.shape[0] > 0 else 1
    for weight in weights:
        aim = Aim(kind, row(scale, 0), weight, loose)
        lowest = smooth(family, course, line, start, aim, row(settings, 0), space)
        write_steps(chain, start, row(settings, 0), q, steps)
        if kind == at.LARGEST and most_of(aim, steps, first, chain.shape[0]) <= enough:
            break
    return lowest


@entry
def bridge(family, poses, starts, met):
    """Take postures (n, 7), in place, to poses (n, 4, 4) inside the limits; `met` (n,) says which meet theirs then."""
    bridge_all(row(family, LIMITED), poses, starts, met, scratch(6, 7), scratch(16, 9))


@entry
def finish(family, poses, chain, q, psi, branch, out):
    """Write the rows (n, ROW) of the postures of a path, those of a near limb closed on the true chain once more."""
    P, J, A = row(family, LIMITED), scratch(6, 7), scratch(16, 9)
    for c in range(chain.shape[0]):
        i = chain[c]
        target = target_of(P, row(poses, i))
        here = clipped(P, read7(row(q, i)))
        if P[IS_NEAR] != 0.0:
            error = max(*pose_error(P, here, target.R, target.p))
            if error > CLOSED:
                closed, _ = close_free(P, here, target.R, target.p, True, 2 * STEPS, J, A)
                if error > LEFT or largest(along7(closed, -1.0, here)) < CLOSES_WITHIN:
                    here = closed
        number = branch[i] if branch[i] >= 0 else branch_of(P, here)
        measure_row(P, target, here, number, 0.0, True, row(out, i))
        if P[IS_CLOSED] == 1.0 and branch[i] >= 0:
            out[i, ROW_ARM_ANGLE] = psi[i] - TURN * math.floor((psi[i] + math.pi) / TURN)
