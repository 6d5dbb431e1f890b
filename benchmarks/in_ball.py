"""The postures of a pose nearest to a seed, by descent from many starts, compiled by Numba: no kernel of the package.

What is nearer to a seed than an answer lies in the ball around the seed through that answer. From postures all over it
shortest steps lead to the pose, clipped to the limits, and from there steps along the set of its postures to where none
is nearer. A null space is told by orthogonal rows, so that joints 1e-12 rad from singular do not look singular.
"""

from __future__ import annotations

import numpy as np
from numba import njit

TURN = 2.0 * np.pi
LONGEST = 0.3
"""Longest step, rad."""

MET, ENOUGH = 1e-14, 1e-13
"""Steps end at the first of these errors, m and rad; a posture is one below the second."""

ROUGH = 1e-4
"""Steps are damped above this error."""

CLOSING, AGAIN = 80, 12
"""Steps to the pose from a start, and from a step along its postures."""

DESCENT, HALVINGS = 80, 14
STILL = 1e-9
"""Steps along the postures of a pose, how often one is shortened, and where none is worth while, rad."""

STRIDE = 0.06
MOST_STRIDES, MOST_SEEN, MOST_STARTS = 600, 6000, 6000
"""Steps along all postures of a pose, rad, and how many at most in one direction, in all; starts that are kept."""

EXCESS = 1e4
"""What squared rad outside limits weigh more than those from the seed, where starts are chosen."""

REACH = 0.3
"""Starts farther outside the limits, and farther from the seed, than this, rad, are left out."""

SAME = 1e-4
"""A minimum this close to one that is known, rad, is that one."""


@njit(cache=True, nogil=True)
def frames(chain, q, at_axes, at_points, R, p):
    """Axes and points on them, each (3, 7), tip rotation and tip of a posture."""
    axes, points, squares, tip, R_tip = chain
    T, shift, K = np.eye(3), np.zeros(3), np.empty((3, 3))
    for j in range(7):
        for i in range(3):
            at_axes[i, j] = T[i, 0] * axes[j, 0] + T[i, 1] * axes[j, 1] + T[i, 2] * axes[j, 2]
            at_points[i, j] = T[i, 0] * points[j, 0] + T[i, 1] * points[j, 1] + T[i, 2] * points[j, 2] + shift[i]
        s, v = np.sin(q[j]), 2.0 * np.sin(0.5 * q[j]) ** 2
        x, y, z = axes[j]
        for i in range(3):
            a, b, c = T[i]
            K[i, 0] = a + s * (b * z - c * y) + v * (a * squares[j, 0, 0] + b * squares[j, 1, 0] + c * squares[j, 2, 0])
            K[i, 1] = b + s * (c * x - a * z) + v * (a * squares[j, 0, 1] + b * squares[j, 1, 1] + c * squares[j, 2, 1])
            K[i, 2] = c + s * (a * y - b * x) + v * (a * squares[j, 0, 2] + b * squares[j, 1, 2] + c * squares[j, 2, 2])
        T[:] = K
        for i in range(3):
            shift[i] = at_points[i, j] - (T[i, 0] * points[j, 0] + T[i, 1] * points[j, 1] + T[i, 2] * points[j, 2])
    for i in range(3):
        p[i] = T[i, 0] * tip[0] + T[i, 1] * tip[1] + T[i, 2] * tip[2] + shift[i]
        for k in range(3):
            R[i, k] = T[i, 0] * R_tip[0, k] + T[i, 1] * R_tip[1, k] + T[i, 2] * R_tip[2, k]


@njit(cache=True, nogil=True)
def twist_to(chain, pose, q, e, J):
    """The (6,) twist from a posture's pose to another one, and its Jacobian (6, 7); returns its largest component."""
    at_axes, at_points, R, p, D = np.empty((3, 7)), np.empty((3, 7)), np.empty((3, 3)), np.empty(3), np.empty((3, 3))
    frames(chain, q, at_axes, at_points, R, p)
    for i in range(3):
        for k in range(3):
            D[i, k] = pose[i, 0] * R[k, 0] + pose[i, 1] * R[k, 1] + pose[i, 2] * R[k, 2]
    sx, sy, sz = 0.5 * (D[2, 1] - D[1, 2]), 0.5 * (D[0, 2] - D[2, 0]), 0.5 * (D[1, 0] - D[0, 1])
    sine, cosine = np.sqrt(sx * sx + sy * sy + sz * sz), 0.5 * (D[0, 0] + D[1, 1] + D[2, 2] - 1.0)
    angle = np.arctan2(sine, cosine)
    scale = angle / sine if sine > 1e-9 else 1.0
    e[3], e[4], e[5] = sx * scale, sy * scale, sz * scale
    if angle > np.pi - 1e-8:
        e[5] = np.pi  # about whichever axis: a half turn is no zero
    for i in range(3):
        e[i] = pose[i, 3] - p[i]
    for j in range(7):
        x, y, z = p[0] - at_points[0, j], p[1] - at_points[1, j], p[2] - at_points[2, j]
        a, b, c = at_axes[0, j], at_axes[1, j], at_axes[2, j]
        J[0, j], J[1, j], J[2, j] = b * z - c * y, c * x - a * z, a * y - b * x
        J[3, j], J[4, j], J[5, j] = a, b, c
    return np.abs(e).max()


