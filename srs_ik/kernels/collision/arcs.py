"""Sets of arm angles: unions of arcs, kept as sorted pieces between -pi and pi that do not touch."""

import math

from srs_ik.kernels.exact.intervals import write_interval
from srs_ik.kernels.jit import kernel

PI = math.pi
TURN = 2.0 * math.pi


@kernel
def join_nearest(arcs, n):
    """Join the two pieces with the least gap between them, which only adds to the set; return how many are left."""
    best, gap = 0, math.inf
    for i in range(n - 1):
        if arcs[i + 1, 0] - arcs[i, 1] < gap:
            gap = arcs[i + 1, 0] - arcs[i, 1]
            best = i
    arcs[best, 1] = arcs[best + 1, 1]
    for i in range(best + 1, n - 1):
        arcs[i, 0], arcs[i, 1] = arcs[i + 1, 0], arcs[i + 1, 1]
    return n - 1


@kernel
def add_piece(arcs, n, lower, upper):
    """Add the angles from lower to upper, both between -pi and pi; return how many pieces there are."""
    if n == arcs.shape[0]:
        n = join_nearest(arcs, n)
    first = 0
    while first < n and arcs[first, 1] < lower:
        first += 1
    last = first
    while last < n and arcs[last, 0] <= upper:
        lower = min(lower, arcs[last, 0])
        upper = max(upper, arcs[last, 1])
        last += 1
    if last == first:
        for i in range(n, first, -1):
            arcs[i, 0], arcs[i, 1] = arcs[i - 1, 0], arcs[i - 1, 1]
        n += 1
    else:
        for i in range(last, n):
            arcs[first + 1 + i - last, 0], arcs[first + 1 + i - last, 1] = arcs[i, 0], arcs[i, 1]
        n -= last - first - 1
    arcs[first, 0], arcs[first, 1] = lower, upper
    return n


@kernel
def add_all(arcs):
    """Make it the whole circle."""
    arcs[0, 0], arcs[0, 1] = -PI, PI
    return 1


@kernel
def add_arc(arcs, n, middle, half):
    """Add the angles within `half` of a middle; return how many pieces there are."""
    if half >= PI:
        return add_all(arcs)
    lower = middle - half
    lower -= TURN * math.floor((lower + PI) / TURN)
    upper = lower + 2.0 * half
    if upper <= PI:
        return add_piece(arcs, n, lower, upper)
    n = add_piece(arcs, n, min(lower, PI), PI)
    return add_piece(arcs, n, -PI, upper - TURN)


@kernel
def add_complement(arcs, n, free, count):
    """Add all angles outside of another set; return how many pieces there are."""
    at = -PI
    for i in range(count):
        if free[i, 0] > at:
            n = add_piece(arcs, n, at, free[i, 0])
        at = free[i, 1]
    return add_piece(arcs, n, at, PI) if at < PI else n


@kernel
def is_all(arcs, n):
    """Whether a set is the whole circle."""
    return n == 1 and arcs[0, 0] <= -PI and arcs[0, 1] >= PI


@kernel
def contains(arcs, n, psi):
    """Whether an angle lies inside of a set, and not on an end."""
    psi -= TURN * math.floor((psi + PI) / TURN)
    for i in range(n):
        if arcs[i, 0] < psi < arcs[i, 1]:
            return True
    # -pi and pi are one angle.
    return (psi <= -PI or psi >= PI) and n > 0 and arcs[0, 0] <= -PI and arcs[n - 1, 1] >= PI


@kernel
def cut_one(branch, lower, upper, arcs, n, out, first, count):
    """Append what a set leaves of an interval of a branch to rows of out; return the number of rows in use."""
    if upper <= lower:
        return count if contains(arcs, n, lower) else write_interval(out, first, count, branch, lower, upper)
    at, head = lower, lower
    whole = upper - lower >= TURN
    for i in range(2 * n):
        shift = TURN if i >= n else 0.0
        start = arcs[i % n, 0] + shift
        end = arcs[i % n, 1] + shift
        if end <= at:
            continue
        if start >= upper:
            break
        if start > at:
            if whole and at == lower:
                # Cut open there, the circle's first free part belongs to its last one.
                head = start
            else:
                count = write_interval(out, first, count, branch, at, start)
        at = end
    if at < upper:
        if whole and at > lower:
            upper += head - lower if head > lower else 0.0
        return write_interval(out, first, count, branch, at, upper)
    return write_interval(out, first, count, branch, lower, head) if head > lower else count


@kernel
def cut(found, n, arcs, counts, out):
    """Intervals of all branches less the set of their elbow, sorted, into rows of out; return their number."""
    count, first, branch = 0, 0, -1
    for i in range(n):
        b = int(found[i, 0])
        if b != branch:
            branch, first = b, count
        elbow = b >> 2
        count = cut_one(b, found[i, 1], found[i, 2], arcs[elbow], counts[elbow], out, first, count)
    return count


@kernel
def angles_of(found, n, branches, arcs):
    """Write the arm angles of the first n intervals of some branches (bits) as one set: number of pieces."""
    count = 0
    for i in range(n):
        if (branches >> int(found[i, 0])) & 1 == 1:
            half = 0.5 * (found[i, 2] - found[i, 1])
            count = add_arc(arcs, count, found[i, 1] + half, half)
    return count


@kernel
def shared(first, second, taken, out):
    """Write what two sets share outside of a third one, each with its number of pieces, into out: how many they are."""
    count = 0
    for i in range(first[1]):
        for j in range(second[1]):
            at = max(first[0][i, 0], second[0][j, 0])
            end = min(first[0][i, 1], second[0][j, 1])
            for k in range(taken[1]):
                lower, upper = taken[0][k, 0], taken[0][k, 1]
                if upper <= at or lower >= end:
                    continue
                if lower > at:
                    count = append(out, count, at, lower)
                at = upper
                if at >= end:
                    break
            if at < end or (at == end and not contains(taken[0], taken[1], at)):
                count = append(out, count, at, end)
    return count


@kernel
def append(out, count, lower, upper):
    """Append a piece; the last one takes in what there is no room for."""
    if count == out.shape[0]:
        out[count - 1, 0] = min(out[count - 1, 0], lower)
        out[count - 1, 1] = max(out[count - 1, 1], upper)
        return count
    out[count, 0], out[count, 1] = lower, upper
    return count + 1
