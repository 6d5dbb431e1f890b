"""Poses that leave a turn free: no feasible one is missed, and the nearest posture is that of a dense grid."""

import copy
import math
import pickle

import arms
import numpy as np
import pinocchio as pin
import pytest
from oracles import random_limb
from pockets import POCKETS
from scipy.optimize import minimize

import srs_ik
from srs_ik import FreeAxis, InvalidConfiguration, InvalidTask

AXES = ([0.0, 0.0, 1.0], [0.6, -0.3, 0.8])
NEAREST = 1e-6
"""How much nearer to the seed, squared rad, a posture of the grid may be that SciPy polishes."""

CLOSED_IN = 2e-3
"""How much wider a margin of a dense sweep of rolls may be: without a seed the widest one is closed in on."""

LIMBS = arms.here("iiwa14", "gen3", "human_arm", "made_near", "j2s7s300", "openarm_left")


def unit(axis):
    return np.asarray(axis) / np.linalg.norm(axis)


def rolled(name, count, axis, salt=0):
    """Poses that a random posture meets once they are rolled back by a random angle, and seeds."""
    rng = arms.generator(name, salt)
    q = arms.configurations(name, count, salt)
    poses = np.array([arms.forward(name)(each).homogeneous for each in q])
    for T in poses:
        T[:3, :3] = T[:3, :3] @ pin.exp3(unit(axis) * rng.uniform(-np.pi, np.pi))
    return q, poses, arms.configurations(name, count, salt + 1)


def left(name, free, q, T):
    """Distance, and angle of the axis beyond its cone, by Pinocchio on the robot's file."""
    tip = arms.forward(name)(q)
    cosine = np.clip((tip.rotation @ free.axis) @ (T[:3, :3] @ free.axis), -1.0, 1.0)
    sine = np.linalg.norm(np.cross(tip.rotation @ free.axis, T[:3, :3] @ free.axis))
    return np.linalg.norm(tip.translation - T[:3, 3]), max(math.atan2(sine, cosine) - free.cone, 0.0)


def assert_met(name, free, q, T):
    arm = arms.load(name)
    assert (q >= arm.lower).all()
    assert (q <= arm.upper).all()
    assert max(left(name, free, q, T)) < 1e-9


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("name", LIMBS)
def test_no_pose_that_can_be_met_is_missed(name, axis):
    _, poses, seeds = rolled(name, 60, axis)
    free = FreeAxis(axis)
    for seed in (seeds, None):
        found = arms.load(name).solve_batch(poses, seed=seed, free_axis=axis)
        assert found.ok.all()
        for q, T in zip(found.q, poses, strict=True):
            assert_met(name, free, q, T)


@pytest.mark.slow
@pytest.mark.parametrize("name", LIMBS)
def test_none_of_many_poses_is_missed(name):
    missed = 0
    for salt, axis in enumerate(AXES):
        _, poses, seeds = rolled(name, 1000, axis, 10 + salt)
        missed += (~arms.load(name).solve_batch(poses, seed=seeds, free_axis=axis).ok).sum()
    assert missed == 0


def all_rolls(axis, count):
    return np.array([pin.exp3(unit(axis) * angle) for angle in 2.0 * np.pi * np.arange(count) / count])


def all_leans(free, count, rolls):
    """Turns that a cone leaves free: directions on a spiral, rolls about each."""
    across = np.linalg.svd(free.axis[None])[2][1:]
    leans = np.arccos(1.0 - (1.0 - math.cos(free.cone)) * (np.arange(count) + 0.5) / count)
    ways = 2.399963 * np.arange(count)
    tilts = [
        pin.exp3(a * (math.cos(b) * across[0] + math.sin(b) * across[1])) for a, b in zip(leans, ways, strict=True)
    ]
    return np.array([tilt @ roll for tilt in tilts for roll in all_rolls(free.axis, rolls)])