@njit(cache=True, nogil=True)
def damped(J, e, fixed, damping, step):
    """The step of damped least squares by joints that are not fixed."""
    A, y = np.empty((6, 6)), e.copy()
    for i in range(6):
        for k in range(i + 1):
            total = damping if i == k else 0.0
            for j in range(7):
                if not fixed[j]:
                    total += J[i, j] * J[k, j]
            A[i, k] = total
    for i in range(6):
        for k in range(i + 1):
            total = A[i, k]
            for m in range(k):
                total -= A[i, m] * A[k, m]
            A[i, k] = np.sqrt(max(total, 1e-300)) if i == k else total / A[k, k]
    for i in range(6):
        for m in range(i):
            y[i] -= A[i, m] * y[m]
        y[i] /= A[i, i]
    for i in range(5, -1, -1):
        for m in range(i + 1, 6):
            y[i] -= A[m, i] * y[m]
        y[i] /= A[i, i]
    for j in range(7):
        step[j] = 0.0
        if not fixed[j]:
            for i in range(6):
                step[j] += J[i, j] * y[i]


@njit(cache=True, nogil=True)
def orthogonal(J, fixed, Q, L, order):
    """Orthogonal rows Q of the Jacobian of joints that are not fixed, J[order] = L Q, the largest first: their number.

    Rows that depend on others but for rounding are left out.
    """
    rows = J.copy()
    for j in range(7):
        if fixed[j]:
            rows[:, j] = 0.0
    for i in range(6):
        order[i] = i
    for i in range(6):
        best, longest = i, -1.0
        for k in range(i, 6):
            size = 0.0
            for j in range(7):
                size += rows[k, j] ** 2
            if size > longest:
                best, longest = k, size
        order[i], order[best] = order[best], order[i]
        for j in range(7):
            rows[i, j], rows[best, j] = rows[best, j], rows[i, j]
        for k in range(i):
            L[i, k], L[best, k] = L[best, k], L[i, k]
        for k in range(i):  # once more: what rounding has left of those before
            share = 0.0
            for j in range(7):
                share += Q[k, j] * rows[i, j]
            L[i, k] += share
            for j in range(7):
                rows[i, j] -= share * Q[k, j]
        size = 0.0
        for j in range(7):
            size += rows[i, j] ** 2
        size = np.sqrt(size)
        if size < 1e-14:
            return i
        L[i, i] = size
        for j in range(7):
            Q[i, j] = rows[i, j] / size
        for k in range(i + 1, 6):
            share = 0.0
            for j in range(7):
                share += Q[i, j] * rows[k, j]
            L[k, i] = share
            for j in range(7):
                rows[k, j] -= share * Q[i, j]
    return 6


@njit(cache=True, nogil=True)
def shortest(J, e, fixed, step):
    """The shortest step by joints that are not fixed."""
    Q, L, order, y = np.zeros((6, 7)), np.zeros((6, 6)), np.empty(6, np.int64), np.zeros(6)
    rank = orthogonal(J, fixed, Q, L, order)
    step[:] = 0.0
    for i in range(rank):
        y[i] = e[order[i]]
        for k in range(i):
            y[i] -= L[i, k] * y[k]
        y[i] /= L[i, i]
        for j in range(7):
            step[j] += y[i] * Q[i, j]


@njit(cache=True, nogil=True)
def close(chain, pose, lower, upper, q, steps):
    """Move a posture into a pose by shortest steps inside limits; its error."""
    e, J, step, fixed, best = np.empty(6), np.empty((6, 7)), np.empty(7), np.zeros(7, np.bool_), q.copy()
    least, since = np.inf, 0
    for _ in range(steps):
        error = twist_to(chain, pose, q, e, J)
        if error < least:
            since = 0 if error < 0.5 * least else since + 1
            least = error
            best[:] = q
        else:
            since += 1
        if least < MET or (least < ENOUGH and since > 0) or since > 8:
            break
        fixed[:] = False
        for _ in range(7):
            if error > ROUGH or fixed.sum() > 1:
                damped(J, e, fixed, 1e-14 + min(1e-4, 1e-2 * (e**2).sum()), step)
            else:
                shortest(J, e, fixed, step)
            more = False
            for j in range(7):
                out = (q[j] <= lower[j] and step[j] < 0.0) or (q[j] >= upper[j] and step[j] > 0.0)
                if out and not fixed[j]:
                    fixed[j] = more = True
            if not more:
                break
        size = np.abs(step).max()
        scale = min(1.0, LONGEST / max(size, 1e-300))
        for j in range(7):
            q[j] = min(max(q[j] + scale * step[j], lower[j]), upper[j])
    q[:] = best
    return least


