"""Joint paths are the best there are: against brute force, and never worse than a motion that is known."""

import runpy
import zlib
from pathlib import Path

import numpy as np
import pytest
from arms import configurations, generator, load
from known_paths import assert_as_good, assert_known_is_no_better, assert_on_poses, known_motion, poses_of, total
from oracles import random_limb
from path_oracle import best_path, swept_postures

import srs_ik
from srs_ik.solve.path.search import narrow, planned

LONGEST = 0.5


@pytest.mark.parametrize("name", ["iiwa14", "human_arm"])
def test_no_start_beside_that_of_a_path_is_better(name):
    """Without a seed, the first posture is chosen, too: by the path, and not by where its search began."""
    arm, rng = load(name), np.random.default_rng(0)
    lower, upper = np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi)
    paths = 0
    for _ in range(20):
        first, last = rng.uniform(lower, upper, (2, 7))
        poses = poses_of(arm, first + 0.15 * (last - first) * np.linspace(0.0, 1.0, 12)[:, None])
        path = arm.solve_path(poses)
        angle = arm.arm_angle(path.q[0])
        for aside in (-0.05, -0.01, 0.01, 0.05):
            start = arm.solve(poses[0], arm_angle=angle + aside, seed=path.q[0])
            if path and start:
                paths += 1
                assert path.value <= arm.solve_path(poses, known={0: start.q}).value * (1.0 + 1e-5)
    assert paths > 40


@pytest.mark.parametrize("name", ["iiwa14", "human_left", "sia10f", "openarm_left", "gen3"])
@pytest.mark.parametrize("seeded", [True, False])
def test_a_known_motion_is_never_better(name, seeded):
    arm, rng = load(name), generator(name, 31)
    for _ in range(8 if name != "gen3" else 3):
        known = known_motion(arm, rng, 100, rng.uniform(0.05, 0.14))
        poses = poses_of(arm, known)
        seed = known[0] if seeded else None
        path = arm.solve_path(poses, seed=seed)
        assert not path.breaks
        assert_on_poses(name, arm, poses, path)
        assert total(path, seed) <= (np.diff(known, axis=0) ** 2).sum() * (1.0 + 1e-6)


@pytest.mark.parametrize("name", ["iiwa14", "human_left", "sia10f", "openarm_left"])
@pytest.mark.parametrize("case", ["free", "seeded", "broken"])
def test_brute_force_finds_nothing_better(name, case):
    """As many breaks as an exhaustive search over a fine sweep, and no larger sum."""
    arm, rng = load(name), generator(name, 32)
    known = known_motion(arm, rng, 8, rng.uniform(0.1, 0.3))
    if case == "broken":
        # No motion leads from one half to the other: a break, wherever it costs least.
        known[4:] = known_motion(arm, rng, 4, 0.1)
    poses = poses_of(arm, known)
    seed = known[0] if case == "seeded" else None
    breaks, least = best_path(arm, [swept_postures(arm, pose, 240) for pose in poses], seed, LONGEST)
    path = arm.solve_path(poses, seed=seed)
    assert len(path.breaks) <= breaks
    if len(path.breaks) == breaks:
        assert total(path, seed) <= least * (1.0 + 1e-3)


def broken(arm, rng):
    """Poses of two motions that have nothing to do with each other."""
    return poses_of(arm, np.vstack([known_motion(arm, rng, 30, 0.1), known_motion(arm, rng, 30, 0.1)]))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["iiwa14", "human_left"])
def test_a_break_says_between_which_poses_it_cannot_be_avoided(name):
    arm, rng = load(name), generator(name, 33)
    for _ in range(4):
        poses = broken(arm, rng)
        path = arm.solve_path(poses)
        assert len(path.breaks) == 1
        found = path.breaks[0]
        assert found.earliest <= found.sample <= found.latest
        assert "cannot be avoided" in found.message
        # The poses before, and those behind, need none; one pose more does.
        assert arm.solve_path(poses[: found.latest])
        assert not arm.solve_path(poses[: found.latest + 1])
        assert arm.solve_path(poses[found.earliest :])
        assert not arm.solve_path(poses[found.earliest - 1 :])


def test_a_posture_that_is_given_is_taken():
    arm, rng = load("iiwa14"), generator("iiwa14", 34)
    known = known_motion(arm, rng, 60, 0.1)
    poses = poses_of(arm, known)
    path = arm.solve_path(poses, known={20: known[20], -1: known[-1]})
    assert path
    np.testing.assert_array_equal(path.q[[20, 59]], known[[20, 59]])
    assert (path.steps**2).sum() >= (arm.solve_path(poses).steps ** 2).sum() - 1e-9


