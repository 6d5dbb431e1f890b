"""Trackers in a scene: the arm stops before it hits, inside its limits, and follows again once the way is free.

What hits is told by Pinocchio on the robot's own file.
"""

from copy import deepcopy

import arms
import coal
import numpy as np
import pinocchio as pin
import pytest
from collision_oracle import Truth, file_of_and

import srs_ik
from srs_ik import InvalidScene, Scene

DT = 0.004
ROUNDING = 1e-9
"""Limits are kept to this, rad, rad/s and rad/s^2."""

SIZE = np.array([0.5, 0.5, 0.04])
AWAY = 0.3
"""A plate, and how far its middle is from the tip, m."""

START = {
    "iiwa14": [0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2],
    "gen3": [-0.2, -0.6, 0.2, -2.4, 2.8, -1.2, -2.6],
    "human_arm": [0.2, -0.6, 0.1, -0.9, 0.6, -1.2, -0.0],
}
"""Postures well inside the limits, and bent, whose tips have nothing below, rad."""


class World:
    """An arm and a plate in the way of its tip, at an angle from upright."""

    def __init__(self, name, tilt=0.0, **options):
        self.arm, self.q0 = arms.load(name), np.array(START[name])
        self.T = self.arm.forward_kinematics(self.q0).homogeneous
        self.down = pin.exp3(np.array([tilt, 0.0, 0.0])) @ np.array([0.0, 0.0, -1.0])
        self.plate = np.eye(4)
        self.plate[:3, :3] = pin.exp3(np.array([tilt, 0.0, 0.0]))
        self.plate[:3, 3] = self.T[:3, 3] + AWAY * self.down
        self.scene = Scene()
        self.scene.add_box("plate", self.plate, SIZE)
        self.truth = Truth(*file_of_and(self.arm))
        self.truth.add("plate", self.plate, coal.Box(*SIZE))
        assert not self.truth.collides(self.q0)
        known = np.isfinite(self.arm.velocity_limit) & (self.arm.velocity_limit > 0.0)
        self.speeds = np.where(known, self.arm.velocity_limit, 2.0)
        self.tracker = self.arm.tracker(self.q0, DT, self.speeds, **({"scene": self.scene} | options))

    def target(self, depth, noise=None):
        """A pose that much farther down than the tip was at first."""
        T = self.T.copy()
        T[:3, 3] += depth * self.down
        if noise is not None:
            T[:3, 3] += noise.normal(0.0, 5e-4, 3)
            T[:3, :3] = T[:3, :3] @ pin.exp3(noise.normal(0.0, 2e-3, 3))
        return T

    def follow(self, targets):
        """The steps: all inside the limits, and none hits."""
        before = self.tracker.q
        steps = [self.tracker.update(T) for T in targets]
        q = np.array([step.q for step in steps])
        assert (q >= self.arm.lower).all()
        assert (q <= self.arm.upper).all()
        velocity = np.diff(np.vstack([before, q]), axis=0) / DT
        assert (np.abs(velocity) <= self.tracker.velocity_limit + ROUNDING).all()
        acceleration = np.diff(velocity, axis=0) / DT
        assert (np.abs(acceleration) <= self.tracker.acceleration_limit + ROUNDING).all()
        np.testing.assert_allclose([step.velocity for step in steps], velocity, atol=1e-9)
        np.testing.assert_allclose([step.acceleration for step in steps][1:], acceleration, atol=1e-6)
        return steps

    def hits(self, steps):
        """How many of some steps hit anything."""
        return sum(self.truth.collides(step.q) for step in steps)


def there_and_back(speed, depth):
    """(n,) depths of a target that goes into the plate, waits, comes back and waits, m."""
    way = np.arange(0.0, depth, speed * DT)
    return np.concatenate([way, np.full(round(0.3 / DT), depth), way[::-1], np.zeros(round(1.2 / DT))])


MOTIONS = {
    "straight": (0.0, 0.4, False),
    "at an angle": (0.8, 0.4, False),
    "fast": (0.0, 1.0, False),
    "jittered": (0.0, 0.4, True),
}


@pytest.mark.parametrize("name", START)
@pytest.mark.parametrize("motion", MOTIONS)
def test_the_arm_stops_before_a_plate_and_follows_again(name, motion):
    tilt, speed, jitters = MOTIONS[motion]
    world, noise = World(name, tilt), np.random.default_rng(1) if jitters else None
    depths = there_and_back(speed, AWAY + 0.1)
    steps = world.follow([world.target(depth, noise) for depth in depths])
    assert world.hits(steps) == 0
    # Into the plate, the target's pose itself hits.
    deep = int(np.argmax(depths)) + round(0.28 / DT)
    assert steps[deep].status == "HELD"
    assert steps[deep].collision.second == "plate"
    assert steps[-1].position_error < 5e-3
    if not jitters:
        assert steps[-1]


