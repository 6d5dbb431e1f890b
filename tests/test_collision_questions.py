"""Questions in scenes: batches in kernels, margins of ranges, objectives one after another, near arms, made scenes."""

import numpy as np
import pinocchio as pin
import pytest
from arms import generator
from collision_oracle import Truth, clearance, file_of, with_a_thick_neck
from scene_sets import KINDS, made, scene_of

import srs_ik
from srs_ik.solve.in_scene.surroundings import Surroundings

Q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])


@pytest.fixture(scope="module")
def arm():
    return srs_ik.load("iiwa14")


def random_poses(arm, count, salt=0):
    rng = generator(arm.name, salt)
    lower = np.where(np.isfinite(arm.lower), arm.lower, -np.pi)
    upper = np.where(np.isfinite(arm.upper), arm.upper, np.pi)
    return np.array([arm.forward_kinematics(rng.uniform(lower, upper)).homogeneous for _ in range(count)])


@pytest.mark.parametrize("seeded", [False, True])
def test_a_batch_gives_what_single_calls_give(arm, seeded):
    scene = scene_of(made("shelf", arm, generator("iiwa14", 1)))
    poses = random_poses(arm, 40)
    poses[7, :3, 3] *= 5.0
    seeds = generator("iiwa14", 2).uniform(-1.0, 1.0, (40, 7)) if seeded else None
    for threads in (1, 2):
        many = arm.solve_batch(poses, seed=seeds, threads=threads, scene=scene, margin=0.01)
        for i, T in enumerate(poses):
            one = arm.solve(T, seed=None if seeds is None else seeds[i], scene=scene, margin=0.01)
            assert many.status[i] == one.status
            assert np.abs(many.q[i] - one.q).max() < 1e-9
            assert many[i].collision == one.collision
    assert set(many.status) >= {srs_ik.Status.OK, srs_ik.Status.UNREACHABLE}


def test_intervals_of_a_batch(arm):
    scene = scene_of(made("table", arm, generator("iiwa14", 3)))
    poses = random_poses(arm, 30, 1)
    many = arm.intervals_batch(poses, scene=scene, margin=0.01)
    assert [list(each) for each in many] == [list(arm.intervals(T, scene=scene, margin=0.01)) for T in poses]
    with pytest.raises(srs_ik.InvalidPose, match="3"):
        arm.intervals_batch([*poses[:3], np.full((4, 4), np.nan)], scene=scene)


@pytest.mark.parametrize("kind", ["shelf", "box"])
def test_no_question_finds_nothing_free_where_another_one_does(arm, kind):
    """Where spheres leave no arm angle, real shapes tell of all of them."""
    scene, real = (scene_of(made(kind, arm, generator("iiwa14", 5)), exact=exact) for exact in (False, True))
    poses = random_poses(arm, 120, 6)
    many, alone = arm.intervals_batch(poses, scene=scene), 0
    solved = arm.solve_batch(poses, scene=scene)
    for i, T in enumerate(poses):
        free, every = arm.intervals(T, scene=scene), arm.solve_all(T, scene=scene)
        assert list(many[i]) == list(free)
        assert bool(free) == bool(every) == bool(solved.ok[i])
        if solved.ok[i] and not left_by_spheres(arm, scene, T):
            alone += 1
            assert list(free) == list(arm.intervals(T, scene=real))
            assert any(each.branch == solved.branch[i] for each in free)
    assert alone


def left_by_spheres(arm, scene, T):
    """Whether the spheres leave some arm angle."""
    return len(Surroundings(arm, arm.packed, scene, 0.0).all_free(T, True))


def test_the_margin_counts_for_ranges_of_joints(tmp_path):
    arm = with_a_thick_neck(tmp_path)
    T = arm.forward_kinematics(Q)
    largest = []
    for margin in (0.0, 0.01, 0.03):
        q6 = 0.0
        for each in arm.intervals(T, scene=srs_ik.Scene(), margin=margin):
            for psi in np.linspace(each.lower + 1e-9, each.upper - 1e-9, 40):
                q6 = max(q6, abs(arm.solve(T, arm_angle=psi, branch=each.branch).q[5]))
        largest.append(q6)
    assert largest[0] > largest[1] + 0.1 > largest[2] + 0.2


def test_one_objective_after_another(arm):
    T = arm.forward_kinematics(Q)
    scene = srs_ik.Scene()
    scene.add_sphere("ball", arm.joint_frames(Q)[4, :3, 3], 0.07)
    given = {"force": [0, 0, 1], "velocity": [1, 0, 0], "tolerance": 0.2}
    best = arm.optimise(T, "force_then_velocity", scene=scene, **given)
    assert best
    objective = srs_ik.Objective("force_then_velocity", **given)
    values = []
    for each in arm.intervals(T, scene=scene):
        for psi in np.linspace(each.lower + 1e-9, each.upper - 1e-9, 150):
            values.append(objective.values(arm, arm.solve(T, arm_angle=psi, branch=each.branch).q))
    first, second = np.array(values).T
    assert best.value <= 1.2 * first.min() + 1e-9
    assert best.second_value >= second[first <= 1.2 * first.min()].max() * (1.0 - 1e-3)
    assert clearance(arm, arm.tables(scene), best.q) >= -1e-9


def test_real_shapes_say_what_is_undecided(arm):
    T = arm.forward_kinematics(Q)
    assert arm.intervals(T, scene=srs_ik.Scene()).undecided == 0.0
    found = arm.intervals(T, scene=srs_ik.Scene(exact=True))
    assert 0.0 <= found.undecided < 0.05 * sum(each.width for each in found)