def best_of_grid(name, turns, T, seed, angles):
    """Squared distances of the nearest postures on a grid over turns and arm angle, and these, nearest first."""
    arm = arms.load(name)
    poses = np.repeat(T[None], len(turns) * angles, axis=0)
    poses[:, :3, :3] = np.repeat(T[:3, :3] @ turns, angles, axis=0)
    psis = np.tile(2.0 * np.pi * np.arange(angles) / angles, len(turns))
    found = arm.solve_batch(poses, arm_angle=psis, all_branches=True)
    q = found.q.reshape(-1, 7)
    best = np.full(q.shape, np.inf)
    nearest = q.copy()
    for turn in 2.0 * np.pi * np.arange(-2, 3):
        other = q + turn
        off = np.where((other < arm.lower - 1e-9) | (other > arm.upper + 1e-9), np.inf, (other - seed) ** 2)
        nearest, best = np.where(off < best, other, nearest), np.minimum(off, best)
    square = np.where(np.asarray(found.ok).ravel(), best.sum(axis=1), np.inf)
    order = np.argsort(square)
    return square[order], nearest[order]


def polished(name, free, T, seed, q):
    """The nearest posture around one, by SciPy."""
    arm, forward, a = arms.load(name), arms.forward(name), free.axis
    ought = T[:3, :3] @ a
    across = np.linalg.svd(ought[None])[2][1:] if free.cone == 0.0 else np.empty((0, 3))

    def off(x):
        tip = forward(x)
        return np.r_[tip.translation - T[:3, 3], across @ tip.rotation @ a]

    def room(x):
        return (forward(x).rotation @ a) @ ought - math.cos(free.cone)

    bounds = list(zip(np.maximum(arm.lower, -30.0), np.minimum(arm.upper, 30.0), strict=True))
    inside = [{"type": "ineq", "fun": room}] if free.cone > 0.0 else []
    found = minimize(
        lambda x: ((x - seed) ** 2).sum(),
        q,
        jac=lambda x: 2.0 * (x - seed),
        bounds=bounds,
        constraints=[{"type": "eq", "fun": off}, *inside],
        method="SLSQP",
        options={"ftol": 1e-13, "maxiter": 100},
    )
    met = np.abs(off(found.x)).max() < 1e-9 and (room(found.x) > -1e-9 if inside else room(found.x) > -1.0)
    return found.fun if met else np.inf


def best_of_all(name, free, T, seed, turns, angles):
    """The squared distance of the nearest posture of a grid whose six best dips SciPy polishes."""
    square, grid = best_of_grid(name, turns, T, seed, angles)
    apart = [0]
    for i in range(min(400, len(grid))):
        if np.abs(grid[i] - grid[apart]).max(axis=1).min() > 0.4 and len(apart) < 6:
            apart.append(i)
    return min(square[0], *(polished(name, free, T, seed, grid[i]) for i in apart if np.isfinite(square[i])), np.inf)


@pytest.mark.slow
@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("name", arms.here("iiwa14", "gen3", "human_arm"))
def test_the_nearest_posture_is_that_of_a_dense_grid(name, axis):
    _, poses, seeds = rolled(name, 8, axis, 30)
    found = arms.load(name).solve_batch(poses, seed=seeds, free_axis=axis)
    for T, seed, q in zip(poses, seeds, found.q, strict=True):
        best = best_of_all(name, FreeAxis(axis), T, seed, all_rolls(axis, 72), 72)
        assert ((q - seed) ** 2).sum() <= best + NEAREST


@pytest.mark.slow
@pytest.mark.parametrize("cone", [0.1, 0.4, 1.0, math.pi])
@pytest.mark.parametrize("name", arms.here("iiwa14", "gen3", "human_arm"))
def test_in_cones_the_nearest_posture_is_that_of_a_dense_grid(name, cone):
    free = FreeAxis(AXES[1], cone=cone)
    _, poses, seeds = rolled(name, 4, AXES[1], 90)
    found = arms.load(name).solve_batch(poses, seed=seeds, free_axis=free)
    for T, seed, q in zip(poses, seeds, found.q, strict=True):
        best = best_of_all(name, free, T, seed, all_leans(free, 30, 12), 36)
        assert ((q - seed) ** 2).sum() <= best + NEAREST


@pytest.mark.parametrize("pocket", POCKETS, ids=lambda pocket: f"{pocket.robot} {pocket.where}")
def test_searches_from_far_seeds_come_to_the_nearest_posture(pocket):
    if pocket.robot not in arms.here(pocket.robot):
        pytest.skip(f"no {pocket.robot} here")
    T, seed = np.array(pocket.pose), np.array(pocket.seed)
    q = arms.load(pocket.robot).solve(T, seed=seed, free_axis=pocket.free).q
    assert_met(pocket.robot, pocket.free, q, T)
    best = polished(pocket.robot, pocket.free, T, seed, np.array(pocket.near))
    assert np.isfinite(best)
    assert ((q - seed) ** 2).sum() <= best + NEAREST


