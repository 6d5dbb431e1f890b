"""`SrsLimb`: the lengths and centres of arms whose figures are published."""

import dataclasses

import arms
import numpy as np
import pytest
from oracles import x_along

from srs_ik.robot.limb import EXACT_MISS, line_distance


def test_lengths_of_the_iiwa():
    limb = arms.load("iiwa14").limb
    assert limb.upper_arm == pytest.approx(0.42, abs=1e-12)
    assert limb.forearm == pytest.approx(0.40, abs=1e-12)
    assert limb.hand == pytest.approx(0.126, abs=1e-12)
    assert limb.elbow_offset == pytest.approx(0.0, abs=1e-12)
    assert limb.shoulder == pytest.approx([0.0, 0.0, 0.36], abs=1e-12)
    assert limb.elbow == pytest.approx([0.0, 0.0, 0.78], abs=1e-12)
    assert limb.wrist == pytest.approx([0.0, 0.0, 1.18], abs=1e-12)
    assert limb.reference == pytest.approx([0.0, 0.0, 1.0])
    assert limb.wrist_kind == "XYX"
    assert limb.kind == "exact"


def test_lengths_of_the_human_arm():
    limb = arms.load("human_arm").limb
    lengths = (limb.upper_arm, limb.forearm, limb.hand)
    assert lengths == pytest.approx((0.37, 0.32, 0.10), abs=1e-12)
    assert limb.wrist_kind == "XYZ"


@pytest.mark.parametrize("name", arms.here("sia5d"))
def test_offset_of_an_elbow(name):
    assert arms.load(name).limb.elbow_offset == pytest.approx(0.085 if name == "sia5d" else 0.08, abs=1e-9)


def test_misses_of_the_gen3():
    """Neighbouring axes meet, but 11.7508 and 0.3505 mm apart along axes 2 and 6: half of it is left at the centre."""
    limb = arms.load("gen3").limb
    assert limb.kind == "near"
    assert limb.misses.max() == pytest.approx(0.0117508 / 2.0, abs=1e-6)
    assert limb.misses[3] == 0.0


@pytest.mark.parametrize("name", arms.EVERY)
def test_figures_of_every_limb(name):
    arm = arms.load(name)
    limb = arm.limb
    assert limb.kind == ("near" if name in arms.NEAR else "exact")
    assert (limb.kind == "exact") == (limb.misses.max() < EXACT_MISS)
    assert np.linalg.norm(limb.axes, axis=1) == pytest.approx(np.ones(7), abs=1e-12)
    assert np.linalg.norm(limb.reference) == pytest.approx(1.0)
    for k, centre in zip((0, 1, 2, 4, 5, 6), [limb.shoulder] * 3 + [limb.wrist] * 3, strict=True):
        along = limb.axes[k]
        assert limb.offsets[k] == pytest.approx(np.linalg.norm(np.cross(along, centre - limb.points[k])), abs=1e-9)
    assert np.linalg.norm(np.cross(limb.axes[3], limb.elbow - limb.points[3])) < 1e-9
    assert limb.T_base_tip_zero == pytest.approx(arm.forward_kinematics(np.zeros(7)).homogeneous, abs=1e-12)


@pytest.mark.parametrize("name", arms.EVERY)
def test_axes_are_those_of_the_whole_robot(name):
    """Turning a joint leaves the points of its axis where they are, and turns others right-handed about it."""
    arm, forward = arms.load(name), arms.forward(name)
    for k in range(7):
        axis, point = arm.limb.axes[k], arm.limb.points[k]
        q = np.zeros(7)
        q[k] = 0.5 * np.pi
        on_axis = point + 0.3 * axis
        assert np.linalg.norm(forward.carried(q, k + 1, on_axis) - on_axis) < 1e-9
        across = x_along(axis)[:, 1]
        assert forward.carried(q, k + 1, point + across) == pytest.approx(point + np.cross(axis, across), abs=1e-9)


@pytest.mark.parametrize("name", arms.EXACT)
def test_centres_stay_where_they_are(name):
    """The shoulder does not move with joints 1 to 3, nor the wrist with joints 5 to 7, nor the elbow with joint 4."""
    arm, forward = arms.load(name), arms.forward(name)
    limb = arm.limb
    for q in arms.configurations(name, 10, 91):
        assert np.linalg.norm(forward.carried(q, 3, limb.shoulder) - limb.shoulder) < 5e-6
        assert np.linalg.norm(forward.carried(q, 7, limb.wrist) - forward.carried(q, 4, limb.wrist)) < 5e-6
        assert np.linalg.norm(forward.carried(q, 4, limb.elbow) - forward.carried(q, 3, limb.elbow)) < 1e-9


def test_distance_of_a_point_from_a_line():
    axis = np.array([0.6, 0.0, 0.8])
    across = np.array([0.8, 0.0, -0.6])
    point = np.array([1.0, 2.0, 3.0])
    for far in (0.0, 1e-12, 0.5, 100.0):
        assert line_distance(point + 7.0 * axis + far * across, point, axis) == pytest.approx(far, abs=1e-14)


def test_a_limb_is_frozen():
    limb = arms.load("iiwa14").limb
    with pytest.raises(dataclasses.FrozenInstanceError):
        limb.shoulder = np.zeros(3)
