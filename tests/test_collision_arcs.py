"""Arcs that spheres forbid, against brute force: turned points, dense sweeps, and roots by SciPy."""

import numpy as np
import pytest
from arms import generator
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

import srs_ik
from srs_ik.kernels.entries.collision import clearance, forbidden
from srs_ik.kernels.layout import collision as at

CLOSE = 1e-9
"""How far an end of an arc may be off, rad, where the clearance does not stand still there."""


class Made:
    """A few spheres on the upper arm, the forearm, the hand and in the room, and what is known of them by NumPy."""

    def __init__(self, arm, q, groups):
        self.arm, self.T = arm, arm.forward_kinematics(q).homogeneous
        self.q = np.asarray(q)
        rows = [np.atleast_2d(np.asarray(rows, float)) for _, rows in groups]
        balls = [[*r[:, :3].mean(axis=0), 0.0] for r in rows]
        for ball, r in zip(balls, rows, strict=True):
            ball[3] = (np.linalg.norm(r[:, :3] - ball[:3], axis=1) + r[:, 3]).max() + 1e-12
        self.bodies = np.concatenate([np.array(balls), *rows])
        starts = len(rows) + np.cumsum([0, *map(len, rows)])
        self.groups = np.zeros((len(rows), at.GROUP), np.int64)
        self.groups[:, at.FIRST], self.groups[:, at.LAST] = starts[:-1], starts[1:]
        self.groups[:, at.PLACE] = [place for place, _ in groups]
        n = len(rows)
        pairs = [(a, b) if groups[a][0] >= groups[b][0] else (b, a) for a in range(n) for b in range(a)]
        self.pairs = np.array([p for p in pairs if groups[p[0]][0] != groups[p[1]][0]], np.int64).reshape(-1, 2)
        self.slack = np.zeros(at.SLACK)
        self.work = np.empty((len(self.bodies), at.LOCAL_ROW)), np.empty(n, np.int64)

    def forbidden(self, margin):
        arcs, counts = np.empty((2, at.MOST_ARCS, 2)), np.empty(2, np.int64)
        self.slack[at.MARGIN] = margin
        forbidden(
            self.arm.packed.family, self.T, self.bodies, self.groups, self.pairs, self.slack, *self.work, arcs, counts
        )
        return [arcs[e, : counts[e]] for e in range(2)]

    def clearance(self, turn, elbow_psi):
        """Least clearance after the arm has been turned about S-W from the posture q, whose arm angle is given."""
        limb = self.arm.limb
        S, W = limb.shoulder, (self.T @ np.linalg.inv(limb.T_base_tip_zero) @ [*limb.wrist, 1.0])[:3]
        u = (W - S) / np.linalg.norm(W - S)
        frames, zero = self.arm.joint_frames(self.q), self.arm.joint_frames(np.zeros(7))
        R = Rotation.from_rotvec((turn - elbow_psi) * u).as_matrix()
        seen = []
        for first, last, place, _, _ in self.groups:
            k = (0, 7, 3, 4)[place]
            F = frames[k] @ np.linalg.inv(zero[k])
            c = self.bodies[first:last, :3] @ F[:3, :3].T + F[:3, 3]
            if place >= at.UPPER:
                c = (c - S) @ R.T + S
            seen.append((c, self.bodies[first:last, 3]))
        least = np.inf
        for a, b in self.pairs:
            gap = np.linalg.norm(seen[a][0][:, None] - seen[b][0][None], axis=2)
            least = min(least, float((gap - seen[a][1][:, None] - seen[b][1][None]).min()))
        return least


@pytest.fixture(scope="module")
def arm():
    return srs_ik.load("iiwa14")


def check(made, margin):
    psi = made.arm.arm_angle(made.q)
    elbow = made.arm.branch(made.q) >> 2
    arcs = made.forbidden(margin)[elbow]
    f = lambda x: made.clearance(x, psi) - margin  # noqa: E731
    for x in np.linspace(-np.pi, np.pi, 61):
        inside = bool(((arcs[:, 0] < x) & (x < arcs[:, 1])).any())
        near = len(arcs) and np.abs(np.angle(np.exp(1j * (arcs - x)))).min() < 1e-7
        value = f(x)
        if not near and abs(value) > 1e-9:
            assert inside == (value < 0.0), (x, value, arcs)
    for x in arcs.ravel():
        if abs(abs(x) - np.pi) < 1e-12:
            continue  # where the circle is cut open
        assert abs(f(x)) < 1e-9
        a, b = x - 1e-4, x + 1e-4
        if f(a) * f(b) < 0.0 and abs(f(b) - f(a)) > 1e-7:
            assert abs(brentq(f, a, b, xtol=1e-14) - x) < CLOSE