def test_between_two_splits_of_a_straight_arm_joints_turn_evenly():
    """Joints 1, 3, 5 and 7 turn about one line, each against the others; no path is shorter than a straight one."""
    arm = load("iiwa14")
    begin, end = np.array([0.4, 0.0, -0.3, 0.0, 0.2, 0.0, 0.1]), np.array([-0.45, 0.0, 0.65, 0.0, -0.35, 0.0, 0.55])
    poses = np.repeat(poses_of(arm, begin[None]), 40, axis=0)
    path = arm.solve_path(poses, known={0: begin, -1: end})
    assert path
    assert path.value == pytest.approx(((end - begin) ** 2).sum() / 39, rel=1e-9)
    assert_on_poses("iiwa14", arm, poses, path)


@pytest.mark.parametrize("name", ["gen3", "human_arm"])
def test_between_given_postures_a_straight_line_of_poses_is_straight(name):
    """Turned by whole turns, too: gen3's joints 1, 3, 5 and 7 have no ends."""
    arm, rng = load(name), generator(name, 39)
    begin, end = configurations(name, 2, 39)
    end = begin + 0.3 * (end - begin)
    known = begin + np.linspace(0.0, 1.0, 30)[:, None] * (end - begin)
    turned = np.where(np.isinf(arm.upper), 2.0 * np.pi * rng.integers(-1, 2, 7), 0.0)
    path = arm.solve_path(poses_of(arm, known), known={0: begin, 29: end + turned})
    assert path
    assert path.value == pytest.approx(((end - begin) ** 2).sum() / 29, rel=1e-9)


def test_a_closed_path_ends_where_it_begins():
    arm = load("iiwa14")
    turn = np.linspace(0.0, 2.0 * np.pi, 80)
    poses = np.repeat(arm.forward_kinematics([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2]).homogeneous[None], 80, 0)
    poses[:, :3, 3] += 0.15 * np.stack([0.0 * turn, np.sin(turn), np.cos(turn) - 1.0], 1)
    poses[-1] = poses[0]
    path, free = arm.solve_path(poses, closed=True), arm.solve_path(poses)
    assert path
    np.testing.assert_array_equal(path.q[0], path.q[-1])
    assert (free.steps**2).sum() - 1e-9 <= (path.steps**2).sum() <= 1.5 * (free.steps**2).sum()


@pytest.mark.slow
@pytest.mark.parametrize("name", ["iiwa14", "human_left", "openarm_left"])
@pytest.mark.parametrize("case", ["known", "broken"])
def test_longer_problems_against_brute_force(name, case):
    """20 poses: as many breaks as an exhaustive search, and a sum of squares within 1e-3 of it where there is none."""
    arm = load(name)
    for number in range(4):
        rng = generator(f"{name} {case} {number}", 38)
        known = known_motion(arm, rng, 20, rng.uniform(0.05, 0.3))
        if case == "broken":
            known[10:] = known_motion(arm, rng, 10, 0.1)
        poses = poses_of(arm, known)
        breaks, least = best_path(arm, [swept_postures(arm, pose, 600) for pose in poses], None, LONGEST)
        path = arm.solve_path(poses)
        assert len(path.breaks) <= breaks
        if not breaks:
            assert total(path, None) <= least * (1.0 + 1e-3)


@pytest.mark.parametrize("objective", ["largest_step", "time"])
@pytest.mark.parametrize("name", ["iiwa14", "human_left"])
@pytest.mark.parametrize("seeded", [True, False])
def test_no_known_motion_has_a_smaller_largest_step_or_takes_less_time(name, objective, seeded):
    arm, rng = load(name), generator(name, 39)

    def value(steps):
        steps = np.abs(steps)
        return steps.max() if objective == "largest_step" else (steps / arm.velocity_limit).max(1).sum()

    for _ in range(3):
        known = known_motion(arm, rng, 80, 0.1)
        path = arm.solve_path(poses_of(arm, known), seed=known[0] if seeded else None, objective=objective)
        assert path
        steps = np.vstack([path.q[0] - known[0], path.steps]) if seeded else path.steps
        assert value(steps) <= value(np.diff(known, axis=0)) * (1.0 + 1e-6)


def test_a_closed_path_has_the_least_largest_step():
    arm = load("iiwa14")
    turn = np.linspace(0.0, 2.0 * np.pi, 60)
    poses = np.repeat(arm.forward_kinematics([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2]).homogeneous[None], 60, 0)
    poses[:, :3, 3] += 0.15 * np.stack([0.0 * turn, np.sin(turn), np.cos(turn) - 1.0], 1)
    poses[-1] = poses[0]
    even, gentle = arm.solve_path(poses, closed=True), arm.solve_path(poses, closed=True, objective="largest_step")
    assert gentle
    np.testing.assert_array_equal(gentle.q[0], gentle.q[-1])
    assert gentle.largest_step <= even.largest_step + 1e-12


