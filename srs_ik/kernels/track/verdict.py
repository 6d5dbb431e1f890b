"""What an update says: its status and reason, and the joint that stands out."""

from __future__ import annotations

from srs_ik.kernels.algebra.joint_vectors import apart
from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.track import (
    ACCELERATION,
    ASKED,
    BEHIND,
    ELSEWHERE,
    FORBIDDEN,
    GOAL,
    HELD,
    LIMITED,
    NO_REASON,
    NOWHERE,
    OK,
    ON,
    ON_THE_WAY,
    OTHER_POSTURE,
    OUT_OF_REACH,
    PERIOD,
    RECONFIGURE,
    SPEED,
    UNKNOWN,
    UNREACHABLE,
    V,
)
from srs_ik.kernels.limb.poses import read7
from srs_ik.kernels.track.freedom import out_of_reach

CLOSE = 1e-6
"""A goal or a tip that misses its target by less than this (m, rad) is said to be on it."""

USED_UP = 0.99
"""A joint that uses more than this share of its velocity or acceleration cannot move faster."""


@kernel
def most_behind(S, C, q):
    """The joint (1 to 7) that is farthest behind the goal, by its speed."""
    worst, most = 0, -1.0
    for j in range(7):
        behind = abs(S[GOAL + j] - q[j]) / C[SPEED + j]
        if behind > most:
            worst, most = j + 1, behind
    return worst


@kernel
def hardest(S, C, v):
    """The joint (1 to 7) that uses most of its velocity or acceleration, and its share of it."""
    worst, most = 0, -1.0
    for j in range(7):
        change = abs(v[j] - S[V + j]) / (C[ACCELERATION + j] * C[PERIOD])
        used = max(abs(v[j]) / C[SPEED + j], change)
        if used > most:
            worst, most = j + 1, used
    return worst, most


@kernel
def on_the_way(P, S, C, v, pose):
    """Status, reason, and the joint that uses most of its limits, of a tip that comes back to its target."""
    joint, used = hardest(S, C, v)
    if out_of_reach(P, C, pose):
        return UNREACHABLE, OUT_OF_REACH, joint
    if S[ASKED] == NOWHERE:
        return UNREACHABLE, FORBIDDEN, joint
    return LIMITED, BEHIND if used > USED_UP else ON_THE_WAY, joint


@kernel
def verdict(P, S, C, q, size, pose):
    """Status, reason, and the joint that is farthest behind."""
    if S[ON] == 1.0 or (size < CLOSE and apart(q, read7(row(S, GOAL))) < CLOSE):
        return OK, NO_REASON, 0
    joint = most_behind(S, C, q)
    if size < CLOSE:
        return LIMITED, BEHIND, joint
    if out_of_reach(P, C, pose):
        return UNREACHABLE, OUT_OF_REACH, joint
    if S[ELSEWHERE] == UNKNOWN:
        return LIMITED, ON_THE_WAY, joint
    if S[ELSEWHERE] == RECONFIGURE:
        return HELD, OTHER_POSTURE, joint
    return UNREACHABLE, FORBIDDEN, joint