@pytest.mark.parametrize("name", arms.here("iiwa14", "gen3"))
def test_close_to_the_seed_it_is_the_nearest_too(name):
    rng = arms.generator(name, 40)
    q, poses, _ = rolled(name, 10, AXES[0], 40)
    arm = arms.load(name)
    seeds = np.clip(q + rng.normal(0.0, 0.02, q.shape), arm.lower, arm.upper)
    found = arm.solve_batch(poses, seed=seeds, free_axis=AXES[0])
    for T, seed, each in zip(poses, seeds, found.q, strict=True):
        best = polished(name, FreeAxis(AXES[0]), T, seed, each)
        assert ((each - seed) ** 2).sum() <= best + 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("name", arms.here("iiwa14", "gen3"))
def test_without_a_seed_the_margin_is_that_of_the_best_roll(name):
    arm = arms.load(name)
    _, poses, _ = rolled(name, 6, AXES[0], 50)
    half = 0.5 * (arm.upper - arm.lower)

    def margin(q):
        with np.errstate(invalid="ignore"):
            return np.where(np.isfinite(half), 1.0 - np.abs(q - 0.5 * (arm.upper + arm.lower)) / half, 1.0).min(axis=-1)

    found = arm.solve_batch(poses, free_axis=AXES[0])
    for T, q in zip(poses, found.q, strict=True):
        turned = np.repeat(T[None], 180, axis=0)
        turned[:, :3, :3] = T[:3, :3] @ np.array([pin.exp3(unit(AXES[0]) * a) for a in np.arange(180) * np.pi / 90.0])
        at_rolls = arm.solve_batch(turned)
        assert margin(q) >= margin(at_rolls.q[at_rolls.ok]).max() - CLOSED_IN


@pytest.mark.parametrize("name", arms.here("iiwa14", "gen3", "human_arm"))
@pytest.mark.parametrize("free", [FreeAxis(AXES[1], cone=0.2), FreeAxis(cone=1.0), "any"])
def test_cones_and_positions_alone_are_met_and_no_farther_than_the_roll_alone(name, free):
    axis = free.axis if isinstance(free, FreeAxis) else [0.0, 0.0, 1.0]
    whole = free if isinstance(free, FreeAxis) else FreeAxis(cone=math.pi)
    arm = arms.load(name)
    _, poses, seeds = rolled(name, 10, axis, 60)
    narrow = arm.solve_batch(poses, seed=seeds, free_axis=axis)
    found = arm.solve_batch(poses, seed=seeds, free_axis=free)
    assert found.ok.all()
    for T, q, other, seed in zip(poses, found.q, narrow.q, seeds, strict=True):
        assert_met(name, whole, q, T)
        assert ((q - seed) ** 2).sum() <= ((other - seed) ** 2).sum() + NEAREST
    assert arm.solve_batch(poses, free_axis=free).ok.all()


@pytest.mark.parametrize("name", arms.here("iiwa14", "gen3"))
def test_errors_are_those_that_are_left(name):
    arm = arms.load(name)
    q = arms.configurations(name, 1)[0]
    T = arms.forward(name)(q).homogeneous
    T[:3, 3] *= 3.0 / np.linalg.norm(T[:3, 3])
    for seed in (q, None):
        found = arm.solve(T, seed=seed, free_axis=[0, 0, 1])
        assert found.status == "UNREACHABLE"
        off, turned = left(name, FreeAxis([0, 0, 1]), found.q, T)
        assert found.position_error == pytest.approx(off, abs=1e-9)
        assert found.orientation_error == pytest.approx(turned, abs=1e-9)
        assert found.position_error > 1.0
        assert ((found.q >= arm.lower) & (found.q <= arm.upper)).all()


