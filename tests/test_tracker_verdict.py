"""What a tracker makes of targets that rest, with a free turn and without, and what it says of them.

Errors are Pinocchio's, on the robot's own file; what no turn reaches is found by a dense sweep of them.
"""

import warnings

import arms
import numpy as np
import pinocchio as pin
import pytest
from scipy.optimize import least_squares
from tracked import velocities

from srs_ik import FreeAxis

DT = 0.01
MET = 1e-6
"""A tip this close to its target, m and rad, is on it."""

HERE = arms.here("made_oblique", "made_folded", "h1_2_left")

ROLL = FreeAxis([0, 0, 1])
ANY = FreeAxis(cone=np.pi)


def inside(arm, share=1.0):
    """Limits, at most half a turn away from zero; a share of them."""
    return share * np.maximum(arm.lower, -np.pi), share * np.minimum(arm.upper, np.pi)


def tracker_of(name, q0, free=None):
    return arms.load(name).tracker(q0, DT, velocities(arms.load(name)), free_axis=free, smoothing=0.0)


def off(tip, wanted, free=None):
    """Metres, and radians between two poses but for what is free."""
    if free is None:
        turned = np.linalg.norm(pin.log3(tip.rotation.T @ wanted.rotation))
    else:
        a, b = tip.rotation @ free.axis, wanted.rotation @ free.axis
        turned = max(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b) - free.cone, 0.0)
    return np.linalg.norm(tip.translation - wanted.translation), turned


def far_apart(name, rng):
    """Two postures at random, inside the limits."""
    lower, upper = inside(arms.load(name))
    return rng.uniform(lower, upper), rng.uniform(lower, upper)


def rest_on(name, tracker, target, seconds, free=None):
    """The statuses until the tip is on a target that rests, and the last step; a tip said to be there is."""
    said = []
    for _ in range(round(seconds / DT)):
        step = tracker.update(target)
        said.append(str(step.status))
        if step:
            assert max(off(arms.forward(name)(step.q), target, free)) < MET
            break
    return said, step


def assert_true(name, tracker, target, seconds, free=None):
    """A target that some posture reaches is come to, or `reconfigure` leads there; it is never called unreachable."""
    said, step = rest_on(name, tracker, target, seconds, free)
    assert "UNREACHABLE" not in said
    if not step:
        assert step.status == "HELD"
        assert "reconfigure()" in step.message
        assert tracker.reconfigure()
        said, step = rest_on(name, tracker, target, seconds, free)
    assert step
    return len(said)


@pytest.mark.parametrize("cone", [0.05, 0.3])
@pytest.mark.parametrize("name", ["iiwa14", "gen3"])
def test_a_target_at_rest_is_met_with_a_cone_no_later_than_with_the_roll_alone(name, cone):
    """A cone that counted twice left half of the tips outside of it, at rest or for seconds."""
    arm, forward, rng = arms.load(name), arms.forward(name), np.random.default_rng(21)
    lower, upper = inside(arm, 0.8)
    for _ in range(20):
        q0 = rng.uniform(lower, upper)
        target = forward(np.clip(q0 + rng.normal(0.0, 0.25, 7), *inside(arm)))
        updates = []
        for free in (FreeAxis([0, 0, 1], cone=cone), ROLL):
            said, step = rest_on(name, tracker_of(name, q0, free), target, 3.0, free)
            assert step
            updates.append(len(said))
        # The ways differ; by no more than 0.2 s.
        assert updates[0] <= updates[1] + 20


@pytest.mark.parametrize(("cone", "most"), [(0.05, 2e-3), (0.2, MET)])
def test_a_slow_target_is_not_trailed_outside_of_a_cone(cone, most):
    """The roll alone, which the cone contains, was followed all the time; with the cone the tip was outside of it."""
    arm, forward, rng = arms.load("iiwa14"), arms.forward("iiwa14"), np.random.default_rng(3)
    free = FreeAxis([0, 0, 1], cone=cone)
    for _ in range(5):
        q0, way = rng.uniform(*inside(arm, 0.6)), rng.normal(0.0, 0.2, 7)
        tracker = arm.tracker(q0, 0.002, free_axis=free)
        for k in range(2000):
            target = forward(q0 + way * np.sin(0.003 * k))
            q = tracker.update(target).q
            if k > 500 and k % 10 == 0:
                position, turned = off(forward(q), target, free)
                assert position < 1e-3
                assert turned < most


@pytest.mark.parametrize(("name", "free"), [("iiwa14", ROLL), ("iiwa14", ANY), ("human_arm", ROLL)])
def test_what_some_turn_reaches_is_not_said_to_be_unreachable(name, free):
    """One turn was taken for all: up to 4 of 30 targets that `solve` has a posture for ended as unreachable."""
    rng = np.random.default_rng(3)
    for _ in range(30):
        q0, q1 = far_apart(name, rng)
        assert_true(name, tracker_of(name, q0, free), arms.forward(name)(q1), 12.0, free)