@pytest.mark.parametrize("dt", [None, 0.2])
@pytest.mark.parametrize("number", range(4, 9))
def test_a_closed_path_along_limits_stays_closed(number, dt):
    """Postures on limits are taken to their poses once more, and those beside them make room: not the two ends."""
    arm, rng = load("human_arm"), np.random.default_rng(number)
    middle = rng.uniform(np.maximum(arm.lower, -3.0), np.minimum(arm.upper, 3.0))
    turn, sides = np.linspace(0.0, 2.0 * np.pi, 40)[:, None], rng.uniform(-0.2, 0.2, (2, 7))
    known = np.clip(middle + sides[0] * (np.cos(turn) - 1.0) + sides[1] * np.sin(turn), arm.lower, arm.upper)
    known[-1] = known[0]
    poses = poses_of(arm, known)
    path = arm.solve_path(poses, closed=True, dt=dt)
    assert_on_poses("human_arm", arm, poses, path)
    np.testing.assert_array_equal(path.q[0], path.q[-1])


@pytest.mark.parametrize("objective", ["sum_of_squares", "largest_step", "time"])
@pytest.mark.parametrize("count", [1, 3, 40])
def test_a_path_out_of_reach_from_a_start_is_an_answer(objective, count):
    arm = load("iiwa14")
    poses = np.repeat(np.eye(4)[None], count, 0)
    poses[:, 0, 3] = 5.0
    path = arm.solve_path(poses, seed=np.zeros(7), objective=objective)
    assert not path
    assert [each.sample for each in path.breaks] == list(range(count))


def motion_of_benchmark(arm, name, kind, motion, count=200):
    """(count, 7) a motion of `benchmarks/known_motions.py`."""
    benchmark = runpy.run_path(
        str(Path(__file__).parents[1] / "benchmarks" / "known_motions.py"), run_name="known_motions"
    )
    rng = np.random.default_rng([zlib.crc32(name.encode()), benchmark["KINDS"].index(kind), motion])
    return benchmark["known_motion"](arm, rng, kind, count)


def assert_not_worse(name, numbers, motion):
    """A motion along limits, of random numbers for the name `numbers`, is no better than paths through its poses."""
    arm = load(name)
    known = motion_of_benchmark(arm, numbers, "limits", motion)
    poses = poses_of(arm, known)
    for seed in (known[0], None):
        path = arm.solve_path(poses, seed=seed)
        assert_as_good(path, seed, known)
        assert_on_poses(name, arm, poses, path)


def pieces(arm, name, kind, number, count):
    """(20, 7) pieces of motions that have nothing to do with each other, as in `benchmarks/path_truth.py`."""
    benchmark = runpy.run_path(
        str(Path(__file__).parents[1] / "benchmarks" / "known_motions.py"), run_name="known_motions"
    )
    rng = np.random.default_rng([zlib.crc32(name.encode()), benchmark["KINDS"].index(kind), 100_000 + number])
    parts = []
    each = 20 // count
    for _ in range(count):
        stride = int(rng.integers(1, 4))
        known = benchmark["known_motion"](arm, rng, kind, 200)
        first = int(rng.integers(0, 200 - stride * each))
        parts.append(known[first : first + stride * each : stride])
    return np.vstack(parts)


@pytest.mark.parametrize(
    ("name", "kind", "number", "seeded", "breaks"),
    [
        ("iiwa14", "singular", 307, False, 0),
        pytest.param("sia10f", "limits", 302, True, 1, marks=pytest.mark.files),
    ],
)
def test_a_step_that_is_just_short_enough_stays_so(name, kind, number, seeded, breaks):
    """Brute force finds so few breaks, with a step of 0.49999 rad; chords of strips are shorter than the steps."""
    arm = load(name)
    known = pieces(arm, name.rstrip("f"), kind, number, 2)
    poses, seed = poses_of(arm, known), known[0] if seeded else None
    path = arm.solve_path(poses, seed=seed)
    assert_on_poses(name, arm, poses, path)
    assert len(path.breaks) == breaks
    assert (np.abs(path.steps).max(axis=1) > LONGEST).sum() == breaks


def test_of_two_paths_that_seem_as_good_the_better_is_taken():
    """They end in different strips; brute force finds the one whose chords are longer, and whose steps are shorter."""
    arm = load("iiwa14")
    poses = poses_of(arm, pieces(arm, "iiwa14", "singular", 915, 1))
    path = arm.solve_path(poses)
    assert_on_poses("iiwa14", arm, poses, path)
    assert path.value <= 0.0199276


