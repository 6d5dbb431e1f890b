"""Entry points for joint paths: the strips of all poses, the best way through them, and its refinement."""

from __future__ import annotations

import math

import numpy as np

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.chain.answer import measure_row
from srs_ik.kernels.chain.kinematics import pose_error
from srs_ik.kernels.chain.newton import CLOSED, STEPS, clipped, close_free
from srs_ik.kernels.exact.samples import MAX_SAMPLES
from srs_ik.kernels.jit import entry
from srs_ik.kernels.layout.answer import GOOD_POSE, MAX_PIECES, ROW_ARM_ANGLE
from srs_ik.kernels.layout.limb import IS_CLOSED, LIMITED
from srs_ik.kernels.limb.branches import branch_of
from srs_ik.kernels.limb.limits import TURN
from srs_ik.kernels.limb.poses import read7, read_pose
from srs_ik.kernels.limb.triangle import place
from srs_ik.kernels.path.between import follow_on, pose_change
from srs_ik.kernels.path.corridor import corridor, put_on_poses
from srs_ik.kernels.path.pose_strips import list_strips, pose_strips
from srs_ik.kernels.path.programme import (
    BREAK,
    BY_CONTINUITY,
    BY_VELOCITY,
    INVERSE_PERIOD,
    INVERSE_SPEED,
    PERIOD,
    POWER,
    SETTINGS,
    advance,
    cheapest,
    first_costs,
    path_cost,
    scale_settings,
    step_back,
)
from srs_ik.kernels.path.smoothing import smooth
from srs_ik.kernels.path.strips import (
    DEEPEST,
    NODE,
    NODE_BRANCH,
    NODE_PSI,
    STRIP,
    STRIP_FIRST,
    STRIP_LAST,
    is_wide,
    put_node,
)

__all__ = [
    "BREAK",
    "BY_CONTINUITY",
    "BY_VELOCITY",
    "INVERSE_PERIOD",
    "INVERSE_SPEED",
    "NODE",
    "PERIOD",
    "POWER",
    "SETTINGS",
    "STRIP",
    "STRIP_FIRST",
]
"""What the search has to know of the kernels behind these."""

MOST_NODES = 4096
"""Most postures of a pose."""

MOST_STRIPS = 512
"""Most strips of a pose."""

KEY_CHANGE = 0.04
"""A path is planned at poses this far apart, rad."""

FARTHEST_KEY = 8
"""And at one of so many at least."""