unit = st.floats(-1.0, 1.0, allow_nan=False)
sphere = st.tuples(unit, unit, unit, st.floats(0.0, 0.4))
angle = st.floats(-2.0, 2.0)


@pytest.mark.slow
@given(
    st.tuples(angle, angle, angle, st.floats(-2.0, -0.05) | st.floats(0.05, 2.0), angle, angle, angle),
    st.lists(sphere, min_size=1, max_size=3),
    st.lists(sphere, min_size=1, max_size=3),
    st.lists(sphere, min_size=1, max_size=4),
    st.lists(sphere, min_size=1, max_size=2),
    st.floats(0.0, 0.2),
)
@example(
    (0.1, 0.2, 0.3, -1.0, 0.1, 0.5, 0.1),
    [(0, 0, 0.6, 0.1)],
    [(0, 0, 1, 0.1)],
    [(0.5, 0, 0.5, 0.0)],
    [(0, 0, 1.3, 0)],
    0,
)
def test_arcs_are_those_of_brute_force(q, upper, fore, room, hand, margin):
    arm = srs_ik.load("iiwa14")
    made = Made(arm, q, [(at.BASE, room), (at.TIP, hand), (at.UPPER, upper), (at.FORE, fore)])
    check(made, margin)


@pytest.mark.slow
@given(st.integers(0, 10_000), st.sampled_from(["human_arm", "iiwa14"]))
def test_arcs_of_other_limbs(number, name):
    arm, rng = srs_ik.load(name), generator(name, number)
    q = rng.uniform(-2.0, 2.0, 7)
    q[3] = rng.choice([-1, 1]) * rng.uniform(0.1, 2.0)
    groups = [
        (place, np.column_stack([rng.uniform(-0.8, 0.8, (3, 3)), rng.uniform(0.0, 0.15, 3)]))
        for place in (at.BASE, at.BASE, at.UPPER, at.FORE)
    ]
    check(Made(arm, q, groups), rng.choice([0.0, 0.03]))


def test_a_sphere_on_the_line_forbids_all_or_nothing(arm):
    q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    T = arm.forward_kinematics(q).homogeneous
    S, W = arm.limb.shoulder, (T @ np.linalg.inv(arm.limb.T_base_tip_zero) @ [*arm.limb.wrist, 1.0])[:3]
    elbow = arm.joint_frames(np.zeros(7))[4, :3, 3]
    for along in (0.2, 0.5, 0.9):
        point = S + along * (W - S)
        made = Made(arm, q, [(at.BASE, [*point, 0.05]), (at.UPPER, [*elbow, 0.05])])
        off = made.clearance(0.0, 0.0)
        assert all(len(arcs) == 0 for arcs in made.forbidden(off - 1e-9))
        side = arm.branch(q) >> 2
        assert np.array_equal(made.forbidden(off + 1e-9)[side], [[-np.pi, np.pi]])


@pytest.mark.slow
def test_spheres_that_touch_leave_a_point_or_nothing(arm):
    q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    made = Made(arm, q, [(at.BASE, [0.5, 0.3, 0.5, 0.05]), (at.UPPER, [0.0, 0.0, 0.7, 0.05])])
    psi = arm.arm_angle(q)
    values = [made.clearance(x, psi) for x in np.linspace(-np.pi, np.pi, 2001)]
    side = arm.branch(q) >> 2
    assert len(made.forbidden(max(min(values) - 1e-6, 0.0))[side]) == 0
    (arc,) = made.forbidden(min(values) + 1e-6)[side][:1]
    assert 0.0 < arc[1] - arc[0] < 0.05
    almost = made.forbidden(max(values) - 1e-9)[side]
    assert 0.0 < 2 * np.pi - np.diff(almost, axis=1).sum() < 0.01
    assert np.array_equal(made.forbidden(max(values) + 1e-6)[side], [[-np.pi, np.pi]])


def test_clearance_at_an_arm_angle(arm):
    rng = generator("iiwa14", 5)
    q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    groups = [(p, np.column_stack([rng.uniform(-0.6, 0.6, (4, 3)), rng.uniform(0, 0.1, 4)])) for p in (0, 1, 2, 3)]
    made = Made(arm, q, groups)
    out = np.empty(at.WIDE)
    for psi in np.linspace(-3, 3, 13):
        tables = made.bodies, made.groups, made.pairs
        clearance(arm.packed.family, made.T, *tables, *made.work, arm.branch(q) >> 2, psi, out)
        assert abs(out[at.WIDE_CLEARANCE] - made.clearance(psi, arm.arm_angle(q))) < 1e-12
