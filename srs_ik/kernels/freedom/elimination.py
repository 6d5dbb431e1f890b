"""The equations of a step, solved for as many joints as there are of them: by elimination, eight figures at a time."""

from __future__ import annotations

from srs_ik.kernels.algebra.lanes import LANES, as_mask, eight_of, gather, one_of, scatter, where
from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.freedom import SYSTEM

RHS = SYSTEM - 1
"""Column of the right-hand side."""

INVERSE = 7
"""First column of the inverse, behind the seven of the joints."""

BASIC_ROW = 15
"""Row of work space: the joints that equations are solved for."""

FEWEST = 3
"""Independent equations at least: there is room for four ways along them."""

DEPENDENT = 1e-7
"""Pivots smaller than this, m and rad by rad, are none."""

CONTRADICTION = 1e-3
"""An equation that depends on others is left out where these leave no more than so much of it, m and rad: along a
straight arm, what is left of a pose depends on the square of what is left across it."""

ROOM_ROW, GIVES = 12, RHS - 1
"""Row of the system whose right-hand side says the same with joints on limits: a limit may be what keeps the pose
apart, and the multipliers tell which. Before it stands the weight by which equations that contradict each other give
way."""

SOFT = 1e-15
"""That weight, as a rule."""


@kernel
def write_equations(K, M, m, held, d):
    """Write the equations for the joints that are not held, the identity and what the steps of the others leave."""
    free = as_mask(~held & 0b1111111)
    for r in range(m):
        rest = K[7 + r, RHS]
        if held != 0:
            for j in range(7):
                if (held >> j) & 1 == 1:
                    rest -= K[7 + r, j] * d[j]
        joints = where(free, gather(row(K, 7 + r), 0, 1), 0.0)
        # The identity begins in the last of the first eight columns.
        scatter(row(M, r), 0, 1, where(as_mask(0b10000000 if r == 0 else 0), 1.0, joints))
        others = rest * eight_of(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
        scatter(row(M, r), LANES, 1, where(as_mask((1 << r) >> 1), 1.0, others))


@kernel
def pivot_of(M, m, done):
    """The largest figure of the equations that are not solved yet: its row, or -1 where they are dependent; its joint.

    All joints at once.
    """
    most = DEPENDENT + 0.0 * eight_of(0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0)
    lines = 0.0 * most - 1.0
    for r in range(m):
        if (done >> r) & 1 == 0:
            size = abs(gather(row(M, r), 0, 1))
            more = size > most
            lines, most = where(more, float(r), lines), where(more, size, most)
    line, column, largest = -1.0, -1, DEPENDENT
    for j in range(7):
        if one_of(most, j) > largest:
            line, column, largest = one_of(lines, j), j, one_of(most, j)
    return int(line), column


@kernel
def solve_equations(K, M, m, held, d):
    """Solve the equations for m of the joints that are not held, by elimination with pivots of all rows and columns.

    Rows 0 on of M come to hold the equations in terms of the others, the inverse and the right-hand sides; in a column
    that is solved for, there is anything.

    Returns:
        The bit set of these joints, or -1 where there are not so many; how many equations do not depend on others: they
        come to stand first.
    """
    write_equations(K, M, m, held, d)
    done, basic, rank = 0, 0, 0
    while rank < m:
        line, column = pivot_of(M, m, done)
        if line < 0:
            break
        here = row(M, line)
        share = 1.0 / M[line, column]
        joints, others = share * gather(here, 0, 1), share * gather(here, LANES, 1)
        for r in range(m):
            there = row(M, r)
            factor = M[r, column]
            if r != line:
                scatter(there, 0, 1, gather(there, 0, 1) - factor * joints)
                scatter(there, LANES, 1, gather(there, LANES, 1) - factor * others)
        scatter(here, 0, 1, joints)
        scatter(here, LANES, 1, others)
        M[BASIC_ROW, line] = column
        done |= 1 << line
        basic |= 1 << column
        rank += 1
    if rank < m:
        place = 0
        for r in range(m):
            if (done >> r) & 1 == 1:
                for j in range(SYSTEM):
                    M[place, j] = M[r, j]
                M[BASIC_ROW, place] = M[BASIC_ROW, r]
                place += 1
            elif abs(M[r, RHS]) > (CONTRADICTION if held == 0 else K[ROOM_ROW, RHS]):
                return -1, rank
        if rank < FEWEST:
            return -1, rank
    return basic, rank
