"""How far near limbs are from their nearest exact ones; postures that narrow bands or wide steps would lose."""

import arms
import numpy as np
import pytest
from oracles import random_limb

import srs_ik
from srs_ik.kernels.entries import pose as entries
from srs_ik.kernels.layout import answer
from srs_ik.kernels.layout import limb as at
from srs_ik.solve import bands

CLOSED = 1e-9
"""An arm angle this close to an end, rad, is in the interval."""

TURN = 2.0 * np.pi

USUAL = 0.3
"""Wider bands are not used, rad."""


def random_arm(seed, pattern, limits, miss):
    limb = random_limb(seed, pattern, ("straight", "offset")[seed % 2], limits, miss)
    return limb, srs_ik.load(limb.model, base="base", tip="tool")


@pytest.mark.parametrize("name", ["gen3", "j2s7s300", "coordinate", "tilted"])
def test_the_closed_form_is_no_farther_from_the_true_chain_than_the_band(name):
    arm = arms.load(name) if name[-1].isdigit() else random_arm(5, name, "continuous", 0.01)[1]
    family = arm.packed.family
    exact = family.copy()
    exact[:, at.IS_CLOSED], exact[:, at.IS_NEAR] = 1.0, 0.0
    P = family[at.FREE]
    bands = P[at.BANDS : at.BANDS + 14].reshape(7, 2)
    rng = np.random.default_rng(11)
    row = np.empty(answer.ROW)
    tried = outside = 0
    for _ in range(3000):
        q = rng.uniform(-np.pi, np.pi, 7)
        middles = np.abs(np.sin([q[1] - P[at.SHOULDER + at.PHASE], q[5] - P[at.WRIST + at.PHASE]]))
        if middles.min() < 0.5:
            continue
        T = np.ascontiguousarray(arm.forward_kinematics(q).homogeneous)
        entries.solve_at(exact, T, arm.arm_angle(q), arm.branch(q), q, False, False, row)
        bend = abs(np.sin(row[3] - P[at.STRAIGHT]))
        told = 1.0 - abs(np.cos(row[3] - P[at.STRAIGHT])) > at.WELL_CLEAR * P[at.COSINE_OFF]
        band = bands[:, 0] + bands[:, 1] / max(bend, 1e-9)
        if not told or band.max() > USUAL:
            continue
        share = np.array([middles[0], 1.0, middles[0], 1.0, middles[1], 1.0, middles[1]])
        off = share * np.abs((row[:7] - q + np.pi) % (2.0 * np.pi) - np.pi)
        tried += 1
        outside += int((off > band).any())
    # A measured bound: some few of 10,000 may be outside.
    assert tried > 300
    assert outside <= tried // 1000