@pytest.mark.files
@pytest.mark.parametrize(
    ("name", "motion"),
    [
        ("human_left", 1008),
        ("human_left", 1053),
        ("human_left", 1055),
        ("human_left", 2036),
        ("openarm_left", 1054),
        ("openarm_left", 2002),
    ],
)
def test_postures_that_two_limits_leave_alone_belong_to_their_strip(name, motion):
    """A pose at which two joints are on limits, one of them next to its singular angle or to a straight elbow."""
    assert_not_worse(name, name, motion)


@pytest.mark.files
@pytest.mark.parametrize(("name", "motion"), [("human_left", 27), ("romeo_left", 25)])
def test_postures_that_rounding_takes_away_are_no_break(name, motion):
    """Shoulder and wrist on limits at once, or the arm straight: a pose has one posture, and no interval holds it."""
    arm = load(name)
    known = motion_of_benchmark(arm, name, "limits", motion)
    assert arm.solve_path(poses_of(arm, known), seed=known[0])


@pytest.mark.files
@pytest.mark.parametrize(
    ("name", "numbers", "motion"), [("human_left", "human_left", 96223), ("sia5d", "motoman_sia5d", 98172)]
)
def test_where_rounding_is_a_tenth_of_a_radian_a_known_motion_is_no_better(name, numbers, motion):
    """Beside a singular posture with other joints on limits, 1e-9 rad of a limit turn joints by up to 0.17 rad."""
    assert_not_worse(name, numbers, motion)


@pytest.mark.files
def test_a_whole_path_is_kept_where_strips_of_more_poses_break():
    """Planned at some poses the path is whole; strips of those that are planned then miss what it touches."""
    assert_not_worse("iiwa14_experimental", load("iiwa14_experimental").name, 98163)


@pytest.mark.parametrize(
    ("name", "kind", "motion"),
    [
        ("iiwa14", "singular", 61),
        ("human_arm", "limits", 10),
        ("human_arm", "limits", 20),
        ("human_arm", "limits", 57),
        ("human_arm", "limits", 58),
        ("gen3", "cross", 16),
        ("gen3", "limits", 26),
        ("gen3", "singular", 27),
        ("gen3", "singular", 61000),
        pytest.param("rm75", "limits", 3007, marks=pytest.mark.files),
        pytest.param("rm75", "limits", 3009, marks=pytest.mark.files),
        pytest.param("rm75", "limits", 71037, marks=pytest.mark.files),
        pytest.param("human_left", "limits", 54053, marks=pytest.mark.files),
        pytest.param("h1_2_left", "cross", 71026, marks=pytest.mark.files),
    ],
)
def test_a_path_that_leads_elsewhere_between_few_poses_is_planned_at_all(name, kind, motion):
    """What joins strips, or ends them, lies between poses 0.25 rad apart, or the arm is almost stretched there."""
    arm = load(name)
    known = motion_of_benchmark(arm, name, kind, motion)
    assert_known_is_no_better(arm, known)


@pytest.mark.slow
def test_a_straight_elbow_and_a_shoulder_that_turn_on_the_spot_turn_together():
    """Where both do, a pose has postures in two directions: joints 1, 3 and 5 share one angle."""
    arm = load("human_arm")
    known = motion_of_benchmark(arm, "human_arm", "limits", 54001)
    assert_known_is_no_better(arm, known)


@pytest.mark.files
def test_an_interval_between_a_limit_and_a_singular_arm_angle_beside_it_is_no_point():
    """Joint 6 has a limit 4e-6 rad behind its singular angle: arm angles as far apart turn joint 5 by 1.3 rad.

    Newton's method takes one posture of the best path 0.008 rad from it, which is 3e-4 of all squares.
    """
    arm = load("human_left")
    known = motion_of_benchmark(arm, "human_left", "limits", 54053)
    path = arm.solve_path(poses_of(arm, known), seed=known[0])
    assert_as_good(path, known[0], known, 5e-4)