def test_without_limits_the_pose_is_met_too():
    arm = arms.load("iiwa14")
    _, poses, seeds = rolled("iiwa14", 10, AXES[0], 70)
    for seed in (seeds, None):
        found = arm.solve_batch(poses, seed=seed, free_axis=AXES[0], respect_limits=False)
        assert found.ok.all()
        for q, T in zip(found.q, poses, strict=True):
            assert max(left("iiwa14", FreeAxis(AXES[0]), q, T)) < 1e-9


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"free_axis": [0, 0, 0]}, "3 finite numbers"),
        ({"free_axis": "z"}, "not 'z'"),
        ({"free_axis": [1, 2]}, "3 finite numbers"),
        ({"free_axis": [0, 0, 1], "arm_angle": 0.0}, "free_axis does not go with arm_angle"),
        ({"free_axis": [0, 0, 1], "branch": 0}, "free_axis does not go with branch"),
    ],
)
def test_wrong_free_axes_are_named(given, words):
    with pytest.raises(InvalidTask, match=words):
        arms.load("iiwa14").solve(np.eye(4), **given)


def test_the_angle_of_a_cone_is_checked():
    with pytest.raises(InvalidTask, match="from 0 to pi"):
        FreeAxis(cone=4.0)
    assert FreeAxis(cone=3.1416) == FreeAxis(cone=math.pi)
    with pytest.raises(InvalidConfiguration):
        arms.load("iiwa14").solve(np.eye(4), seed=[0.0], free_axis=[0, 0, 1])


@pytest.mark.parametrize("length", [5e-324, 1e-200, 1.0, 1e200, 1e308])
def test_an_axis_may_have_any_length(length):
    np.testing.assert_array_equal(FreeAxis([0.0, -length, 0.0]).axis, [0.0, -1.0, 0.0])
    np.testing.assert_allclose(FreeAxis([length, 0.0, length]).axis, [0.5**0.5, 0.0, 0.5**0.5], rtol=1e-15)


@pytest.mark.slow
@pytest.mark.parametrize("name", arms.here("iiwa14", "gen3"))
def test_a_path_takes_the_turns_that_serve_it_best(name):
    arm, free = arms.load(name), FreeAxis([0, 0, 1])
    q0 = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    T = arms.forward(name)(q0).homogeneous
    poses = np.repeat(T[None], 40, axis=0)
    t = np.linspace(0.0, 1.0, 40)
    poses[:, :3, 3] += 0.05 * np.stack([np.sin(3.0 * t), 1.0 - np.cos(3.0 * t), -t], axis=1)
    # As given, the tip rolls a whole turn on the way.
    poses[:, :3, :3] = T[:3, :3] @ np.array([pin.exp3(2.0 * np.pi * x * free.axis) for x in t])
    whole = arm.solve_path(poses)
    found = arm.solve_path(poses, free_axis=free)
    assert found
    for q, pose in zip(found.q, poses, strict=True):
        assert_met(name, free, q, pose)
    np.testing.assert_allclose(found.steps, np.diff(found.q, axis=0))
    assert (found.steps**2).sum() < 0.5 * (whole.steps**2).sum()
    assert found.value == pytest.approx((found.steps**2).sum())
    assert found.lower_bound == 0.0
    timed = arm.solve_path(poses, free_axis=free, objective="time", acceleration_limit=np.full(7, 9.0))
    assert timed.value == timed.times[-1] > 0.0
    seeded = arm.solve_path(poses, seed=found.q[0], free_axis=free, dt=0.1)
    assert seeded
    # The seed is where the arm is: the first step is no break.
    assert np.abs(seeded.q[0] - found.q[0]).max() < 0.5
    with pytest.raises(InvalidTask, match="closed"):
        arm.solve_path(poses, free_axis=free, closed=True)


@pytest.mark.parametrize("name", [name for name in ("iiwa14", "gen3", "human_arm") if name in LIMBS])
@pytest.mark.parametrize("seeded", [True, False])
def test_a_path_is_no_longer_than_a_known_one_whatever_the_rolls_of_its_poses(name, seeded):
    arm, free = arms.load(name), FreeAxis([0, 0, 1])
    rng, t = arms.generator(name, 41), np.linspace(0.0, 1.0, 16)[:, None]
    for begin, end in arms.configurations(name, 4, 41).reshape(2, 2, 7):
        known = begin + 0.5 * t * (end - begin)
        poses = np.array([arms.forward(name)(q).homogeneous for q in known])
        for pose in poses:
            pose[:3, :3] = pose[:3, :3] @ free.rolled(rng.uniform(-3.0, 3.0))
        path = arm.solve_path(poses, seed=known[0] if seeded else None, free_axis=free)
        assert path, path.breaks
        assert path.value <= (np.diff(known, axis=0) ** 2).sum() * (1.0 + 1e-6)
        for q, pose in zip(path.q, poses, strict=True):
            assert_met(name, free, q, pose)


