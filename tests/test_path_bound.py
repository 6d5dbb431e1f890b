"""The bound of a path: never above what any path costs that is known or found by brute force, and not far below."""

import numpy as np
import pytest
from arms import forward, generator, load
from hypothesis import given
from hypothesis import strategies as st
from known_paths import known_motion, poses_of, total
from oracles import limbs
from path_oracle import best_path, swept_postures

import srs_ik
from srs_ik.kernels.entries import path_bound
from srs_ik.kernels.layout.path import CELL, CELL_OFF
from srs_ik.kernels.path.cells import FREE
from srs_ik.solve.path.ask import Terms, problem_of
from srs_ik.solve.path.bound import MOST_ROOM
from srs_ik.solve.path.problem import limbs_of
from srs_ik.solve.path.search.blocks import through
from srs_ik.solve.path.search.narrow import costs_to_end

TURN = 2.0 * np.pi
LONGEST = 30.0
"""Longer than any cell, rad."""

MOST_ASKED = 400
"""Of joints of many turns a sweep has thousands of postures, and there are a million cells: some of them are asked."""

ARMS = ("iiwa14", "human_left", "sia10f", "openarm_left", "romeo_left")


def assert_covered(arm, pose, longest, count):
    """Every posture of a sweep, inside the limits, is as close to one of the cells as that says."""
    rows, ends = np.empty((MOST_ROOM, CELL)), np.zeros(2, np.int64)
    none = np.full((1, 7), np.nan)
    told = pose[None], 0, none, np.zeros(1, bool), none
    _, family = limbs_of(arm.packed, False)
    # Joints of many turns have more short cells than there is room for.
    while not path_bound.cover(family, *told, longest, rows, ends):
        longest *= 2.0
        assert longest < LONGEST
    rows = rows[: ends[1]]
    start, chord = rows[:, :7], rows[:, 7:14]
    # Where joints may turn on the spot, a cell says nothing, and is not cut.
    assert np.linalg.norm(chord[rows[:, CELL_OFF] < FREE], axis=1).max(initial=0.0) <= longest + 1e-12
    endless = np.isinf(arm.lower) & np.isinf(arm.upper)
    postures = list(swept_postures(arm, pose, count))
    for q in postures[:: 1 + len(postures) // MOST_ASKED]:
        off = q - start
        off -= TURN * endless * np.round(off / TURN)
        size = (chord**2).sum(1)
        t = np.clip((off * chord).sum(1) / np.where(size > 0.0, size, 1.0), 0.0, 1.0)
        away = np.linalg.norm(off - t[:, None] * chord, axis=1)
        assert (away <= rows[:, CELL_OFF]).any(), q


@pytest.mark.parametrize("name", [*ARMS, "human_arm", "made_oblique", "rm75", "gen3"])
def test_cells_hold_all_postures(name):
    arm, rng = load(name), generator(name, 50)
    lower, upper = np.maximum(arm.lower, -4.0), np.minimum(arm.upper, 4.0)
    for _ in range(6 if arm.packed.closed else 2):
        pose = arm.forward_kinematics(rng.uniform(lower, upper)).homogeneous
        assert_covered(arm, pose, rng.uniform(0.05, 0.4), 300)


@pytest.mark.parametrize("name", ["iiwa14", "human_arm"])
@pytest.mark.parametrize("joint", [1, 3, 5])
def test_cells_hold_all_postures_next_to_a_singular_one(name, joint):
    arm, rng = load(name), generator(name, 51)
    for off in (1e-6, 1e-3, 0.05):
        q = rng.uniform(np.maximum(arm.lower, -2.0), np.minimum(arm.upper, 2.0))
        q[joint] = np.clip(off, arm.lower[joint], arm.upper[joint])
        assert_covered(arm, arm.forward_kinematics(q).homogeneous, 0.3, 300)


@given(limbs(limits=("usual", "narrow", "beyond", "mixed")), st.floats(0.05, 0.4))
def test_cells_hold_all_postures_of_random_limbs(limb, longest):
    arm = srs_ik.load(limb.model, base="base", tip="tool")
    q = known_motion(arm, limb.rng, 2, 0.1)[0]
    assert_covered(arm, arm.forward_kinematics(q).homogeneous, longest, 60)


@pytest.mark.slow
@pytest.mark.parametrize("name", [*ARMS, "gen3"])
@pytest.mark.parametrize("seeded", [True, False])
def test_the_bound_is_below_a_known_motion_and_close_below_the_path(name, seeded):
    arm, rng = load(name), generator(name, 52)
    for _ in range(2 if arm.packed.closed else 1):
        known = known_motion(arm, rng, 60, rng.uniform(0.05, 0.14))
        path = arm.solve_path(poses_of(arm, known), seed=known[0] if seeded else None)
        assert path.value == pytest.approx(total(path, known[0] if seeded else None))
        assert 0.0 < path.lower_bound <= min(path.value, (np.diff(known, axis=0) ** 2).sum())
        assert path.lower_bound > (0.97 if arm.packed.closed else 0.94) * path.value


@pytest.mark.slow
@pytest.mark.parametrize("name", ["iiwa14", "human_left"])
@pytest.mark.parametrize("case", ["free", "seeded", "broken"])
def test_brute_force_finds_nothing_below_the_bound(name, case):
    arm, rng = load(name), generator(name, 53)
    for _ in range(2):
        known = known_motion(arm, rng, 8, rng.uniform(0.05, 0.2))
        if case == "broken":
            known[4:] = known_motion(arm, rng, 4, 0.1)
        poses = poses_of(arm, known)
        seed = known[0] if case == "seeded" else None
        _, least = best_path(arm, [swept_postures(arm, pose, 400) for pose in poses], seed, 0.5)
        path = arm.solve_path(poses, seed=seed)
        assert 0.9 * path.value < path.lower_bound <= min(path.value, least) * (1.0 + 1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["iiwa14", "human_left"])
def test_the_bound_of_the_largest_step(name):
    arm, rng = load(name), generator(name, 54)
    for seeded in (True, False):
        known = known_motion(arm, rng, 60, 0.1)
        seed = known[0] if seeded else None
        path = arm.solve_path(poses_of(arm, known), seed=seed, objective="largest_step")
        assert path.value >= path.largest_step
        assert 0.95 * path.value < path.lower_bound <= min(path.value, np.abs(np.diff(known, axis=0)).max())


def assert_no_better_than_known(arm, poses, known, value, path, breaks):
    """A path is as good as one that is known to meet its poses, by Pinocchio, and so is its bound."""
    for q, T in zip(known, poses, strict=True):
        np.testing.assert_allclose(forward(arm.name)(q).homogeneous, T, atol=1e-4)
        assert (arm.lower <= q).all()
        assert (q <= arm.upper).all()
    assert len(path.breaks) == breaks
    assert path.lower_bound <= path.value < value * (1.0 + 1e-4)


@pytest.mark.parametrize("count", [1, 2, 5])
def test_a_seed_that_is_far_away(count):
    """Its step was taken for a break: neither was the largest one least, nor its bound below what another path has."""
    arm = load("iiwa14")
    seed = np.array([1.4416, -2.069, 0.7847, 1.582, 2.3078, 0.0374, 0.9034])
    q = np.array([-0.1709, -1.9619, 2.8601, 1.9988, 2.8565, -2.0365, -0.4966])
    poses = np.repeat(arm.forward_kinematics(q).homogeneous[None], count, axis=0)
    path = arm.solve_path(poses, seed=seed, objective="largest_step")
    assert_no_better_than_known(arm, poses, [q] * count, np.abs(q - seed).max(), path, 0)
    assert path.lower_bound > 0.98 * path.value
    even = arm.solve_path(poses, seed=seed)
    assert 0.98 * even.value < even.lower_bound < even.value <= ((q - seed) ** 2).sum()


def test_a_break_that_is_the_largest_step():
    """Wherever a path breaks, the best one was not looked for, and bounds held for no others than those that do not."""
    arm, rng = load("iiwa14"), np.random.default_rng(1)
    poses = [arm.forward_kinematics(q).homogeneous for q in rng.uniform(arm.lower, arm.upper, (2, 7))]
    known = np.array(
        [
            [0.0548, 1.9115, 1.0474, -1.8793, 1.9689, -0.3485, 2.0396],
            [-0.9952, 0.8615, 2.0974, -1.0619, 1.6063, -1.1709, 2.4628],
        ]
    )
    path = arm.solve_path(poses, objective="largest_step")
    assert_no_better_than_known(arm, poses, known, np.abs(np.diff(known, axis=0)).max(), path, 1)
    assert path.lower_bound > 0.98 * path.value


@pytest.mark.parametrize("seed", [4, 7, 52])
def test_a_break_takes_no_longer_than_it_has_to(seed):
    """Breaks were planned in coarse strips, from posture to posture of these alone."""
    arm, rng = load("iiwa14"), np.random.default_rng(seed)
    poses = [arm.forward_kinematics(q).homogeneous for q in rng.uniform(arm.lower, arm.upper, (2, 7))]
    path = arm.solve_path(poses, objective="time")
    # Planned as one step like any other.
    known = arm.solve_path(poses, objective="time", longest_step=10.0).q
    takes = (np.abs(np.diff(known, axis=0)) / arm.velocity_limit).max()
    assert_no_better_than_known(arm, poses, known, takes, path, 1)


def test_breaks_of_longer_paths_are_as_small_as_can_be_and_all_else_stays_continuous():
    arm, rng = load("iiwa14"), np.random.default_rng(8)
    known = np.vstack([known_motion(arm, rng, 30, 0.1), known_motion(arm, rng, 30, 0.1)])
    poses = poses_of(arm, known)
    path = arm.solve_path(poses, objective="largest_step")
    jumps = np.flatnonzero((np.abs(path.steps) > 0.5).any(axis=1))
    assert [each.sample - 1 for each in path.breaks] == jumps.tolist() == [29]
    assert path.lower_bound <= path.value < np.abs(known[30] - known[29]).max()
    # Without limits to what is continuous the same path is to be found.
    other = arm.solve_path(poses, objective="largest_step", longest_step=10.0)
    assert path.value <= other.value * (1.0 + 1e-3)
    assert other.lower_bound <= path.value


@pytest.mark.slow
def test_postures_that_are_given_and_poses_out_of_reach():
    arm, rng = load("iiwa14"), generator("iiwa14", 55)
    known = known_motion(arm, rng, 40, 0.1)
    poses = poses_of(arm, known)
    free, held = arm.solve_path(poses), arm.solve_path(poses, known={0: known[0], 20: known[20], -1: known[-1]})
    assert free.lower_bound <= held.lower_bound <= held.value
    assert held.lower_bound > 0.97 * held.value
    poses[17, 0, 3] += 5.0
    missing = arm.solve_path(poses)
    assert 0.0 < missing.lower_bound <= missing.value
    whole = arm.solve_path(poses[:17]).lower_bound + arm.solve_path(poses[18:]).lower_bound
    assert missing.lower_bound == pytest.approx(whole, rel=0.05)
    largest = [arm.solve_path(part, objective="largest_step") for part in (poses, poses[:17], poses[18:])]
    assert largest[0].lower_bound == pytest.approx(max(part.lower_bound for part in largest[1:]), rel=0.05)


@pytest.mark.slow
def test_an_arm_that_may_turn_on_the_spot_at_every_arm_angle_is_bounded_too():
    """Upright and straight: shoulder and wrist are singular all along."""
    arm = load("iiwa14")
    poses = [arm.forward_kinematics([0.3 + 0.05 * i, 0.0, 0.2, 0.0, 0.1, 0.0, 0.4]) for i in range(4)]
    path = arm.solve_path(poses)
    assert 0.0 <= path.lower_bound <= path.value


def test_no_poses_and_one_pose():
    arm = load("iiwa14")
    q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    assert arm.solve_path(np.empty((0, 4, 4))).lower_bound == 0.0
    assert arm.solve_path([arm.forward_kinematics(q)]).lower_bound == 0.0
    near = arm.solve_path([arm.forward_kinematics(q)], seed=q + 0.1)
    assert 0.97 * near.value < near.lower_bound <= near.value <= 0.07 + 1e-12


def test_long_paths_are_bounded_block_by_block(monkeypatch):
    from srs_ik.solve.path import bound as bounds

    arm, rng = load("human_left"), generator("human_left", 56)
    poses = poses_of(arm, known_motion(arm, rng, 60, 0.1))
    whole = arm.solve_path(poses).lower_bound
    monkeypatch.setattr(bounds, "ROOM", 300)
    assert arm.solve_path(poses).lower_bound == pytest.approx(whole, rel=1e-9)


@pytest.mark.parametrize(("name", "count"), [("iiwa14", 41), ("human_arm", 1101)])
def test_what_a_path_costs_to_its_end_is_what_one_the_other_way_round_costs(name, count):
    """From each posture of the first pose on, through one block of strips and through three."""
    arm, rng = load(name), generator(name, 42)
    poses, keys = poses_of(arm, known_motion(arm, rng, count, 0.1)), np.arange(count)
    forth, back = (problem_of(arm.packed, np.ascontiguousarray(T), Terms()) for T in (poses, poses[::-1]))
    blocks, turned = through(forth, keys, False)[1], through(back, keys, False)[1]
    assert len(blocks) == (1 if count == 41 else 3)
    _, cost, _, ends = turned[-1].fill()
    begin, end = ends[turned[-1].count, :2]
    after = costs_to_end(forth, blocks, np.inf).after[0][: end - begin, 0]
    np.testing.assert_allclose(after, cost[begin:end], rtol=1e-12)