@pytest.mark.parametrize(
    ("name", "motion", "count"),
    [
        pytest.param("romeo_left", 5059, 200, marks=pytest.mark.files),
        pytest.param("human_left", 34012, 200, marks=pytest.mark.files),
        pytest.param("human_left", 4003, 2000, marks=[pytest.mark.files, pytest.mark.slow]),
    ],
)
def test_a_path_beside_the_chords_of_coarse_strips_is_found(name, motion, count):
    """The best path along coarse strips is far from the best there is: chords cost less than the curves."""
    arm = load(name)
    known = motion_of_benchmark(arm, name, "limits", motion, count)
    assert_known_is_no_better(arm, known)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "kind", "motion", "seeded"),
    [
        ("gen3", "cross", 4016, True),
        ("gen3", "cross", 4018, False),
        ("gen3", "cross", 6009, False),
        ("gen3", "cross", 38004, False),
        ("gen3", "limits", 740005, False),
        pytest.param("rm75", "limits", 740010, False, marks=pytest.mark.files),
        pytest.param("rm75", "singular", 745009, True, marks=pytest.mark.files),
        pytest.param("rm75", "limits", 32001, True, marks=pytest.mark.files),
        pytest.param("human_left", "limits", 38000, True, marks=pytest.mark.files),
    ],
)
def test_velocity_limits_are_kept_where_a_motion_that_keeps_them_is_known(name, kind, motion, seeded):
    """Steps along coarse strips seem faster than they are, and closing postures next to limits moves them."""
    arm = load(name)
    known = motion_of_benchmark(arm, name, kind, motion)
    dt = 1.05 * float((np.abs(np.diff(known, axis=0)) / arm.velocity_limit).max())
    path = arm.solve_path(poses_of(arm, known), seed=known[0] if seeded else None, dt=dt)
    assert path
    assert (np.abs(path.steps) <= arm.velocity_limit * dt * (1.0 + 1e-9)).all()
    assert (path.steps**2).sum() <= (np.diff(known, axis=0) ** 2).sum()


@pytest.mark.parametrize(("kind", "motion"), [("limits", 6), ("cross", 1)])
def test_the_least_time_is_within_velocity_limits_that_a_known_motion_keeps(kind, motion):
    """A step beyond a limit is not worth what time it saves elsewhere."""
    arm = load("iiwa14")
    known = motion_of_benchmark(arm, "iiwa14", kind, motion)
    shares = np.abs(np.diff(known, axis=0)) / arm.velocity_limit
    dt = 1.1 * float(shares.max())
    path = arm.solve_path(poses_of(arm, known), seed=known[0], objective="time", dt=dt)
    assert path
    assert (np.abs(path.steps) <= arm.velocity_limit * dt * (1.0 + 1e-9)).all()
    assert (np.abs(path.steps) / arm.velocity_limit).max(axis=1).sum() <= shares.max(axis=1).sum()


@pytest.mark.parametrize("name", ["iiwa14", "gen3"])
@pytest.mark.parametrize("count", [5, 43])
def test_nothing_is_left_to_gain_by_moving_all_postures(name, count):
    """Eight go in step, also the last ones of a path whose length is no multiple of that, or less."""
    arm = load(name)
    path = arm.solve_path(poses_of(arm, motion_of_benchmark(arm, name, "aside", 31)[:count]))
    steps = np.vstack([np.zeros(7), path.steps, np.zeros(7)])
    free = ((path.q > arm.lower + 1e-6) & (path.q < arm.upper - 1e-6)).all(axis=1)
    assert free.sum() > 2
    ways = np.array([np.linalg.svd(arm.jacobian(q))[2][-1] for q in path.q]) * free[:, None]
    slope = 2.0 * np.einsum("ij,ij->i", steps[:-1] - steps[1:], ways)
    ends = np.r_[1.0, np.full(count - 2, 2.0), 1.0]
    bend = np.diag(2.0 * ends * np.einsum("ij,ij->i", ways, ways) + 1e-9)
    beside = -2.0 * np.einsum("ij,ij->i", ways[1:], ways[:-1])
    bend += np.diag(beside, 1) + np.diag(beside, -1)
    assert 0.5 * slope @ np.linalg.solve(bend, slope) < 1e-4 * (path.steps**2).sum()


@pytest.mark.files
def test_a_path_is_moved_to_within_velocity_limits_no_farther_than_it_has_to_be():
    """From one as slow as can be, the best one near by is another: 0.941 times the known sum."""
    arm = load("rm75")
    known = motion_of_benchmark(arm, "rm75", "cross", 200003)
    dt = 1.05 * float((np.abs(np.diff(known, axis=0)) / arm.velocity_limit).max())
    path = arm.solve_path(poses_of(arm, known), seed=known[0], dt=dt)
    assert (np.abs(path.steps) <= arm.velocity_limit * dt * (1.0 + 1e-9)).all()
    assert total(path, known[0]) <= 0.92 * (np.diff(known, axis=0) ** 2).sum()
    assert_on_poses("rm75", arm, poses_of(arm, known), path)


