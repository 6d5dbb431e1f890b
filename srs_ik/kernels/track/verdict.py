"""What an update says: its status and reason, and the joint that stands out."""

from srs_ik.kernels.algebra.joint_vectors import apart
from srs_ik.kernels.algebra.pointers import read7, row
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout import track as at
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
        behind = abs(S[at.GOAL + j] - q[j]) / C[at.SPEED + j]
        if behind > most:
            worst, most = j + 1, behind
    return worst


@kernel
def hardest(S, C, v):
    """The joint (1 to 7) that uses most of its velocity or acceleration, and its share of it."""
    worst, most = 0, -1.0
    for j in range(7):
        change = abs(v[j] - S[at.V + j]) / (C[at.ACCELERATION + j] * C[at.PERIOD])
        used = max(abs(v[j]) / C[at.SPEED + j], change)
        if used > most:
            worst, most = j + 1, used
    return worst, most


@kernel
def on_the_way(P, S, C, v, pose):
    """Status, reason, and the joint that uses most of its limits, of a tip that comes back to its target."""
    joint, used = hardest(S, C, v)
    if out_of_reach(P, C, pose):
        return at.UNREACHABLE, at.OUT_OF_REACH, joint
    if S[at.ASKED] == at.NOWHERE:
        return at.UNREACHABLE, at.FORBIDDEN, joint
    return at.LIMITED, at.BEHIND if used > USED_UP else at.ON_THE_WAY, joint


@kernel
def verdict(P, S, C, q, size, pose):
    """Status, reason, and the joint that is farthest behind."""
    if S[at.ON] == 1.0 or (size < CLOSE and apart(q, read7(row(S, at.GOAL))) < CLOSE):
        return at.OK, at.NO_REASON, 0
    joint = most_behind(S, C, q)
    if size < CLOSE:
        return at.LIMITED, at.BEHIND, joint
    if out_of_reach(P, C, pose):
        return at.UNREACHABLE, at.OUT_OF_REACH, joint
    if S[at.ELSEWHERE] == at.UNKNOWN:
        return at.LIMITED, at.ON_THE_WAY, joint
    if S[at.ELSEWHERE] == at.RECONFIGURE:
        return at.HELD, at.OTHER_POSTURE, joint
    return at.UNREACHABLE, at.FORBIDDEN, joint