@pytest.mark.parametrize("name", [name for name in ("iiwa14", "gen3", "human_arm") if name in LIMBS])
@pytest.mark.parametrize("joints", [(3, 5), (1, 3), (1, 3, 5)])
def test_a_seed_that_meets_its_singular_pose_is_the_answer(name, joints):
    arm, free = arms.load(name), FreeAxis([0.0, 0.0, 1.0])
    for q in arms.configurations(name, 40, 77):
        q = q.copy()
        q[list(joints)] = np.clip(0.0, arm.lower[list(joints)], arm.upper[list(joints)])
        pose = arms.forward(name)(q)
        solution = arm.solve(pose, seed=q, free_axis=free)
        assert solution, solution.message
        assert np.linalg.norm(solution.q - q) < 1e-9
        aside = np.clip(q + 0.1, arm.lower, arm.upper)
        solution = arm.solve(pose, seed=aside, free_axis=free)
        assert solution, solution.message
        assert max(left(name, free, solution.q, pose.homogeneous)) < 1e-9


@pytest.mark.skipif("human_arm" not in LIMBS, reason="no human_arm here")
def test_a_pose_met_in_few_turns_is_met_from_a_far_seed():
    arm, free = arms.load("human_arm"), FreeAxis(cone=0.1)
    q = [-0.580782871, -1.41365482, -1.5682612, -0.227737606, 0.816938492, 0.827447406, 0.00015511]
    T = arms.forward("human_arm")(np.array(q)).homogeneous
    T[:3, :3] = T[:3, :3] @ pin.exp3(np.array([-0.01239508, -0.09948839, 0.24827758]))
    seed = [-0.294961893, 2.0018580, -0.169357076, -1.52757533, -0.96028191, -1.23476384, 0.000453945]
    solution = arm.solve(T, seed=seed, free_axis=free)
    assert solution, solution.message
    assert_met("human_arm", free, solution.q, T)


AT_THE_END = (
    (
        "made_bent",
        [0.867865, -0.433344, -0.242949],
        [-1.6250856, -0.8250838, 0.3305372, 1.0454985, -1.06088, 0.1647852, -1.12444],
        [2.405776, -1.712819, -0.297054],
    ),
    (
        "made_rounded",
        [-0.879221, 0.449855, 0.156848],
        [1.2847082, 1.3872765, 0.8035515, -1e-06, 2.8890406, 0.001, -2.4390039],
        [2.105098, -2.176996, 0.266129],
    ),
    (
        "made_rounded",
        [0.993813, -0.110825, 0.007252],
        [2.6732527, -0.2073239, -0.6327048, 1e-06, -1.7695721, -0.001, -0.5578557],
        [2.99079, -0.802105, 0.507565],
    ),
)
"""Arms that are stretched out, axes that lean by up to 1 rad from a pose, and how that is turned."""


@pytest.mark.parametrize(("name", "axis", "q", "turned"), AT_THE_END)
def test_at_the_end_of_the_reach_few_directions_of_a_cone_meet_a_pose(name, axis, q, turned):
    free = FreeAxis(axis, cone=1.0)
    T = arms.forward(name)(np.array(q)).homogeneous
    T[:3, :3] = T[:3, :3] @ pin.exp3(np.array(turned))
    for seed in (None, np.zeros(7), q):
        solution = arms.load(name).solve(T, seed=seed, free_axis=free)
        assert solution, solution.message
        assert_met(name, free, solution.q, T)