@njit(cache=True, nogil=True)
def toward(J, q, seed, lower, upper, way):
    """The way from a posture to the seed, as far as it leads along the postures inside limits: its length."""
    Q, L, order, fixed = np.zeros((6, 7)), np.zeros((6, 6)), np.empty(6, np.int64), np.zeros(7, np.bool_)
    for _ in range(8):
        rank = orthogonal(J, fixed, Q, L, order)
        for j in range(7):
            way[j] = 0.0 if fixed[j] else seed[j] - q[j]
        for _ in range(2):
            for i in range(rank):
                share = 0.0
                for j in range(7):
                    share += Q[i, j] * way[j]
                for j in range(7):
                    way[j] -= share * Q[i, j]
        more = False
        for j in range(7):
            out = (q[j] <= lower[j] and way[j] < -1e-15) or (q[j] >= upper[j] and way[j] > 1e-15)
            if fixed[j]:
                way[j] = 0.0
            elif out:
                fixed[j] = more = True
        if not more:
            break
    return np.sqrt((way**2).sum())


@njit(cache=True, nogil=True)
def turn_to(q, seed, lower, upper):
    """Turn each joint by whole turns to the angle nearest to the seed that its limits allow, or break least."""
    for j in range(7):
        angle = q[j] - TURN * np.floor((q[j] - seed[j]) / TURN + 0.5)
        while angle > upper[j] and angle - TURN >= lower[j] - 0.5 * TURN:
            angle -= TURN
        while angle < lower[j] and angle + TURN <= upper[j] + 0.5 * TURN:
            angle += TURN
        q[j] = angle


@njit(cache=True, nogil=True)
def descend(chain, pose, lower, upper, seed, q, known, rests):
    """Steps from a posture to the one nearest to the seed around: the distance, and how far it may still be to go.

    Those are in vain, and left, that come to one of the known minima.
    """
    e, J, way, there, last = np.empty(6), np.empty((6, 7)), np.empty(7), np.empty(7), np.empty(7)
    twist_to(chain, pose, q, e, J)
    long = toward(J, q, seed, lower, upper, way)
    value, size = 0.5 * ((q - seed) ** 2).sum(), 1.0
    for _ in range(DESCENT):
        if long < STILL:
            break
        for i in range(len(known)):
            if rests[i] < 10.0 * STILL and np.abs(known[i] - q).max() < SAME:
                return np.inf, 0.0
        size = min(size, LONGEST / long)
        gained = False
        for _ in range(HALVINGS):
            for j in range(7):
                there[j] = min(max(q[j] + size * way[j], lower[j]), upper[j])
            error = close(chain, pose, lower, upper, there, AGAIN)
            new = 0.5 * ((there - seed) ** 2).sum()
            if error < ENOUGH and new < value - 1e-3 * size * long * long:
                gained = True
                break
            size *= 0.3
        if not gained:
            break
        last[:] = way
        moved = there - q
        gain = value - new
        q[:] = there
        value = new
        twist_to(chain, pose, q, e, J)
        long = toward(J, q, seed, lower, upper, way)
        bent = (moved * (last - way)).sum()
        size = (moved**2).sum() / bent if bent > 0.0 else 4.0 * size
        if gain < 1e-16:
            break
    return np.sqrt(2.0 * value), long


@njit(cache=True, nogil=True)
def along(J, before, way):
    """The unit step along the postures of a pose in the direction of another step."""
    Q, L, order, fixed = np.zeros((6, 7)), np.zeros((6, 6)), np.empty(6, np.int64), np.zeros(7, np.bool_)
    rank = orthogonal(J, fixed, Q, L, order)
    # Of what all rows leave, one way alone is told; of the last row alone, the one that it leaves with the others.
    way[:] = before
    for _ in range(3):
        for i in range(rank):
            way -= (Q[i] * way).sum() * Q[i]
        way /= max(np.sqrt((way**2).sum()), 1e-300)


@njit(cache=True, nogil=True)
def worth(q, seed, lower, upper, turned):
    """What a posture is worth as a start, its joints turned towards the seed: its distance, and far more its excess."""
    turned[:] = q
    turn_to(turned, seed, lower, upper)
    total = 0.0
    for j in range(7):
        out = max(lower[j] - turned[j], turned[j] - upper[j], 0.0)
        total += (turned[j] - seed[j]) ** 2 + EXCESS * out * out
    return total


