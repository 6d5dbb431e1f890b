"""A tracker's elbow: it stays where nothing pushes it, and goes all the way to where it is asked to be."""

import arms
import numpy as np
import pinocchio as pin
import pytest
from tracked import velocities

import srs_ik
from srs_ik import InvalidTask

DT = 0.002
SLOWER = 0.005

CYCLE = 1571
"""Updates of a cycle of 3.1 s."""

CENTRES = 0.01
"""The elbow of a gen3 is read off the nearest exact limb, whose centres are up to 12 mm elsewhere: in rad."""

SWEEP = 0.1
"""Size of a slow motion of the tip, m."""

STARTS = {
    "iiwa14": ([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2], [-0.6, 0.9, 0.4, 1.3, 0.9, -1.0, 0.2]),
    "gen3": ([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2],),
}
SLOW = [(name, q0, shape) for name in arms.here(*STARTS) for q0 in STARTS[name] for shape in ("line", "circle")]


def swivel(name, q0, q):
    """By how much the elbow has turned about the line from shoulder to wrist, rad, at one pose; by Pinocchio."""
    arm, forward = arms.load(name), arms.forward(name)
    limb = arm.limb
    wrist = forward.carried(q0, 4, limb.wrist)
    t = (wrist - limb.shoulder) / np.linalg.norm(wrist - limb.shoulder)
    before, after = (forward.carried(each, 3, limb.elbow) - limb.shoulder for each in (q0, q))
    before, after = before - t * (t @ before), after - t * (t @ after)
    return float(np.arctan2(t @ np.cross(before, after), before @ after))


@pytest.mark.parametrize(("name", "q0", "shape"), SLOW)
def test_the_elbow_does_not_wander_as_a_slow_target_comes_again_and_again(name, q0, shape):
    arm, forward = arms.load(name), arms.forward(name)
    T = forward(np.array(q0)).homogeneous
    tracker = arm.tracker(q0, DT, velocities(arm))
    ends = [np.array(q0)]
    for k in range(1, 20 * CYCLE + 1):
        angle, pose = 2.0 * np.pi * k / CYCLE, T.copy()
        pose[1, 3] += SWEEP * np.sin(angle)
        if shape == "circle":
            pose[2, 3] += SWEEP * (np.cos(angle) - 1.0)
        step = tracker.update(pose)
        if k % CYCLE == 0:
            ends.append(step.q)
            assert step
    # The first cycles bring it to where it stays.
    turned = np.array([swivel(name, q0, q) for q in ends])
    assert np.abs(np.diff(turned[-3:])).max() < 3e-3
    assert np.ptp(turned[14:]) < 0.02


SHAKEN = (1e-3, np.radians(0.5))
"""Standard deviations of jitter, m along an axis and rad about one."""


@pytest.mark.parametrize("name", arms.here("iiwa14", "gen3"))
def test_the_elbow_stays_where_jitter_shakes_a_target_at_rest(name):
    q0, seconds = STARTS["iiwa14"][0], 20
    T, rng = arms.forward(name)(np.array(q0)).homogeneous, np.random.default_rng(2)
    tracker = arms.load(name).tracker(q0, DT, velocities(arms.load(name)))
    q = np.empty((round(seconds / DT), 7))
    for k in range(len(q)):
        pose = T.copy()
        pose[:3, 3] += rng.normal(0.0, SHAKEN[0], 3)
        pose[:3, :3] = pose[:3, :3] @ pin.exp3(rng.normal(0.0, SHAKEN[1], 3))
        q[k] = tracker.update(pose).q
    means = q.reshape(seconds, -1, 7).mean(axis=1)
    # Where plans take noise for a motion, it turns by 0.5 rad and more.
    assert max(abs(swivel(name, q0, each)) for each in means) < 0.2


ASKED = (
    # Another joint comes close to its limit on the way.
    (
        "gen3",
        [1.03091903, 0.37435578, 0.36976043, -0.36577335, 1.7175027, 1.82844125, -2.53741171],
        1.319,
    ),
    (
        "human_arm",
        [1.44536036, 0.78951162, -1.05056503, -0.60874728, -0.2739082, -0.96018014, 0.46456863],
        -0.4406,
    ),
    # The shorter way round is shut.
    (
        "gen3",
        [-0.52671699, -0.54430058, 2.04437727, -2.27333755, 2.27861417, -1.63880912, -2.26800251],
        2.258,
    ),
)


@pytest.mark.parametrize(("name", "q0", "wanted"), [case for case in ASKED if case[0] in arms.here(case[0])])
def test_at_rest_the_elbow_comes_to_an_arm_angle_to_which_a_way_is_open(name, q0, wanted):
    arm, q0 = arms.load(name), np.array(q0)
    T = arms.forward(name)(q0).homogeneous
    tracker = arm.tracker(q0, SLOWER, velocities(arm), elbow=wanted)
    steps = [tracker.update(T) for _ in range(4000)]
    assert all(steps[-100:])
    away = swivel(name, q0, steps[-1].q) - (wanted - arm.arm_angle(q0))
    assert abs(np.remainder(away + np.pi, 2.0 * np.pi) - np.pi) < CENTRES


def climbed(name, q, T, side, value):
    """How far a value rises on the way of the elbow to a side, in small steps on the pose, by Pinocchio."""
    arm, forward = arms.load(name), arms.forward(name)
    best = first = value(q)
    before = None
    for _ in range(2000):
        J = arm.jacobian(q)
        null = np.linalg.svd(J)[2][-1]
        null *= side if before is None else np.sign(null @ before)
        before = null
        q = q + 2e-3 * null
        for _ in range(2):
            here = forward(q).homogeneous
            skew = 0.5 * (T[:3, :3] @ here[:3, :3].T - here[:3, :3] @ T[:3, :3].T)
            q = q + np.linalg.pinv(arm.jacobian(q)) @ np.r_[T[:3, 3] - here[:3, 3], skew[2, 1], skew[0, 2], skew[1, 0]]
        now = value(q)
        if now < best:
            break
        best = now
    return best - first


UPHILL = (("iiwa14", [0.02537052, 0.21064383, 2.76393640, 1.15234542, 0.68152457, 1.92526239, -1.63473539]),)


@pytest.mark.parametrize(("name", "q0"), [case for case in UPHILL if case[0] in arms.here(case[0])])
def test_at_rest_the_elbow_goes_on_as_long_as_a_small_step_gains(name, q0):
    arm = arms.load(name)
    q0 = np.array(q0)
    T = arms.forward(name)(q0).homogeneous
    tracker = arm.tracker(q0, SLOWER, velocities(arm), elbow="limit_margin")
    steps = [tracker.update(T) for _ in range(4000)]
    assert all(steps[-100:])

    def margin(q):
        return (np.minimum(q - arm.lower, arm.upper - q) / (0.5 * (arm.upper - arm.lower))).min()

    assert max(climbed(name, steps[-1].q, T, side, margin) for side in (1.0, -1.0)) < 0.01


def test_a_misspelt_policy_is_told_with_all_there_are():
    with pytest.raises(
        InvalidTask, match=r'^elbow must be "keep", an arm angle.*, not \'Keep\' \(did you mean \'keep\'\?\)$'
    ):
        srs_ik.load("iiwa14").tracker(np.full(7, 0.3), 0.004, elbow="Keep")