@pytest.mark.parametrize(
    ("name", "motion", "seeded", "value"), [("human_arm", 51176, False, 1.52554), ("iiwa14", 51275, True, 0.591405)]
)
def test_postures_between_planned_poses_hide_no_better_path(name, motion, seeded, value):
    """Beside fine strips, chords of coarse ones seem to cost more than they do: paths of these values are known."""
    arm = load(name)
    known = motion_of_benchmark(arm, name, "singular", motion)
    path = arm.solve_path(poses_of(arm, known), seed=known[0] if seeded else None)
    assert path
    assert path.value <= value


@pytest.mark.parametrize(("name", "number"), [("iiwa14", 99800), ("gen3", 99800)])
def test_what_the_best_path_costs_at_least_is_known_where_others_are_looked_for(name, number, monkeypatch):
    """How far around it is looked hangs on what a path may cost more than its plan, which costs little less than it."""
    found = []

    def noted(*told):
        found.append(narrow.costs_to_end(*told))
        return found[-1]

    monkeypatch.setattr(planned, "costs_to_end", noted)
    arm = load(name)
    known = motion_of_benchmark(arm, name, "singular", number)
    path = arm.solve_path(poses_of(arm, known))
    assert path
    assert found
    for rest in found:
        assert 0.9 * path.value < rest.least <= 1.1 * path.value


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "kind", "motion", "seeded"),
    [
        ("gen3", "limits", 81200, True),
        ("gen3", "limits", 98101, False),
        ("gen3", "singular", 81201, False),
        ("gen3", "singular", 98101, True),
        *(
            pytest.param(*each, marks=pytest.mark.files)
            for each in (
                ("rm75", "limits", 98107, False),
                ("rm75", "limits", 410103, False),
                ("rm75", "singular", 410009, True),
                ("j2s7s300", "limits", 410100, False),
                ("h1_2_left", "singular", 410101, True),
            )
        ),
    ],
)
def test_no_known_motion_of_a_near_arm_has_a_smaller_largest_step(name, kind, motion, seeded):
    """Chords of strips on the true chain are too far from it, and their postures too far apart, for steps so short."""
    arm = load(name)
    known = motion_of_benchmark(arm, name, kind, motion)
    path = arm.solve_path(poses_of(arm, known), seed=known[0] if seeded else None, objective="largest_step")
    assert path
    assert path.value <= np.abs(np.diff(known, axis=0)).max()


@pytest.mark.files
@pytest.mark.parametrize("seeded", [True, False])
def test_postures_that_no_strip_holds_are_passed_by_the_others(seeded):
    """Two poses have a posture that rounding leaves alone: steps to it and from it count as well."""
    arm = load("human_left")
    known = motion_of_benchmark(arm, "human_left", "limits", 785018)
    poses = poses_of(arm, known)
    path = arm.solve_path(poses, seed=known[0] if seeded else None, objective="largest_step")
    assert_on_poses("human_left", arm, poses, path)
    assert path.value <= np.abs(np.diff(known, axis=0)).max()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "motion", "seeded", "value"),
    [
        ("gen3", 800000, False, 0.12011),
        pytest.param("j2s7s300", 800001, True, 0.08730, marks=pytest.mark.files),
    ],
)
def test_a_slow_path_of_a_near_arm_is_looked_for_in_finer_strips(name, motion, seeded, value):
    """Steps of 2,000 poses are much shorter than chords of coarse strips are off: paths of these values are known."""
    arm = load(name)
    known = motion_of_benchmark(arm, name, "cross", motion, 2000)
    path = arm.solve_path(poses_of(arm, known), seed=known[0] if seeded else None)
    assert path
    assert total(path, known[0] if seeded else None) <= value


@pytest.mark.parametrize("seeded", [True, False])
def test_a_path_is_the_least_where_nothing_with_smaller_steps_is_left(seeded):
    """The first path found has so small a largest step that no strip is left to be made finer."""
    arm = load("human_arm")
    known = motion_of_benchmark(arm, "human_arm", "limits", 116, 60)
    poses = poses_of(arm, known)
    path = arm.solve_path(poses, seed=known[0] if seeded else None, objective="largest_step")
    assert_on_poses("human_arm", arm, poses, path)
    # It is that of the known motion, but for rounding.
    assert path.lower_bound <= path.value <= np.abs(np.diff(known, axis=0)).max() + 1e-14


@pytest.mark.files
def test_a_path_close_to_its_plan_may_be_bettered():
    """Coarse strips cost 0.2 % too much on the best path: the wrist passes its singular posture five poses earlier."""
    arm = load("sia10f")
    known = motion_of_benchmark(arm, "sia10", "singular", 400040)
    path = arm.solve_path(poses_of(arm, known), seed=known[0])
    assert_as_good(path, known[0], known)


