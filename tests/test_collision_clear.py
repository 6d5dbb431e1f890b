"""Where the best posture within the limits is clear of everything, it is the best in the scene; and largest clearances.

What is clear is told by Pinocchio, the clearance of spheres by NumPy, and the best by sweeps of all arm angles.
"""

import coal
import numpy as np
import pytest
from arms import generator
from collision_oracle import Truth, clearance, file_of_and

import srs_ik

CLEAR = 0.06
"""Bodies farther apart than this, m, are clear by the spheres, too."""

AXIS = (0.0, 0.0, 1.0)


@pytest.fixture(scope="module")
def near():
    arm = srs_ik.load("gen3")
    return arm, Truth(*file_of_and(arm))


def costs(arm, q, seed):
    """Distance from a seed, or minus the margin to the limits as a part of half a range."""
    if seed is not None:
        return float(np.linalg.norm(q - seed))
    limited = np.isfinite(arm.lower) & np.isfinite(arm.upper)
    lower, upper = arm.lower[limited], arm.upper[limited]
    middle, half = 0.5 * (lower + upper), 0.5 * (upper - lower)
    return float((np.abs(q[limited] - middle) / half).max()) - 1.0


def postures(arm, count, salt, joint=None):
    """Random postures, with a seed each; a joint of them is next to zero."""
    rng = generator(arm.name, salt)
    lower, upper = np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi)
    for _ in range(count):
        q = rng.uniform(lower, upper)
        if joint is not None:
            q[joint] = 0.02 * rng.normal()
        yield q, np.clip(q + 0.4 * rng.normal(size=7), lower, upper)


@pytest.mark.parametrize("exact", [False, True])
def test_the_nearest_posture_is_the_nearest_in_a_scene_that_it_is_clear_of(near, exact):
    arm, truth = near
    T = arm.forward_kinematics([1.9, 2.05, -2.6, -2.2, 1.63, -0.018, -0.47])
    seed = np.array([1.86, 2.1, -2.19, -2.57, 1.93, 0.27, 0.7])
    known = arm.solve(T, seed=seed).q
    assert truth.deepest(known)[0] < -CLEAR
    assert T.actInv(arm.forward_kinematics(known)).isIdentity(1e-9)
    found = arm.solve(T, seed=seed, scene=srs_ik.Scene(exact=exact))
    assert costs(arm, found.q, seed) <= costs(arm, known, seed) + 1e-9


@pytest.mark.parametrize("joint", [None, 3, 5])
def test_a_scene_that_is_far_away_changes_no_answer(near, joint):
    arm, truth = near
    scene, looked = srs_ik.Scene(), 0
    for q, seed in postures(arm, 40, 80, joint):
        T = arm.forward_kinematics(q)
        asked = ({}, {"seed": seed}, {"seed": seed, "branch": arm.branch(q)}, {"arm_angle": arm.arm_angle(q)})
        for question in (*asked, {"elbow": arm.arm_angle(q) + 0.3}):
            known = arm.solve(T, **question)
            if known and truth.deepest(known.q)[0] < -CLEAR:
                looked += 1
                found = arm.solve(T, scene=scene, **question)
                near_seed = question.get("seed")
                assert costs(arm, found.q, near_seed) <= costs(arm, known.q, near_seed) + 1e-9
                assert arm.solve_batch([T], scene=scene, **question)[0].q == pytest.approx(found.q, abs=1e-9)
    assert looked > 100


@pytest.mark.parametrize("name", ["gen3", "iiwa14"])
def test_an_optimum_that_is_clear_is_that_of_the_scene(name):
    arm, looked = srs_ik.load(name), 0
    truth = Truth(*file_of_and(arm))
    for q, seed in postures(arm, 12, 81, 3):
        T = arm.forward_kinematics(q)
        for objective, given in (("manipulability", {}), ("reference_posture", {"reference": seed})):
            known = arm.optimise(T, objective, **given)
            if truth.deepest(known.q)[0] < -CLEAR:
                looked += 1
                found = arm.optimise(T, objective, scene=srs_ik.Scene(), **given)
                sign = 1.0 if objective == "manipulability" else -1.0
                assert sign * found.value >= sign * known.value - 1e-9
                assert found.arm_angle in found.interval
    assert looked > 12