@pytest.mark.parametrize(
    ("limb", "axis", "q", "seed"),
    [
        (
            48,
            [1.0, 0.0, 0.0],
            [1.08, 1.33, 0.79, -0.22, 0.26, -1.03, -1.12],
            [1.71, 2.36, 1.51, -0.15, -0.77, 1.32, -0.17],
        ),
        (
            193,
            [0.0, 0.0, 1.0],
            [-1.06, 0.01, 1.23, -0.34, 0.49, 0.68, -0.39],
            [0.32, -0.94, 1.54, -0.35, -0.01, 1.28, 1.95],
        ),
    ],
)
def test_where_few_directions_of_a_cone_reach_the_answer_is_no_farther_than_a_known_posture(limb, axis, q, seed):
    arm = srs_ik.load(random_limb(limb, "coordinate", "straight", "usual").model, base="base", tip="tool")
    free = FreeAxis(axis, cone=1.0)
    T = arm.forward_kinematics(q).homogeneous
    T[:3, :3] = T[:3, :3] @ pin.exp3(0.9 * np.roll(free.axis, 1))
    solution = arm.solve(T, seed=seed, free_axis=free)
    assert solution, solution.message
    assert np.linalg.norm(solution.q - seed) <= np.linalg.norm(np.subtract(q, seed)) + 1e-9


@pytest.mark.parametrize("cone", [1e-6, 1e-3, 0.05, 0.3, 1.0, 2.0, math.pi])
@pytest.mark.parametrize("name", ["iiwa14", "human_arm", "gen3"])
def test_no_cone_is_answered_worse_than_the_roll_alone(name, cone):
    arm = arms.load(name)
    rng = np.random.default_rng(0)
    half = 0.5 * (arm.upper - arm.lower)
    lower, upper = np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi)
    middle = 0.5 * (lower + upper)
    free = FreeAxis([0.0, 0.0, 1.0]), FreeAxis([0.0, 0.0, 1.0], cone=cone)
    for _ in range(12):
        q = rng.uniform(lower, upper)
        pose, seed = arm.forward_kinematics(q), q + 0.3 * rng.normal(size=7)
        far = [np.linalg.norm(arm.solve(pose, free_axis=axis, seed=seed).q - seed) for axis in free]
        margin = [np.min(1.0 - abs(arm.solve(pose, free_axis=axis).q - middle) / half) for axis in free]
        assert far[1] < far[0] + 1e-7
        assert margin[1] > margin[0] - 1e-6


@pytest.mark.parametrize(
    ("name", "cone", "q"),
    [
        ("human_arm", 0.3, [0.871, -0.609, -1.848, -1.502, 1.25, 1.093, -0.063]),
        ("human_arm", 1.0, [1.0, -1.362, 0.865, -1.823, 1.144, -0.566, 0.256]),
        ("gen3", 1.0, [2.368, 1.604, 1.837, -1.927, 2.266, -0.463, 1.934]),
    ],
)
def test_a_cone_has_the_margin_of_each_of_its_turns(name, cone, q):
    """Margins of 0.17, 0.22 and 0.25 were the answers here, where single turns have 0.36, 0.43 and 0.44."""
    arm = arms.load(name)
    middle, half = 0.5 * (arm.lower + arm.upper), 0.5 * (arm.upper - arm.lower)
    middle = np.where(np.isfinite(half), middle, 0.0)
    free = FreeAxis([0.0, 0.0, 1.0], cone=cone)
    T = arm.forward_kinematics(q).homogeneous
    turned = np.repeat(T[None], 600, axis=0)
    turned[:, :3, :3] = T[:3, :3] @ free.sampled(600)
    at_turns = arm.solve_batch(turned)
    most = np.min(1.0 - abs(at_turns.q[at_turns.ok] - middle) / half, axis=1).max()
    assert np.min(1.0 - abs(arm.solve(T, free_axis=free).q - middle) / half) > most


def on_limits(name, count, salt=120):
    """Postures with two joints in five on a limit."""
    rng, arm = arms.generator(name, salt), arms.load(name)
    q = arms.configurations(name, count, salt)
    limit = np.where(rng.random(q.shape) < 0.5, arm.lower, arm.upper)
    return np.where((rng.random(q.shape) < 0.4) & np.isfinite(limit), limit, q)