@pytest.mark.parametrize("name", START)
@pytest.mark.parametrize("elbow", ["keep", "scene"])
def test_a_target_that_jumps_behind_the_plate_is_not_followed_through_it(name, elbow):
    world = World(name)
    if elbow == "scene":
        world.tracker = world.arm.tracker(world.q0, DT, world.speeds, elbow=world.scene)
    steps = world.follow([world.target(AWAY + 0.12)] * 300 + [world.target(0.0)] * 400)
    assert world.hits(steps) == 0
    assert steps[299].collision is not None
    assert steps[-1]


def test_a_table_that_the_elbow_keeps_away_from_is_stopped_before():
    """The arm went 14 cm into it, and the step said that it was on the target."""
    arm = arms.load("iiwa14")
    q0 = np.array(START["iiwa14"])
    T, scene = arm.forward_kinematics(q0).homogeneous, Scene()
    scene.add_box("table", srs_ik.pose_from_xyz_rpy([0.6, 0.0, 0.1], [0.0, 0.0, 0.0]), [0.6, 0.8, 0.05])
    tracker, top = arm.tracker(q0, DT, elbow=scene), T[2, 3]
    for depth in np.arange(0.0, top, 1e-3):
        T[2, 3] = top - depth
        step = tracker.update(T)
        assert arm.collision(step.q, scene) is None
        assert not (step and arm.solve(T, scene=scene).status == srs_ik.Status.COLLISION)
    assert arm.solve(T, scene=scene).status == srs_ik.Status.COLLISION
    assert step.status == "HELD"
    assert step.collision.second == "table"
    assert step.message.startswith(f"{step.collision.first} would come too close to table, and the arm stops before: ")


@pytest.mark.parametrize("name", START)
def test_at_rest_the_tracker_is_on_just_those_targets_that_a_free_posture_close_by_meets(name):
    """Spheres around the links are up to 34 mm too large; what the real shapes leave is reached."""
    world = World(name)
    q, last = world.tracker.q, None
    for depth in np.arange(0.0, AWAY, 0.01):
        T = world.target(depth)
        step = world.follow([T] * 60)[-1]
        if step.collision is not None:
            # The posture that the arm would have gone on to hits, or comes closer than it is looked at.
            free = world.arm.solve(T, seed=last)
            assert not free or world.truth.deepest(free.q)[0] > -1e-3
            break
        if step:
            assert not world.truth.collides(step.q)
            last = step.q
    assert last is not None
    assert depth > 0.05
    assert np.abs(last - q).max() > 0.01


def test_the_margin_is_left():
    world = World("iiwa14", margin=0.03)
    steps = world.follow([world.target(depth) for depth in there_and_back(0.4, AWAY)])
    nearest = max(world.truth.deepest(step.q)[0] for step in steps[::5])
    # Distances are known to 1e-5 m; the arm stops 0.3 mm before it must.
    assert -0.032 < nearest < -0.03 + 1e-5
    assert steps[-1]


def test_an_arm_that_begins_in_contact_comes_out_and_goes_no_deeper():
    world = World("iiwa14")
    deep = world.arm.solve(world.target(AWAY - 0.03), seed=world.q0).q
    depth = world.truth.deepest(deep)[0]
    assert depth > 0.005
    world.tracker = world.arm.tracker(deep, DT, world.speeds, scene=world.scene)
    steps = world.follow([world.target(AWAY)] * 100)
    assert {step.status for step in steps} == {"HELD"}
    assert max(world.truth.deepest(step.q)[0] for step in steps) < depth + 2e-5
    assert f"{steps[-1].collision.first} and plate are " in steps[-1].message
    assert "mm too close, and the arm only moves apart" in steps[-1].message
    still = world.arm.forward_kinematics(world.tracker.q)
    assert world.tracker.update(still).status == "HELD"
    steps = world.follow([world.target(0.0)] * 500)
    depths = [world.truth.deepest(step.q)[0] for step in steps]
    # Deeper by 2e-5 m at most, what distances are known to.
    assert (np.diff(np.maximum(depths, 0.0)) < 2e-5).all()
    assert steps[-1]
    assert not world.truth.collides(steps[-1].q)


def test_objects_that_are_moved_count_where_they_are():
    world = World("iiwa14")
    gone = np.eye(4)
    gone[:3, 3] = [5.0, 5.0, 5.0]
    held = world.follow([world.target(AWAY)] * 200)
    assert held[-1].status == "HELD"
    world.scene.move("plate", gone)
    assert world.follow([world.target(AWAY)] * 300)[-1]
    world.follow([world.target(0.0)] * 300)
    world.scene.move("plate", world.plate)
    steps = world.follow([world.target(AWAY)] * 200)
    assert steps[-1].status == "HELD"
    assert world.hits(steps) == 0
    world.scene.remove("plate")
    assert world.follow([world.target(AWAY)] * 300)[-1]