@pytest.mark.slow
def test_a_near_arm_is_followed_on_its_true_chain():
    arm = srs_ik.load("gen3")
    scene = scene_of(made("cage", arm, generator("gen3", 4)))
    rng = generator("gen3", 5)
    looked = 0
    for T in random_poses(arm, 4, 6):
        for each in arm.intervals(T, scene=scene, margin=0.01):
            for psi in rng.uniform(each.lower, each.upper, 12):
                answer = arm.solve(T, arm_angle=psi, branch=each.branch)
                if answer:
                    looked += 1
                    assert clearance(arm, arm.tables(scene), answer.q) >= 0.01 - 1e-6
    assert looked > 20


@pytest.mark.parametrize("kind", KINDS)
def test_scenes_of_a_script_have_answers_and_refusals(arm, kind):
    scene = scene_of(made(kind, arm, generator("iiwa14", 7)))
    status = arm.solve_batch(random_poses(arm, 60, 8), scene=scene).status
    assert (status == srs_ik.Status.OK).mean() > 0.3
    assert set(status) <= {srs_ik.Status.OK, srs_ik.Status.COLLISION, srs_ik.Status.UNREACHABLE}


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize(("name", "margin"), [("iiwa14", 0.05), ("human_arm", 0.03)])
def test_the_margin_counts_for_every_pair_that_is_not_adjacent(name, margin, exact):
    arm = srs_ik.load(name)
    truth = Truth(file_of(arm)[0], arm)
    watched = {frozenset((p.first, p.second)) for p in arm.pairs if p.kept or "never" in p.reason}
    assert any("never" in p.reason for p in arm.pairs)
    truth.shapes.removeAllCollisionPairs()
    for i, first in enumerate(truth.owner):
        for j, second in enumerate(truth.owner[:i]):
            if frozenset((first, second)) in watched:
                truth.shapes.addCollisionPair(pin.CollisionPair(j, i))
    data = pin.GeometryData(truth.shapes)
    scene, rng, looked, least = srs_ik.Scene(exact=exact), generator(name, 41), 0, np.inf
    for T in random_poses(arm, 12 if exact else 40, 42):
        for each in arm.intervals(T, scene=scene, margin=margin):
            for psi in rng.uniform(each.lower, each.upper, 3):
                q = arm.solve(T, arm_angle=psi, branch=each.branch).q
                whole = arm.configuration(q, truth.model)
                pin.updateGeometryPlacements(truth.model, truth.data, truth.shapes, data, whole)
                k = pin.computeDistances(truth.shapes, data)
                looked, least = looked + 1, min(least, data.distanceResults[k].min_distance)
    assert looked > 20
    # coal's own tolerance, and that of ends of intervals.
    assert margin - 1e-5 <= least < 2.0 * margin


def placed(place):
    T = np.eye(4)
    T[:3, 3] = place
    return T


def test_a_scene_that_has_changed_is_looked_at_anew(tmp_path):
    """What answers in a scene is kept for the next question: moves, objects, margins and the kind of shapes count."""
    arm = with_a_thick_neck(tmp_path)
    rng = generator("iiwa14", 71)
    T = arm.forward_kinematics(rng.uniform(arm.lower, arm.upper)).homogeneous
    scene = srs_ik.Scene()
    plain = arm.intervals(T, scene=scene)
    assert arm.intervals(T, scene=scene) == plain
    scene.add_sphere("ball", T[:3, 3] + [0.0, 0.0, 5.0], 0.3)
    assert arm.intervals(T, scene=scene) == plain
    scene.move("ball", placed(arm.limb.shoulder))
    assert arm.intervals(T, scene=scene) == []
    scene.move("ball", placed([0.0, 0.0, 5.0]))
    assert arm.intervals(T, scene=scene) == plain
    wide = sum(each.width for each in plain)
    assert sum(each.width for each in arm.intervals(T, scene=scene, margin=0.03)) < wide
    scene.margin = 0.03
    by_spheres = arm.intervals(T, scene=scene)
    assert sum(each.width for each in by_spheres) < wide
    scene.exact = True
    assert sum(each.width for each in arm.intervals(T, scene=scene)) > sum(each.width for each in by_spheres)
    scene.margin, scene.exact = 0.0, False
    assert arm.intervals(T, scene=srs_ik.Scene()) == plain == arm.intervals(T, scene=scene)
    assert arm.with_object("box", np.eye(4), [0.3, 0.3, 0.3]).intervals(T, scene=scene) != plain


def test_the_clearance_of_an_answer_is_a_function_of_any_posture(arm):
    T, scene = arm.forward_kinematics(Q), srs_ik.Scene()
    scene.add_sphere("ball", [0.6, 0.2, 0.8], 0.1)
    best = arm.optimise(T, "clearance", scene=scene)
    assert (best.objective.name, best.objective.unit) == ("clearance", "m")
    for q in (best.q, Q, np.array([-0.5, 0.4, 0.9, -1.6, 0.2, 0.5, 1.0])):
        assert best.objective.value(arm, q) == pytest.approx(clearance(arm, arm.tables(scene), q), abs=1e-9)


def test_where_no_posture_keeps_clear_the_largest_clearance_names_the_bodies(arm):
    T, scene = arm.forward_kinematics(Q), srs_ik.Scene()
    scene.add_sphere("ball", T.translation, 0.1)
    best = arm.optimise(T, "clearance", scene=scene)
    assert best.status is srs_ik.Status.COLLISION
    assert best.collision == arm.solve(T, scene=scene).collision
    assert "ball" in best.message
    assert best.value < 0.0