@pytest.mark.parametrize("axis", [[1, 0, 0], [1, 0, 1], [0, 0, 1]])
def test_out_of_reach_means_at_all_turns(axis):
    """Targets around the end of the reach, where some turns are inside of it for part of them."""
    arm, free, rng = arms.load("iiwa14"), FreeAxis(axis), np.random.default_rng(5)
    rolls = np.array([pin.exp3(angle * free.axis) for angle in np.linspace(0.0, 2.0 * np.pi, 180, endpoint=False)])
    reached = []
    for _ in range(20):
        target = arm.forward_kinematics(rng.uniform(*inside(arm))).homogeneous
        centre = np.array([0.0, 0.0, 0.36])
        way = target[:3, 3] - centre
        target[:3, 3] = centre + rng.uniform(0.78, 1.02) * way / np.linalg.norm(way)
        poses = np.repeat(target[None], len(rolls), axis=0)
        poses[:, :3, :3] = target[:3, :3] @ rolls
        reached.append(bool(arm.solve_batch(poses, respect_limits=False).ok.any()))
        tracker = tracker_of("iiwa14", np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2]), free)
        said = ["out of reach" in tracker.update(target).message for _ in range(300)]
        assert said[-1] == (not reached[-1])
        assert said[-1] or not any(said)
    assert 3 < sum(reached) < 17


def near_ones():
    """Postures to start from and to reach."""
    gen3 = [
        [-0.4196, -1.6455, 3.089, 0.2552, -2.5207, 1.4696, -0.4393],
        [0.8495, -1.5355, -0.656, -0.0103, -0.0173, 1.3366, -0.0265],
    ]
    seeds = {"made_oblique": (12, 105, 188, 340), "made_folded": (351,), "h1_2_left": (12, 89)}
    drawn = [(name, *far_apart(name, np.random.default_rng(k))) for name in seeds if name in HERE for k in seeds[name]]
    return [("gen3", *np.array(gen3)), *drawn]


ALL_SEARCHED = [
    ("iiwa14", None, 201),
    ("gen3", None, 12),
    ("made_oblique", None, 114),
    ("made_oblique", None, 124),
    ("h1_2_left", None, 86),
    ("iiwa14", ROLL, 40),
    ("made_oblique", ROLL, 59),
    ("made_oblique", ROLL, 76),
    ("made_folded", ROLL, 70),
    ("h1_2_left", ROLL, 12),
    ("h1_2_left", ROLL, 59),
    ("h1_2_left", ROLL, 60),
]


@pytest.mark.parametrize(("name", "free", "seed"), [case for case in ALL_SEARCHED if case[0] in arms.here(case[0])])
def test_what_the_whole_redundancy_has_is_not_said_to_be_unreachable(name, free, seed):
    """Postures that no step leads to from those of the exact limb, and goals that went around in circles for ever."""
    q0, q1 = far_apart(name, np.random.default_rng(seed))
    assert_true(name, tracker_of(name, q0, free), arms.forward(name)(q1), 8.0, free)


@pytest.mark.parametrize("name", arms.here("h1_2_left"))
def test_a_goal_on_its_target_is_not_drawn_off_it_by_the_joints(name):
    """It was, and the tip rested 0.034 mm off a target for ever."""
    q0, q1 = far_apart(name, np.random.default_rng(208))
    _, step = rest_on(name, tracker_of(name, q0), arms.forward(name)(q1), 8.0)
    assert step


def misses(name, target):
    """How far SciPy's closest posture inside the limits, of many starts, is from a target: m and rad together."""
    forward, (lower, upper) = arms.forward(name), inside(arms.load(name))
    rng = np.random.default_rng(0)

    def left(q):
        tip = forward(q)
        return np.concatenate([tip.translation - target.translation, pin.log3(tip.rotation.T @ target.rotation)])

    starts = rng.uniform(lower, upper, (40, 7))
    return min(np.linalg.norm(least_squares(left, q, bounds=(lower, upper), max_nfev=60).fun) for q in starts)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "seed"), [("gen3", 53), ("gen3", 87), ("gen3", 13), ("made_oblique", 31)])
def test_a_target_at_rest_beside_the_limits_is_said_to_be_unreachable(name, seed):
    """It was on its way for ever, where it missed by no more than the nearest exact limb can tell."""
    rng = np.random.default_rng(77000 + seed)
    q0, q1 = far_apart(name, rng)
    target = arms.forward(name)(q1)
    target = pin.SE3(target.rotation @ pin.exp3(rng.normal(0.0, 1.0, 3)), target.translation)
    assert misses(name, target) > 100.0 * MET
    said, step = rest_on(name, tracker_of(name, q0), target, 8.0)
    assert step.status == "UNREACHABLE"
    assert set(said[-100:]) == {"UNREACHABLE"}