def test_what_the_hand_holds_counts():
    world, held = World("iiwa14"), np.eye(4)
    held[:3, 3] = [0.0, 0.0, 0.1]
    arm = world.arm.with_object("rod", held, radius=0.02, length=0.2)
    # The hand points down.
    T = world.T.copy()
    T[:3, :3] = np.diag([1.0, -1.0, -1.0])
    q0 = arm.solve(T, seed=world.q0).q
    tracker = arm.tracker(q0, DT, scene=world.scene)
    for depth in np.arange(0.0, AWAY, 1e-3):
        T[2, 3] = world.T[2, 3] - depth
        step = tracker.update(T)
        assert arm.collision(step.q, world.scene) is None
    assert step.collision[:2] == ("rod", "plate")


def test_the_arm_stops_before_itself():
    arm = arms.load("iiwa14")
    q0 = np.array([0.0, 1.0, 0.0, -1.6, 0.0, 1.0, 0.0])
    target = np.array([0.0, 1.8, 0.0, -2.0, 0.0, 1.4, 0.0])
    assert arm.collision(target, Scene()) is not None
    tracker = arm.tracker(q0, DT, scene=Scene())
    for share in np.linspace(0.0, 1.0, 500):
        step = tracker.update(arm.forward_kinematics(q0 + share * (target - q0)))
        assert arm.collision(step.q, Scene()) is None
    assert step.collision is not None


def test_jerk_limits_and_a_scene_hold_together():
    pytest.importorskip("ruckig")
    world, jerk = World("iiwa14"), 500.0
    world.tracker = world.arm.tracker(world.q0, DT, world.speeds, jerk=jerk, scene=world.scene)
    steps = world.follow([world.target(depth) for depth in there_and_back(0.6, AWAY + 0.1)])
    assert world.hits(steps) == 0
    assert any(step.collision for step in steps)
    assert steps[-1]
    pushes = np.array([step.acceleration for step in steps])
    assert (np.abs(np.diff(pushes, axis=0)) <= jerk * DT * (1.0 + 1e-6) + 1e-6).all()


def test_reconfigure_goes_to_a_free_posture():
    world = World("iiwa14")
    T = world.target(AWAY)
    assert world.tracker.reconfigure(T).status == srs_ik.Status.COLLISION
    assert world.tracker.reconfigure(world.target(0.05))
    assert world.follow([world.target(0.05)] * 300)[-1]


def test_a_scene_stays_when_the_elbow_does_something_else():
    arm, scene, other = arms.load("iiwa14"), Scene(), Scene()
    tracker = arm.tracker(START["iiwa14"], DT, elbow=scene)
    assert tracker.scene is scene
    tracker.elbow = "keep"
    assert tracker.scene is scene
    tracker.elbow = other
    assert tracker.scene is other
    given = arm.tracker(START["iiwa14"], DT, elbow=scene, scene=other, margin=0.01)
    assert given.scene is other
    assert given.margin == 0.01
    assert deepcopy(given).scene is not other
    assert arm.tracker(START["iiwa14"], DT).scene is None


def test_what_is_no_scene_is_refused():
    arm = arms.load("iiwa14")
    with pytest.raises(InvalidScene, match=r"a scene is a srs_ik\.Scene, not 'table'"):
        arm.tracker(START["iiwa14"], DT, scene="table")
    with pytest.raises(InvalidScene, match="margin= goes with scene="):
        arm.tracker(START["iiwa14"], DT, margin=0.01)
    with pytest.raises(InvalidScene, match="margin"):
        arm.tracker(START["iiwa14"], DT, scene=Scene(), margin=-1.0)


def test_joints_that_brake_come_to_rest_as_their_limits_say():
    from srs_ik.solve.tracker.braking import braking

    q, v, push = np.zeros(7), np.array([1.0, -1.0, 0.5, 0.0, 0.013, 2.0, -0.3]), np.full(7, 10.0)
    ends = np.full(7, -np.inf), np.full(7, np.inf)
    way = braking(q, v, push, 0.004, ends)
    velocity = np.diff(way, axis=0) / 0.004
    assert (np.abs(np.diff(np.vstack([v, velocity]), axis=0)) <= 10.0 * 0.004).all()
    assert np.abs(velocity[-1]).max() <= 10.0 * 0.004
    # In continuous time it is v^2 / 2a; in periods half a period less.
    np.testing.assert_allclose(way[-1], v * np.abs(v) / 20.0 - 0.5 * 0.004 * v, atol=1e-4)
    many = braking(q, v, push, 1e-6, ends)
    np.testing.assert_allclose(many[-1], v * np.abs(v) / 20.0, atol=2e-6)
    assert len(many) < 300