@entry
def choose_keys(family, poses, has_known, keys, verdicts):
    """Mark the poses at which a path is planned: the ends, known ones, and one for every `KEY_CHANGE` of the pose."""
    P = row(family, LIMITED)
    n = poses.shape[0]
    R, p, verdicts[0] = read_pose(row(poses, 0))
    if verdicts[0] != GOOD_POSE:
        return
    before = place(P, R, p)
    keys[0] = True
    keys[n - 1] = True
    last = 0
    for i in range(1, n):
        R, p, verdicts[i] = read_pose(row(poses, i))
        if verdicts[i] != GOOD_POSE:
            return
        here = place(P, R, p)
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
    near,
    radius,
    seed,
    settings,
    limited,
    exact,
    J,
    A,
    nodes,
    cost,
    strips,
    ends,
):
    """Costs of all postures of the key poses from number `first` on, until the arrays are full.

    Args:
        family: packed limb.
        poses: (n, 4, 4).
        keys: (k,) the poses that count.
        first: number of the first key pose.
        carried: the pose before it that is reached, as the arrays hold it already, at `ends[0]`; -1: none.
        stop: (1,) set by another thread where nobody wants the answer any more; the arrays are then left as they are.
        known: (n, 7) postures that are given.
        has_known: (n,) where they are.
        near: (n, 7) postures around which strips are finer.
        radius: how far around, rad; 0: nowhere.
        seed: (7,) posture before the first one, or None.
        settings: (SETTINGS, 7).
        limited: whether there are velocity limits.
        exact: whether breaks are to be the shortest.
        J: (6, 7) work space, or None.
        A: (16, 9) work space, or None.
        nodes: (N, NODE) output.
        cost: (N,) output.
        strips: (M, STRIP) output.
        ends: (K, 4) output: of each pose from number `first` on, behind the one that is carried, the first row in
            `nodes`, one behind its last, and the same in `strips`.

    Returns:
        The number of the next key pose, and the row in `ends` of the last one that is reached (0: none).
    """
    P = row(family, LIMITED)
    wide = False
    for joint in range(7):
        wide = wide or is_wide(P, joint)
    linked = np.zeros(nodes.shape[0], np.bool_)
    found = np.empty((8 * MAX_PIECES, 3))
    work = (np.empty(MAX_SAMPLES), np.empty((DEEPEST, NODE)))
    turns = np.zeros(7)
    scaled = settings.copy()
    last = 0
    n, m = ends[0, 1], ends[0, 3]
    i = first
    while i < keys.shape[0] and n + MOST_NODES <= nodes.shape[0] and m + MOST_STRIPS <= strips.shape[0]:
        at = i - first + 1
        if at >= ends.shape[0] or stop[0]:
            break
        pose = keys[i]
        ends[at, 0] = n
        ends[at, 2] = m
        if has_known[pose]:
            put_node(nodes, n, read7(row(known, pose)), 0.0, -1)
            linked[n] = False
            m = list_strips(nodes, linked, n, n + 1, strips, m)
            n += 1
        else:
            n, m = pose_strips(
                family,
                row(poses, pose),
                read7(row(near, pose)),
                radius,
                found,
                nodes,
                linked,
                n,
                strips,
                m,
                work,
                turns,
                wide,
                J,
                A,
            )
        ends[at, 1] = n
        ends[at, 3] = m
        if ends[at, 1] > ends[at, 0]:
            if carried < 0:
                first_costs(nodes, cost, ends[at, 0], n, seed, settings)
            else:
                between = pose - carried
                scale_settings(settings, between, scaled)
                before = (ends[last, 0], ends[last, 1], ends[last, 2], ends[last, 3])
                now = (ends[at, 0], n, ends[at, 2], m)
                advance(nodes, cost, strips, before, now, scaled, limited, 1.0 / between, exact)
            carried = pose
            last = at
        i += 1
    return i, last


@entry
def go_back(keys, first, count, following, settings, limited, nodes, cost, strips, ends, q, psi, branch, bounds):
    """Write the best way's postures of `count` key poses from number `first` on, from the last one to the first.

    Args:
        keys: (k,) the poses that count.
        first: number of the first key pose.
        count: how many of them.
        following: the pose behind these whose posture is known already; -1: none, the cheapest last posture is taken.
        settings: (SETTINGS, 7).
        limited: whether there are velocity limits.
        nodes: (N, NODE) postures, from `sweep`, as the next three.
        cost: (N,).
        strips: (M, STRIP).
        ends: (K, 4).
        q: (n, 7) output.
        psi: (n,) output: arm angles.
        branch: (n,) output: branches, -1 where a posture was given.
        bounds: (n, 2) output: arm angles of the ends of the strip.

    Returns:
        The first pose of these that is reached, or `following`; and the least cost if there was none behind these.
    """
    scaled = settings.copy()
    least = -1.0
    for j in range(count, 0, -1):
        if ends[j, 0] == ends[j, 1]:
            continue
        pose = keys[first + j - 1]
        before = (ends[j, 0], ends[j, 1], ends[j, 2], ends[j, 3])
        if following < 0:
            at = float(cheapest(cost, before[0], before[1]))
            least = cost[int(at)]
        else:
            between = following - pose
            scale_settings(settings, between, scaled)
            _, at = step_back(row(q, following), nodes, cost, strips, before, scaled, limited, 1.0 / between)
        k = math.floor(at)
        t = at - k
        next_row = k + 1 if t > 0.0 else k
        for i in range(7):
            q[pose, i] = nodes[k, i] + t * (nodes[next_row, i] - nodes[k, i])
        psi[pose] = nodes[k, NODE_PSI] + t * (nodes[next_row, NODE_PSI] - nodes[k, NODE_PSI])
        branch[pose] = int(nodes[k, NODE_BRANCH])
        for s in range(before[2], before[3]):
            if strips[s, STRIP_FIRST] <= k <= strips[s, STRIP_LAST]:
                low, high = nodes[int(strips[s, STRIP_FIRST]), NODE_PSI], nodes[int(strips[s, STRIP_LAST]), NODE_PSI]
                # The whole circle has no ends.
                bounds[pose, 0] = low if low > -math.pi else -math.inf
                bounds[pose, 1] = high if abs(high) != math.pi else math.inf
        following = pose
    return following, least