@pytest.mark.parametrize("axis", np.eye(3).tolist())
@pytest.mark.parametrize("name", LIMBS)
def test_no_pose_of_a_posture_on_its_limits_is_missed(name, axis):
    """Few turns meet such a pose, often one alone; where the axis passes the wrist, all have the elbow on its limit."""
    rng = arms.generator(name, 120)
    poses = np.array([arms.forward(name)(each).homogeneous for each in on_limits(name, 60)])
    for T in poses:
        T[:3, :3] = T[:3, :3] @ pin.exp3(np.asarray(axis) * rng.uniform(-np.pi, np.pi))
    for seed in (arms.configurations(name, 60, 121), None):
        found = arms.load(name).solve_batch(poses, seed=seed, free_axis=axis)
        assert found.ok.all(), np.flatnonzero(~found.ok)
        for q, T in zip(found.q, poses, strict=True):
            assert_met(name, FreeAxis(axis), q, T)


@pytest.mark.skipif("human_arm" not in LIMBS, reason="no human_arm here")
def test_what_the_middle_of_a_thin_cone_misses_is_met_beside_it():
    """With three joints on limits, one direction in the cone meets the pose: its middle misses it by 1e-7 m."""
    arm, free = arms.load("human_arm"), FreeAxis([1.0, 0.0, 0.0], cone=1e-6)
    T = np.eye(4)
    T[:3] = [
        [-0.28626638067324095, -0.23362127287670253, -0.929232296121757, -0.3312757407170786],
        [0.9147298118042995, -0.3552771823859648, -0.19247725858490677, -0.13894188699736537],
        [-0.28516824979775407, -0.9050962515309404, 0.31540425610940387, -0.161546879218307],
    ]
    far = [-0.48911615, -0.03252466, -1.17369758, -2.57077103, -0.46283175, 0.70657113, -0.25573152]
    for seed in (None, np.zeros(7), far):
        solution = arm.solve(T, seed=seed, free_axis=free)
        assert solution, solution.message
        assert_met("human_arm", free, solution.q, T)


@pytest.mark.skipif("human_arm" not in LIMBS, reason="no human_arm here")
@pytest.mark.parametrize("wrist", [-1.3962634015954636, -1.0, 1.2217304763960306])
def test_a_straight_elbow_is_met_with_the_axis_through_the_wrist(wrist):
    arm = arms.load("human_arm")
    q = [-0.6971317007977318, 1.529282224217222, 0.56985891800, 0.0, -0.97081898807, wrist, -0.23998850478]
    pose = arms.forward("human_arm")(np.clip(q, arm.lower, arm.upper)).homogeneous
    for angle in (0.0, 1.234, -2.0):
        T = pose.copy()
        T[:3, :3] = T[:3, :3] @ pin.exp3(angle * np.array([1.0, 0.0, 0.0]))
        for seed in (None, q, np.zeros(7)):
            solution = arm.solve(T, seed=seed, free_axis=[1, 0, 0])
            assert solution, solution.message
            assert_met("human_arm", FreeAxis([1, 0, 0]), solution.q, T)


@pytest.mark.skipif("human_arm" not in LIMBS, reason="no human_arm here")
def test_a_thin_cone_that_limits_leave_at_its_edge_alone_is_met():
    """With four joints on limits, neither the middle of the cone meets the pose, nor the shortest way beside it."""
    arm, free = arms.load("human_arm"), FreeAxis([0.0, 1.0, 0.0], cone=1e-6)
    T = np.eye(4)
    T[:3] = [
        [0.431147934773847, -0.8413135580092076, -0.32604134009375896, 0.15604018841407674],
        [-0.5514146668558578, -0.5317051268397589, 0.6428308667671138, -0.3260763354937565],
        [-0.7141801758075407, -0.0973712236864856, -0.6931562026565922, 0.41790497406983795],
    ]
    far = [
        0.24558348927977225,
        1.81484245911,
        -1.66146506467,
        -1.76424624752,
        0.306872471174,
        -0.3585054674,
        -0.2182070934,
    ]
    for seed in (None, np.zeros(7), far):
        solution = arm.solve(T, seed=seed, free_axis=free)
        assert solution, solution.message
        assert_met("human_arm", free, solution.q, T)


NEXT_TO_SEEDS = (
    (
        (1135, "tilted", "straight", "wide"),
        FreeAxis([0.057, 0.528, -0.847], cone=1e-6),
        [-4.547, -3.519, -3.769, 3.527, 1.431, -3.277, 4.873],
        [-4.543, -3.485, -3.799, 3.571, 1.284, -3.298, 4.862],
    ),
    (
        (1174, "tilted", "offset", "wide"),
        FreeAxis([0.4, 0.771, 0.496]),
        [3.859, 3.772, -4.335, -5.871, 5.276, -1.361, 5.294],
        [3.817, 3.719, -4.391, -5.854, 5.344, -1.456, 5.213],
    ),
)
"""Random limbs, what is free, postures, and seeds next to them that searches from elsewhere answered by others."""


