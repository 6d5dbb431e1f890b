"""The posture farthest from the limits of those that hit nothing, against a dense sweep of all free arm angles."""

import numpy as np
import pytest
from arms import EXACT, generator, load
from scene_sets import made, scene_of

import srs_ik

NAMES = ("iiwa14", "human_arm", *(name for name in ("med7", "openarm_left") if name in EXACT))


def cost(arm, q):
    """Distance from the middle of the joint whose limits are nearest, as a part of half its range; -1 at best."""
    limited = np.isfinite(arm.lower) & np.isfinite(arm.upper)
    middle, half = 0.5 * (arm.lower + arm.upper)[limited], 0.5 * (arm.upper - arm.lower)[limited]
    return float((np.abs(q[..., limited] - middle) / half).max(axis=-1).min()) - 1.0


def away(psi, interval):
    """How far an arm angle is from an interval, rad."""
    if psi in interval:
        return 0.0
    return min(abs(np.remainder(psi - end + np.pi, 2 * np.pi) - np.pi) for end in (interval.lower, interval.upper))


@pytest.mark.parametrize("kind", ["table", "shelf", "cage"])
@pytest.mark.parametrize("name", NAMES)
def test_no_free_posture_is_farther_from_the_limits(name, kind):
    arm, rng = load(name), generator(name + kind, 60)
    try:
        arm.bodies  # noqa: B018
    except srs_ik.NoBodies:
        pytest.skip("no shapes are at hand")
    objects = made(kind, arm, rng)
    scene, real = scene_of(objects), scene_of(objects, exact=True)
    lower = np.where(np.isfinite(arm.lower), arm.lower, -np.pi)
    upper = np.where(np.isfinite(arm.upper), arm.upper, np.pi)
    met = 0
    for _ in range(25):
        T = arm.forward_kinematics(rng.uniform(lower, upper)).homogeneous
        best = arm.solve(T, scene=scene)
        # Where spheres leave nothing, real shapes may.
        free = arm.intervals(T, scene=scene) or arm.intervals(T, scene=real)
        assert bool(best) == bool(free)
        if not best:
            continue
        met += 1
        # At the end of an interval, its arm angle is measured.
        assert any(each.branch == best.branch and away(best.arm_angle, each) < 1e-9 for each in free)
        lowest = np.inf
        for each in free:
            room = min(1e-9, 0.25 * each.width)
            psis = np.linspace(each.lower + room, each.upper - room, 120)
            swept = arm.solve_batch(np.repeat(T[None], len(psis), axis=0), arm_angle=psis, branch=each.branch)
            lowest = min(lowest, cost(arm, swept.q[swept.ok]))
        # Ends of intervals are known to 1e-9 rad, and joints may turn a little faster than the arm.
        assert cost(arm, best.q) <= lowest + 1e-7
    assert met >= 8