@pytest.mark.parametrize(("name", "q0", "q1"), near_ones())
def test_a_near_arm_tries_more_than_the_nearest_posture_of_its_exact_limb(name, q0, q1):
    """That one did not lead onto the target on the true chain, and the target counted as unreachable."""
    assert_true(name, tracker_of(name, q0), arms.forward(name)(q1), 8.0)


def reach_of(arm):
    """The largest distance of the wrist from the shoulder, m."""
    bent = np.zeros((721, 7))
    bent[:, 3] = np.linspace(-np.pi, np.pi, 721)
    return max(np.linalg.norm(arm.centres(q)[2] - arm.centres(q)[0]) for q in bent)


def miss_of(tip, wanted, free, reach):
    """What a tip misses, m, turns by the reach."""
    metres, turned = off(tip, wanted, free)
    return np.hypot(metres, reach * turned)


EVERY = {"none": None, "roll": ROLL, "narrow": FreeAxis([0, 0, 1], cone=0.1), "cone": FreeAxis([0, 1, 1], cone=0.5)}


@pytest.mark.parametrize("free", [*EVERY.values(), ANY], ids=[*EVERY, "any"])
@pytest.mark.parametrize("name", arms.here("iiwa14", "gen3", "human_arm", "made_oblique", "made_bent"))
def test_joints_come_to_rest_where_a_target_at_rest_is_out_of_reach_as_close_as_they_come(name, free):
    """Out of reach and beyond limits: they went past the edge of a cone for ever, and about straight elbows."""
    arm, forward, rng = arms.load(name), arms.forward(name), np.random.default_rng(1)
    reach, missed = reach_of(arm), 0
    for k in range(8):
        q0, q1 = far_apart(name, rng)
        target = forward(q1)
        target.translation *= (0.7, 1.0, 1.1, 1.6)[k % 4]
        tracker = tracker_of(name, q0, free)
        for _ in range(4000):
            step = tracker.update(target)
        before = step.q
        for _ in range(300):
            step = tracker.update(target)
        if step.status != "UNREACHABLE":
            continue
        missed += 1
        # Less than a milliradian in three seconds, where 0.8 rad were.
        assert np.abs(step.q - before).max() < 1e-3
        ways = np.clip(step.q + rng.normal(0.0, 0.02, (200, 7)), arm.lower, arm.upper)
        nearest = min(miss_of(forward(way), target, free, reach) for way in ways)
        # A radian that brings the tip closer by less than 0.1 mm is not worth it; these are of 0.1 rad at most.
        assert nearest > miss_of(forward(step.q), target, free, reach) - 1e-5
    assert missed


def test_at_rest_off_the_target_the_joint_is_one_that_stands_at_its_limit():
    """None is behind any more then. Limits are looked at anew, and the arm rests as joint angles tell."""
    arm, rng = arms.load("iiwa14"), np.random.default_rng(3)
    lower, upper = inside(arm)
    told = set()
    for k in range(40):
        q0, q = lower + (upper - lower) * np.array([rng.uniform(0.2, 0.8, 7), rng.uniform(0.0, 1.0, 7)])
        T = arm.forward_kinematics(q)
        T.translation = T.translation * (1.15 if k % 2 else 1.0)
        tracker = arm.tracker(q0, DT)
        steps = [tracker.update(T) for _ in range(600)]
        last = steps[-1]
        if last or np.abs(last.q - steps[-10].q).max() > 1e-6:
            continue
        left = np.minimum(last.q - arm.lower, arm.upper - last.q)
        assert last.joint == (arm.joint_names[int(left.argmin())] if left.min() < 1e-3 else None)
        told.add(last.joint)
    assert None in told
    assert len(told) > 3


def test_joints_that_are_fed_back_before_every_update_are_warned_of_once():
    arm = arms.load("iiwa14")
    q0 = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    T = arm.forward_kinematics(q0)
    tracker, q = arm.tracker(q0, DT), q0
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        for k in range(100):
            T.translation += [0.0, 1e-3 * np.cos(0.1 * k), 0.0]
            tracker.reset(q)
            q = tracker.update(T).q
    assert [str(each.message).rpartition(": ")[2].partition(",")[0] for each in told] == [
        "do not feed measured joints back"
    ]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for _ in range(50):
            tracker.reset(q0)
            assert [tracker.update(T) for _ in range(2)]


def test_a_target_at_the_end_of_what_is_a_pose_has_a_finite_error():
    pytest.importorskip("ruckig")
    arm, away = arms.load("iiwa14"), 1e300
    tracker = arm.tracker(np.zeros(7), DT, jerk=100.0, free_axis=ROLL)
    step = tracker.update(pin.SE3(np.eye(3), np.array([away, 0.0, 0.0])))
    np.testing.assert_allclose(step.position_error, away)