@njit(cache=True, nogil=True)
def trace(chain, pose, lower, upper, seed, first, sense, seen, n, starts, m):
    """Follow postures of a pose from one to one side; keep what is passed, and what is locally the best start."""
    e, J, way, before, turned = np.empty(6), np.empty((6, 7)), np.empty(7), np.empty(7), np.empty(7)
    free = np.full(7, np.inf)
    q, there = first.copy(), np.empty(7)
    twist_to(chain, pose, q, e, J)
    _, _, V = np.linalg.svd(J)
    before[:] = sense * V[6]
    values = np.empty(3)
    values[:] = np.inf
    middle = np.empty(7)
    size = STRIDE
    for step in range(MOST_STRIDES):
        value = worth(q, seed, lower, upper, turned)
        values[0], values[1], values[2] = values[1], values[2], value
        if step > 0 and values[1] <= values[0] and values[1] < values[2] and m < len(starts):
            starts[m] = middle
            m += 1
        middle[:] = turned
        twist_to(chain, pose, q, e, J)
        along(J, before, way)
        while True:
            there[:] = q + size * way
            error = close(chain, pose, -free, free, there, AGAIN)
            off = np.sqrt(((there - q - size * way) ** 2).sum())
            if (error < ENOUGH and off < 0.5 * size) or size < 0.01 * STRIDE:
                break
            size *= 0.5
        if error > ENOUGH or off > 0.5 * size:
            break
        before[:] = way
        q[:] = there
        size = min(2.0 * size, STRIDE)
        if n < len(seen):
            seen[n] = q
            n += 1
        if step > 2:
            back = 0.0
            for j in range(7):
                d = q[j] - first[j]
                d -= TURN * np.floor(d / TURN + 0.5)
                back += d * d
            if back < STRIDE * STRIDE:
                break
    if m < len(starts):
        starts[m] = middle
        m += 1
    return n, m


@njit(cache=True, nogil=True)
def is_seen(q, seen, n):
    """Whether a posture has been passed, but for whole turns."""
    for i in range(n):
        total = 0.0
        for j in range(7):
            d = q[j] - seen[i, j]
            d -= TURN * np.floor(d / TURN + 0.5)
            total += d * d
            if total > STRIDE * STRIDE:
                break
        if total <= STRIDE * STRIDE:
            return True
    return False


@njit(cache=True, nogil=True)
def swept(chain, pose, lower, upper, seed, starts):
    """Starts (m, 7) along all postures of a pose, without regard to limits, to which other starts lead."""
    seen, found, n, m = np.empty((MOST_SEEN, 7)), np.empty((MOST_STARTS, 7)), 0, 0
    free, turned = np.full(7, np.inf), np.empty(7)
    for i in range(len(starts)):
        q = starts[i].copy()
        if close(chain, pose, -free, free, q, CLOSING) > ENOUGH:
            continue
        worth(q, seed, lower, upper, turned)
        if m < len(found):
            found[m] = turned
            m += 1
        if n < len(seen) and not is_seen(q, seen, n):
            seen[n] = q
            n += 1
            for sense in (-1.0, 1.0):
                n, m = trace(chain, pose, lower, upper, seed, q, sense, seen, n, found, m)
    return found[:m]


@njit(cache=True, nogil=True)
def settled(chain, pose, lower, upper, seed, starts, beyond):
    """Postures of a pose inside limits to which starts lead, (n, 7), no farther from a seed than some distance."""
    found, n = np.empty((len(starts), 7)), 0
    for i in range(len(starts)):
        q = np.minimum(np.maximum(starts[i], lower), upper)
        if np.abs(q - starts[i]).max() > REACH or ((q - seed) ** 2).sum() > (beyond + REACH) ** 2:
            continue
        if close(chain, pose, lower, upper, q, CLOSING) < ENOUGH and ((q - seed) ** 2).sum() <= beyond**2:
            found[n] = q
            n += 1
    return found[:n]


@njit(cache=True, nogil=True)
def minima(chain, pose, lower, upper, seed, starts):
    """Minima of the distance from a seed to which postures of a pose lead: (n, 7), and (n, 2) distance and rest."""
    found, figures, n = np.empty((len(starts), 7)), np.empty((len(starts), 2)), 0
    for i in range(len(starts)):
        q = starts[i].copy()
        away, rest = descend(chain, pose, lower, upper, seed, q, found[:n], figures[:n, 1])
        at = n
        for k in range(n):
            if np.abs(found[k] - q).max() < SAME:
                at = k
        if np.isfinite(away) and (at == n or away < figures[at, 0]):
            found[at] = q
            figures[at] = away, rest
            n = max(n, at + 1)
    return found[:n], figures[:n]