@pytest.mark.parametrize(
    ("seed", "pattern", "number", "miss"),
    [
        # Between two samples of the curve a joint dips into a range of 2 mrad; the curve was cut open there.
        (10, "oblique", 1, 0.02),
        # A range of 4 mrad next to the widest that the band allows.
        (3, "tilted", 3, 0.02),
        # A joint passes a range of under a milliradian, turns around behind it, and passes it again.
        (1094, "oblique", 6, 0.02),
        (1222, "oblique", 10, 0.02),
        (1238, "oblique", 4, 0.02),
        (9111, "tilted", 49, 0.02),
        # The same, from a sample that happens to lie inside the range.
        (1266, "oblique", 3, 0.02),
        (9202, "tilted", 45, 0.02),
        (9283, "tilted", 45, 0.02),
        # A short step whose curve turns sharply leaves the range on one side and comes back.
        (9299, "tilted", 7, 0.02),
        # Two samples of the curve have one arm angle, and its turn between them.
        (1209, "oblique", 24, 0.02),
        (9081, "tilted", 6, 0.02),
        # A closed curve of its own next to a shoulder that is almost singular.
        (9181, "tilted", 30, 0.02),
        # The same next to a wrist, with the elbow almost straight.
        (73068, "coordinate", 12, 0.002),
        (73387, "coordinate", 3, 0.002),
        (75021, "tilted", 27, 0.0005),
        # Next to a singularity the band joins what is ahead of a narrow range to what is behind it.
        (9014, "tilted", 48, 0.02),
        (30218, "tilted", 29, 0.02),
        # Of two points between which a band tells nothing, one happens to lie inside a narrow range.
        (50258, "coordinate", 43, 0.02),
        (50275, "coordinate", 48, 0.02),
    ],
)
def test_known_postures_are_in_an_interval(seed, pattern, number, miss):
    limb, arm = random_arm(seed, pattern, ("usual", "mixed")[seed // 2 % 2], miss)
    for _ in range(number + 1):
        q = limb.configuration()
    psi, branch = arm.arm_angle(q), arm.branch(q)
    found = [i for i in arm.intervals(arm.forward_kinematics(q)) if i.branch == branch]
    assert any((psi - i.lower + CLOSED) % (2.0 * np.pi) <= i.width + 2.0 * CLOSED for i in found)


@pytest.mark.parametrize(
    ("seed", "pattern", "number", "miss", "branch"),
    [
        (50110, "coordinate", 17, 0.02, 3),
        (50264, "coordinate", 8, 0.02, 2),
        (50289, "coordinate", 2, 0.02, 6),
        (50289, "coordinate", 26, 0.02, 7),
        (64155, "tilted", 38, 0.005, 4),
        (64170, "tilted", 22, 0.005, 1),
    ],
)
def test_of_two_postures_of_a_branch_the_one_with_an_almost_straight_elbow_is_found(
    seed, pattern, number, miss, branch
):
    limb, arm = random_arm(seed, pattern, ("usual", "mixed")[seed // 2 % 2], miss)
    for _ in range(number + 1):
        q = limb.configuration()
    pose = arm.forward_kinematics(q)
    asked = [i for i in arm.intervals(pose) if i.branch == branch]
    assert asked
    for interval in asked:
        for share in np.linspace(0.02, 0.98, 13):
            solution = arm.solve(pose, arm_angle=interval.lower + share * interval.width, branch=branch)
            assert solution, (interval, share)
            assert max(arm.verify(pose, solution.q)) < 1e-9


def test_a_branch_of_oblique_axes_with_two_postures_at_an_arm_angle_gives_the_one_inside_the_limits():
    limb, arm = random_arm(17, "oblique", "usual", 0.02)
    for _ in range(39):
        q = limb.configuration()
    pose = arm.forward_kinematics(q)
    asked = 0
    for interval in arm.intervals(pose):
        for share in (0.05, 0.2, 0.5, 0.8, 0.95):
            psi = interval.lower + share * interval.width
            solution = arm.solve(pose, arm_angle=psi, branch=interval.branch)
            asked += 1
            assert solution, (interval, psi)
            assert (solution.q >= arm.lower).all()
            assert (solution.q <= arm.upper).all()
            assert max(arm.verify(pose, solution.q)) < 1e-9
    assert asked > 0


def test_next_to_a_straight_elbow_the_best_posture_at_an_arm_angle_is_found():
    arm = arms.load("gen3")
    limited = np.isfinite(arm.lower)
    half = 0.5 * (arm.upper - arm.lower)[limited]

    def margin(q):
        return float((np.minimum(q - arm.lower, arm.upper - q)[limited] / half).min())

    rng = np.random.default_rng(3)
    for _ in range(100):
        q = rng.uniform(*np.clip([arm.lower, arm.upper], -np.pi, np.pi))
        q[3] = 0.02 * rng.normal()
        pose = arm.forward_kinematics(q)
        solution = arm.solve(pose, arm_angle=arm.arm_angle(q))
        assert max(arm.verify(pose, solution.q)) < 1e-9
        assert margin(solution.q) > margin(q) - 1e-9, q.tolist()


REACHING = [*((name, 0) for name in arms.here("gen3", "j2s7s300")), ("tilted", 6), ("tilted", 10), ("oblique", 3)]


@pytest.mark.parametrize(("name", "seed"), REACHING)
def test_straight_elbows_reach_farther_than_the_nearest_exact_limb_and_are_found(name, seed):
    arm = random_arm(seed, name, "continuous", 0.02)[1] if seed else arms.load(name)
    rng = np.random.default_rng(3)
    q = rng.uniform(-np.pi, np.pi, (20_000, 7))
    q[:, 3] = arm.packed.family[at.FREE, at.STRAIGHT]
    shifts = np.zeros((len(q), at.SHIFTS))
    entries.measure_shifts(arm.packed.family[at.FREE], q, shifts)
    farthest = np.argsort(shifts[:, at.SHIFT_COSINE])[-12:]
    assert (shifts[farthest, at.SHIFT_COSINE] > 0.0).all()
    for k in farthest:
        pose = arm.forward_kinematics(q[k])
        solution = arm.solve(pose, respect_limits=False)
        assert solution, (k, solution.status)
        assert max(arm.verify(pose, solution.q)) < 1e-9


def test_where_nothing_is_foretold_bands_have_no_end():
    # As of an elbow whose axis passes the shoulder by a tenth of a millimetre.
    with np.errstate(all="raise"):
        assert bands._above(np.array([0.1, np.inf]), np.array([0.5, 0.1]), np.inf) == (np.inf, 0.0)


NARROW = ("gen3", "j2s7s300", "rm75", "iiwa14_experimental")


@pytest.mark.parametrize("name", arms.here(*NARROW))
@pytest.mark.parametrize("width", [0.0, 1e-9, 1e-7, 1e-5, 1e-4, 1e-3, 1e-2])
def test_limits_narrower_than_the_band_do_not_hide_what_they_leave(name, width):
    """Next to a singular shoulder the middle joint is off by the square of the band over its sine: it was left out."""
    whole, rng = arms.load(name), np.random.default_rng(3)
    for _ in range(40):
        q = rng.uniform(-3.0, 3.0, 7)
        arm = whole.with_limits(lower=q - width * rng.random(7), upper=q + width * rng.random(7))
        pose, psi = arm.forward_kinematics(q), arm.arm_angle(q)
        assert arm.solve(pose)
        assert arm.reachable_batch([pose])[0]
        found = [i for i in arm.intervals(pose) if i.branch == arm.branch(q)]
        beside = [min((psi - i.lower) % TURN, (i.lower - psi) % TURN, (psi - i.upper) % TURN) for i in found]
        inside = [(psi - i.lower) % TURN <= i.width for i in found]
        assert any(inside) or min(beside, default=TURN) < 1e-6, q.tolist()


def margin_of(arm, q):
    """How far the joint closest to a limit is from it, by half of its range."""
    has = np.isfinite(arm.upper)
    lower, upper = arm.lower[has], arm.upper[has]
    return np.min(np.minimum(q[has] - lower, upper - q[has]) / (0.5 * (upper - lower)))


@pytest.mark.parametrize("name", arms.here("gen3", "j2s7s300"))
def test_without_limits_the_posture_farthest_from_them_is_the_same_where_it_is_inside(name):
    arm = arms.load(name)
    for q in arms.configurations(name, 60, 5):
        pose = arm.forward_kinematics(q)
        inside, free = arm.solve(pose), arm.solve(pose, respect_limits=False)
        assert inside
        assert free
        assert margin_of(arm, free.q) == pytest.approx(margin_of(arm, inside.q), abs=1e-9)