@pytest.mark.parametrize(("limb", "free", "q", "seed"), NEXT_TO_SEEDS)
def test_a_posture_next_to_a_seed_is_found_from_the_seed(limb, free, q, seed):
    arm = srs_ik.load(random_limb(*limb).model, base="base", tip="tool")
    q = np.clip(q, arm.lower, arm.upper)
    solution = arm.solve(arm.forward_kinematics(q), seed=seed, free_axis=free)
    assert solution, solution.message
    assert np.linalg.norm(solution.q - seed) <= np.linalg.norm(np.subtract(q, seed)) + 1e-6


ELBOWS_ON_LIMITS = (
    (
        0.0,
        [2.533, -0.014, 2.489, -2.1, 1.759, -0.081, -1.847],
        [2.591, -0.086, 2.532, -2.082, 1.779, -0.113, -1.902],
    ),
    (
        1e-6,
        [-1.21, -0.996, 1.835, 2.1, 3.0, -0.909, -2.266],
        [-1.212, -0.954, 1.92, 2.049, 3.003, -0.881, -2.292],
    ),
)
"""Cones about the axis of joint 7, postures whose elbow comes to lie on its limit, and seeds."""


@pytest.mark.parametrize(("cone", "q", "seed"), ELBOWS_ON_LIMITS)
def test_elbows_stay_on_their_limit_where_the_axis_is_that_of_joint_7(cone, q, seed):
    arm = arms.load("iiwa14")
    q = np.clip(q, arm.lower, arm.upper)
    free = FreeAxis([0.0, 0.0, 1.0], cone=cone)
    solution = arm.solve(arms.forward("iiwa14")(q), seed=seed, free_axis=free)
    assert solution, solution.message
    assert np.linalg.norm(solution.q - seed) <= np.linalg.norm(q - seed) + 1e-6


IN_OTHER_BRANCHES = (
    (
        "rm75",
        2.0,
        [-2.736, 2.261, 3.1, -1.514, 2.294, -0.287, -0.38],
        [0.878, -0.284, 2.014],
        [-2.905, -0.852, 1.911, 0.047, 2.558, -0.342, -0.38],
    ),
    (
        "sia5d",
        0.5,
        [-3.092, 0.846, -0.305, -1.471, 1.365, -1.919, 0.018],
        [-0.198, -0.467, 0.614],
        [-2.65, 0.178, 2.237, 0.125, 1.402, -1.382, 0.018],
    ),
)
"""Cones, postures far from seeds, in whose branches the best starts lead elsewhere, turns to their poses, and seeds."""


@pytest.mark.parametrize(
    ("name", "cone", "q", "turned", "seed"), [at for at in IN_OTHER_BRANCHES if at[0] in arms.here(at[0])]
)
def test_in_wide_cones_the_other_branches_of_the_best_posture_are_looked_at(name, cone, q, turned, seed):
    T = arms.forward(name)(np.array(q)).homogeneous
    T[:3, :3] = T[:3, :3] @ pin.exp3(np.array(turned))
    solution = arms.load(name).solve(T, seed=seed, free_axis=FreeAxis(cone=cone))
    assert solution, solution.message
    assert np.linalg.norm(solution.q - seed) <= np.linalg.norm(np.subtract(q, seed)) + 1e-6


def test_what_is_free_is_not_changed_afterwards():
    free = FreeAxis([0.0, 0.0, 2.0], cone=0.3)
    for each in (free, copy.copy(free), copy.deepcopy(free), pickle.loads(pickle.dumps(free))):
        assert each == free
        for name, value in (("axis", [1.0, 0.0, 0.0]), ("cone", 1.0)):
            with pytest.raises(AttributeError, match=f"FreeAxis.{name} cannot be changed: make another FreeAxis"):
                setattr(each, name, value)
        with pytest.raises(ValueError, match="read-only"):
            each.axis[0] = 1.0