def test_a_path_with_a_slightly_smaller_largest_step_is_found():
    """None has steps below 0.97 of the first path's; one has steps below 0.995."""
    arm = load("iiwa14")
    known = motion_of_benchmark(arm, "iiwa14", "limits", 4006)
    path = arm.solve_path(poses_of(arm, known), objective="largest_step")
    assert path
    assert path.largest_step <= np.abs(np.diff(known, axis=0)).max() * (1.0 + 1e-6)


def test_oblique_axes_that_are_not_in_line_do_not_turn_on_the_spot():
    """The middle joint of an oblique wrist at its end: joints 5 and 7 turned against each other would move the hand."""
    limb = random_limb(26110, "oblique", "straight", "usual", 0.0)
    arm = srs_ik.load(limb.model, base="base", tip="tool")
    known = known_motion(arm, limb.rng, 40, 0.11390067228620228)
    poses = poses_of(arm, known)
    path = arm.solve_path(poses)
    assert_as_good(path, None, known)
    np.testing.assert_allclose(poses_of(arm, path.q), poses, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("straight", [True, False])
def test_joints_share_a_turn_along_a_limit_that_is_singular(straight):
    """Joints 1 and 3 turn about one axis where joint 2 of the human arm is on its lower limit."""
    arm, rng = load("human_arm"), generator("human_arm", 38)
    start = np.array([0.3, arm.lower[1], -1.2, 0.0 if straight else -0.8, -0.3, 0.2, 0.1])
    known = start + np.linspace(0.0, 1.0, 60)[:, None] * [0.25, 0.0, 0.25, 0.0, 0.8, -0.6, 0.2]
    uneven = known.copy()
    turn = np.cumsum(rng.uniform(-0.03, 0.03, 60))
    uneven[:, 0] += turn
    uneven[:, 2] -= turn
    poses = poses_of(arm, known)
    np.testing.assert_allclose(poses_of(arm, uneven), poses, atol=1e-12)
    path = arm.solve_path(poses, seed=known[0])
    assert_as_good(path, known[0], known)


def test_the_largest_step_and_the_time_are_smaller_where_they_are_wanted():
    arm, rng = load("iiwa14"), generator("iiwa14", 35)
    for _ in range(3):
        known = known_motion(arm, rng, 60, 0.1)
        poses = poses_of(arm, known)
        even = arm.solve_path(poses)
        gentle, quick = (arm.solve_path(poses, objective=name) for name in ("largest_step", "time"))
        assert gentle
        assert quick
        assert gentle.largest_step <= min(even.largest_step, np.abs(np.diff(known, axis=0)).max() * (1.0 + 1e-6))
        times = [(np.abs(p.steps) / arm.velocity_limit).max(1).sum() for p in (quick, even)]
        assert times[0] <= times[1] + 1e-9


@pytest.mark.parametrize("name", ["iiwa14", "human_left"])
def test_velocity_limits_that_a_known_motion_keeps_are_kept(name):
    arm, rng = load(name), generator(name, 36)
    for _ in range(6):
        known = known_motion(arm, rng, 80, 0.1)
        dt = 1.05 * (np.abs(np.diff(known, axis=0)) / arm.velocity_limit).max()
        path = arm.solve_path(poses_of(arm, known), seed=known[0], dt=dt)
        assert path
        assert (np.abs(path.steps) <= arm.velocity_limit * dt * (1.0 + 1e-9)).all()


def test_a_long_path_is_found_block_by_block():
    arm = load("iiwa14")
    rng = generator("iiwa14", 37)
    short = known_motion(arm, rng, 700, 0.1)
    path = arm.solve_path(poses_of(arm, short), seed=short[0])
    assert path
    assert total(path, short[0]) <= (np.diff(short, axis=0) ** 2).sum()


@pytest.mark.parametrize(
    ("options", "named"),
    [
        ({"objective": "jerk"}, "objective is one of"),
        ({"known": {9: np.zeros(7)}}, "no pose 9"),
        ({"known": {0: np.full(7, 9.0)}}, "outside the joint limits"),
        ({"known": {0: np.zeros(7)}}, "does not meet it"),
        ({"closed": True}, "closed"),
    ],
)
def test_wrong_wishes_are_refused(options, named):
    arm = load("iiwa14")
    poses = poses_of(arm, np.linspace(np.full(7, 0.2), np.full(7, 0.4), 3))
    with pytest.raises(srs_ik.InvalidConfiguration, match=named):
        arm.solve_path(poses, **options)


LONG_STEPS = (
    (-4.12, -0.65, 1.33, -0.76, -2.62, -0.76, 2.62),
    (-3.70, -0.54, 0.63, -0.86, -1.93, -1.02, 2.51),
    (-3.19, -0.32, -0.03, -0.92, -1.18, -1.19, 2.38),
    (-2.62, 0.02, -0.60, -0.96, -0.41, -1.26, 2.25),
    (-2.04, 0.42, -1.05, -0.98, 0.28, -1.22, 2.09),
    (-1.50, 0.85, -1.34, -0.96, 0.83, -1.09, 1.93),
)
"""Some joints step farther than is continuous; beside these postures are others whose steps are just short enough."""


@pytest.mark.slow
def test_a_short_path_of_a_near_arm_whose_steps_are_just_short_enough_is_found():
    """Chords of coarse strips are too long there: finer ones must not be left out for that."""
    arm = load("gen3")
    poses = poses_of(arm, np.array(LONG_STEPS))
    path = arm.solve_path(poses)
    assert_on_poses("gen3", arm, poses, path)
    breaks, least = best_path(arm, [swept_postures(arm, pose, 200) for pose in poses], None, LONGEST)
    assert breaks == len(path.breaks) == 0
    assert path.value <= least


@pytest.mark.parametrize("given", [3, 30])
def test_a_near_arm_stays_where_it_is_known_to_be_if_its_pose_stays(given):
    """A plan by coarse strips costs more there than the path does once it is improved, which costs nothing."""
    arm = load("gen3")
    q = np.full(7, 0.3)
    path = arm.solve_path(poses_of(arm, np.tile(q, (31, 1))), known={given: q})
    assert path
    # Up to whole turns of joints without end.
    np.testing.assert_allclose(np.cos(path.q - q), 1.0, atol=1e-15)
    assert path.largest_step < 1e-9


def straight_line(count=40):
    """Postures of iiwa14 on a straight line of joint angles, well inside the limits."""
    q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    return q + np.linspace(0.0, 1.0, count)[:, None] * [0.5, 0.2, 0.3, -0.3, 0.2, 0.1, 0.9]


def test_where_only_the_longest_step_stops_a_path_no_limit_is_blamed():
    """Without limits, steps would be too long as well."""
    arm = load("iiwa14")
    poses = poses_of(arm, straight_line())
    first = arm.solve_path(poses, longest_step=0.01).breaks[0]
    assert first.sample == 1
    assert "in one step" in first.message
    assert "limit by" not in first.message


@pytest.mark.slow
def test_how_much_of_the_velocity_limits_a_path_takes_is_told():
    arm = load("iiwa14")
    poses = poses_of(arm, straight_line())
    assert arm.solve_path(poses).velocity_use is None
    for dt, free_axis in ((1e-4, None), (0.1, None), (1e-4, [0.0, 0.0, 1.0])):
        path = arm.solve_path(poses, dt=dt, free_axis=free_axis)
        expected = (np.abs(np.diff(path.q, axis=0)) / (dt * arm.velocity_limit)).max(axis=1)
        np.testing.assert_allclose(path.velocity_use, expected, rtol=1e-9)
        assert ("times the velocity limits" in repr(path)) == bool((expected > 1.0 + 1e-9).any())


@pytest.mark.parametrize("count", [1, 3])
@pytest.mark.parametrize("options", [{}, {"objective": "time"}, {"closed": True}, {"free_axis": [0, 0, 1]}])
def test_a_path_that_stays_is_as_far_from_the_limits_as_its_pose_lets_it(count, options):
    """All postures cost the same there."""
    arm = load("iiwa14")
    pose = srs_ik.pose_from_xyz_rpy([0.5, 0.1, 0.6], [0.0, np.pi / 2.0, 0.0])
    path = arm.solve_path([pose] * count, **options)
    assert path
    assert np.ptp(path.q, axis=0).max() < 1e-9
    free = {key: options[key] for key in options if key == "free_axis"}
    best = arm.solve(pose, **free).q
    margins = [np.minimum(q - arm.lower, arm.upper - q).min() for q in (path.q[0], best)]
    assert margins[0] == pytest.approx(margins[1], abs=1e-6)
    assert margins[1] > 0.5


def test_a_path_that_stays_in_a_scene_hits_nothing_and_is_far_from_the_limits():
    arm, scene = load("iiwa14"), srs_ik.Scene()
    pose = srs_ik.pose_from_xyz_rpy([0.5, 0.1, 0.6], [0.0, np.pi / 2.0, 0.0])
    scene.add_sphere("ball", arm.centres(arm.solve(pose).q).elbow, 0.1)
    path, best = arm.solve_path([pose] * 3, scene=scene), arm.solve(pose, scene=scene)
    assert path
    assert arm.collision(path.q[0], scene=scene) is None
    margins = [np.minimum(q - arm.lower, arm.upper - q).min() for q in (path.q[0], best.q)]
    assert margins[0] == pytest.approx(margins[1], abs=1e-6)