def test_a_free_turn_is_looked_at_by_real_shapes_where_these_count():
    arm, looked = srs_ik.load("iiwa14"), 0
    for q, seed in postures(arm, 12, 82):
        T = arm.forward_kinematics(q)
        known = arm.solve(T, seed=seed, free_axis=AXIS)
        elbow = arm.joint_frames(known.q)[4]
        for away in np.linspace(0.13, 0.19, 7):
            truth, scene, place = Truth(*file_of_and(arm)), srs_ik.Scene(exact=True), np.eye(4)
            place[:3, 3] = elbow[:3, 3] + away * elbow[:3, 2]
            scene.add_sphere("ball", place[:3, 3], 0.05)
            truth.add("ball", place, coal.Sphere(0.05))
            # Spheres meet there, real shapes do not.
            if clearance(arm, arm.tables(scene), known.q) < 0.0 and truth.deepest(known.q)[0] < -1e-3:
                looked += 1
                found = arm.solve(T, seed=seed, free_axis=AXIS, scene=scene)
                assert found.q == pytest.approx(known.q, abs=1e-9)
                break
    assert looked > 4


def bounded(arm, tables, q):
    """Clearance of spheres, and the bounds of pairs that are watched by ranges of joints."""
    kept = {frozenset((pair.first, pair.second)) for pair in arm.pairs if pair.kept}
    bounds = [
        each.bounds[min(np.searchsorted(each.edges, q[each.joint], side="right") - 1, len(each.bounds) - 1)]
        for each in tables.ranges
        if frozenset((tables.names[each.first], tables.names[each.second])) in kept
    ]
    return min([clearance(arm, tables, q), *bounds])


@pytest.mark.parametrize("name", ["human_arm", "gen3"])
def test_the_largest_clearance_is_that_of_all_watched_pairs_on_the_true_chain(name):
    arm, scene, looked = srs_ik.load(name), srs_ik.Scene(), 0
    scene.add_box("box", srs_ik.pose_from_xyz_rpy([0.45, 0.2, 0.5], [0, 0, 0]), [0.1, 0.15, 0.3])
    truth, tables = Truth(*file_of_and(arm)), arm.tables(scene)
    for q, _ in postures(arm, 12, 83):
        T = arm.forward_kinematics(q)
        best = arm.optimise(T, "clearance", scene=scene)
        if not best:
            continue
        looked += 1
        assert best.value == pytest.approx(bounded(arm, tables, best.q), abs=1e-9)
        # coal's own tolerance
        assert best.value <= -truth.deepest(best.q)[0] + 1e-6
        for each in arm.intervals(T, scene=scene):
            for psi in np.linspace(each.lower, each.upper, 25)[1:-1]:
                swept = arm.solve(T, arm_angle=float(psi), branch=each.branch)
                assert not swept or bounded(arm, tables, swept.q) <= best.value + 1e-5
    assert looked > 6


def test_the_clearance_of_an_elbow_almost_straight_counts_what_the_elbow_watches():
    arm, scene = srs_ik.load("human_arm"), srs_ik.Scene()
    T = arm.forward_kinematics([0.0, 0.5, 0.4, -0.3, 0.7, -0.8, 0.1])
    best = arm.optimise(T, "clearance", scene=scene)
    depth, pair = Truth(*file_of_and(arm)).deepest(best.q)
    assert set(pair) == {"upper_arm_link", "forearm_roll_link"}
    # Bounds are up to 5 % below the distance.
    assert 0.95 * -depth <= best.value <= -depth
    assert arm.solve(T, scene=scene, margin=best.value - 1e-6)