@entry
def fill_between(family, poses, keys, reached, settings, q, psi, branch, bounds, missed, J, A):
    """Fill in the poses between key poses that are reached: postures near the straight line from one to the other.

    Marks in `missed` where there is none; other arguments as in `go_back`.
    """
    last = -1
    for number in range(keys.shape[0]):
        pose = keys[number]
        if not reached[pose]:
            if last >= 0 or number > 0:
                for i in range(keys[number - 1] + 1, pose):
                    missed[i] = True
            last = -1
            continue
        if number > 0 and last < 0:
            for i in range(keys[number - 1] + 1, pose):
                missed[i] = True
        if last >= 0:
            for i in range(last + 1, pose):
                reached[i] = follow_on(family, poses, last, i, pose, settings, q, psi, branch, bounds, J, A)
                missed[i] = not reached[i]
        last = pose


@entry
def refine(family, poses, chain, fixed, bounds, widths, even, seed, settings, limited, q, psi, branch, J, A):
    """Move the postures of a path, in place, to the best ones near them.

    `widths` (m,) are those of the corridors, one after the other; `even` says whether squared joint steps are all that
    counts, so that all arm angles move at once in the end. The others are those of `corridor`. Returns the cost.
    """
    put_on_poses(family, poses, chain, fixed, q, psi, branch, J, A)
    lowest = path_cost(chain, seed, settings, limited, q)
    for width in widths:
        q_before, psi_before = q.copy(), psi.copy()
        corridor(family, poses, chain, fixed, bounds, width, seed, settings, limited, q, psi, branch, J, A)
        total = path_cost(chain, seed, settings, limited, q)
        if total > lowest:
            q[:] = q_before
            psi[:] = psi_before
        else:
            lowest = total
    if even:
        lowest = smooth(family, poses, chain, fixed, bounds, seed, settings, q, psi, branch, J, A)
    return lowest


@entry
def finish(family, poses, chain, q, psi, branch, J, A, out):
    """Write the rows (n, ROW) of the postures of a path, those of a near limb closed on the true chain once more."""
    P = row(family, LIMITED)
    for c in range(chain.shape[0]):
        i = chain[c]
        R, p, _ = read_pose(row(poses, i))
        place_ = place(P, R, p)
        here = clipped(P, read7(row(q, i)))
        if J is not None:
            position, orientation = pose_error(P, here, R, p)
            if max(position, orientation) > CLOSED:
                here, _ = close_free(P, here, R, p, True, 2 * STEPS, J, A)
        number = branch[i] if branch[i] >= 0 else branch_of(P, here)
        measure_row(P, place_, R, p, here, number, 0.0, True, row(out, i))
        if P[IS_CLOSED] == 1.0 and branch[i] >= 0:
            out[i, ROW_ARM_ANGLE] = psi[i] - TURN * math.floor((psi[i] + math.pi) / TURN)
