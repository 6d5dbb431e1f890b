"""What given joint angles hit, and the lines between them: told by Pinocchio on the robot's own file."""

import json

import coal
import numpy as np
import pinocchio as pin
import pytest
from arms import generator
from collision_oracle import Truth, file_of_and
from command_line import Q, answer, run

import srs_ik

MARGIN = 0.005
TOUCH = 1e-4
"""Bodies that miss the margin by less than this, m, are told apart by nobody."""


def among_objects(name):
    """An arm, a scene, and the truth about them."""
    arm = srs_ik.load(name)
    scene, truth = srs_ik.Scene(), Truth(*file_of_and(arm))
    T = srs_ik.pose_from_xyz_rpy([0.4, 0.1, 0.3], [0.1, 0.2, 0.3])
    scene.add_box("box", T, [0.2, 0.3, 0.2])
    truth.add("box", T.homogeneous, coal.Box(0.2, 0.3, 0.2))
    return arm, scene, truth


def random_postures(arm, count, salt, beyond=0.0):
    rng = generator(arm.name, salt)
    return rng.uniform(np.maximum(arm.lower, -np.pi) - beyond, np.minimum(arm.upper, np.pi) + beyond, (count, 7))


def watch_those_that_never_meet(truth, arm):
    """Add pairs to the truth that never meet inside the joint limits; how many."""
    never = {frozenset((pair.first, pair.second)) for pair in arm.pairs if pair.reason == "never meet (proved)"}
    count = len(truth.shapes.collisionPairs)
    for i, first in enumerate(truth.owner):
        for j in range(i + 1, len(truth.owner)):
            if frozenset((first, truth.owner[j])) in never:
                truth.shapes.addCollisionPair(pin.CollisionPair(i, j))
    truth._data()
    return len(truth.shapes.collisionPairs) - count


@pytest.mark.parametrize("name", ["iiwa14", "gen3", "human_arm"])
def test_a_cloud_is_hit_where_spheres_are_at_its_points(name):
    """By the real shapes, too: links that spin about their own axis are no solids of revolution at a posture."""
    arm = srs_ik.load(name)
    rng = generator(name, 9150)
    margins, hits, lines = [0.0, 0.03], 0, 0
    for k, q in enumerate(random_postures(arm, 60, 9151)):
        points = rng.uniform(-0.05, 0.05, (50, 3)) + arm.forward_kinematics(q).translation + rng.normal(0.0, 0.12, 3)
        cloud, spheres = srs_ik.Scene(), srs_ik.Scene()
        cloud.add_points("points", points, 0.01)
        for i, point in enumerate(points):
            spheres.add_sphere(f"point {i}", point, 0.01)
        found, expected = (arm.collision(q, scene, margins[k % 2]) for scene in (cloud, spheres))
        assert (found is None) == (expected is None)
        # How deep bodies are in each other is coal's to say, which may take another way out than the shortest.
        if found is not None and expected.depth < margins[k % 2]:
            named = {expected.first, "points" if expected.second.startswith("point ") else expected.second}
            assert {found.first, found.second} == named
            assert found.depth == pytest.approx(expected.depth, abs=1e-6)
        hits += found is not None
        line = [q, np.clip(q + rng.normal(0.0, 0.05, 7), arm.lower, arm.upper)]
        on_line, on_line_expected = (arm.path_collisions(line, scene) for scene in (cloud, spheres))
        assert len(on_line) == len(on_line_expected)
        lines += len(on_line)
    assert 10 < hits < 50
    assert 10 < lines < 50


@pytest.mark.parametrize(("offset", "depth"), [((0.05, 0.0, 0.048), 0.012), ((0.0, 0.145, 0.01), 0.015)])
def test_a_sphere_in_a_cylinder_is_as_deep_as_the_shortest_way_out(offset, depth):
    q = [0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2]
    arm = srs_ik.load("iiwa14").with_bodies(spheres={"iiwa_link_7": [[0.0, 0.0, 0.0, 0.01]]})
    T = srs_ik.pose_from_xyz_rpy([0.0, 0.0, 0.0], [0.4, 0.3, 0.2])
    T.translation = arm.joint_frames(q)[7, :3, 3] - T.rotation @ offset
    scene = srs_ik.Scene()
    scene.add_cylinder("cylinder", T, 0.15, 0.1)
    assert arm.collision(q, scene).depth == pytest.approx(depth, abs=1e-6)


@pytest.mark.parametrize("name", ["iiwa14", "gen3", "human_arm"])
@pytest.mark.parametrize(("margin", "beyond"), [(0.0, 0.0), (0.03, 0.0), (0.0, 0.25)])
def test_collisions_of_postures_are_those_that_pinocchio_tells(name, margin, beyond):
    arm, scene, truth = among_objects(name)
    if margin > 0.0 or beyond > 0.0:
        # Within a margin, and outside the limits, they may.
        watch_those_that_never_meet(truth, arm)
    hits = 0
    for q in random_postures(arm, 150, 9100, beyond):
        deepest, pair = truth.deepest(q)
        missing = deepest + margin
        if abs(missing) < TOUCH:
            continue
        found = arm.collision(q, scene, margin)
        assert (found is not None) == (missing > 0.0)
        if found is not None:
            hits += 1
            assert {found.first, found.second} == set(pair)
            assert found.depth == pytest.approx(missing, abs=1e-5)
            assert arm.path_collisions([q], scene, margin)
    assert hits > 10


@pytest.mark.parametrize("name", ["iiwa14", "gen3"])
def test_lines_that_are_free_by_report_hit_nothing(name):
    arm, scene, truth = among_objects(name)
    Q = random_postures(arm, 40, 9101)
    found = {each.sample: each for each in arm.path_collisions(Q, scene, MARGIN)}
    assert sorted(found) == [each.sample for each in arm.path_collisions(Q, scene, MARGIN)]
    for k in range(len(Q) - 1):
        along = Q[k] + np.linspace(0.0, 1.0, 33)[:, None] * (Q[k + 1] - Q[k])
        if k not in found:
            assert max(truth.deepest(q)[0] for q in along) <= -MARGIN + TOUCH
            continue
        there = Q[k] + found[k].at * (Q[k + 1] - Q[k])
        assert truth.deepest(there)[0] > -MARGIN - 0.01
    assert 5 < len(found) < len(Q) - 1


def test_answers_in_a_scene_are_free_by_the_same_word():
    arm, scene, _ = among_objects("iiwa14")
    for q in random_postures(arm, 60, 9102):
        answer = arm.solve(arm.forward_kinematics(q), scene=scene, margin=MARGIN)
        if answer:
            assert arm.collision(answer.q, scene, MARGIN) is None
        elif answer.status == srs_ik.Status.COLLISION:
            assert arm.collision(answer.q, scene, MARGIN) == answer.collision


def test_one_posture_is_a_path():
    arm, scene, truth = among_objects("iiwa14")
    for q in random_postures(arm, 40, 9103):
        deepest, _ = truth.deepest(q)
        if abs(deepest) > TOUCH:
            assert bool(arm.path_collisions([q], scene)) == (deepest > 0.0)
    assert arm.path_collisions(np.empty((0, 7)), scene) == []


def test_outside_the_limits_bodies_meet_that_never_do_inside():
    arm = srs_ik.load("iiwa14")
    truth = Truth(*file_of_and(arm))
    truth.shapes.removeAllCollisionPairs()
    assert watch_those_that_never_meet(truth, arm) > 0
    deep = [q for q in random_postures(arm, 400, 9104, beyond=0.25) if truth.deepest(q)[0] > TOUCH]
    assert len(deep) > 5
    assert all(arm.collision(q, srs_ik.Scene()) for q in deep)
    inside = random_postures(arm, 400, 9105)
    assert max(truth.deepest(q)[0] for q in inside) <= 0.0


@pytest.mark.parametrize("q", [[0.0] * 6, [np.nan] * 7, "angles"])
def test_what_is_no_posture_is_refused(q):
    arm = srs_ik.load("iiwa14")
    with pytest.raises(srs_ik.InvalidConfiguration):
        arm.collision(q, srs_ik.Scene())
    with pytest.raises(srs_ik.InvalidConfiguration):
        arm.path_collisions(q, srs_ik.Scene())
    with pytest.raises(srs_ik.InvalidScene, match=r"srs_ik\.Scene"):
        arm.collision([0.0] * 7, None)


@pytest.fixture
def files(tmp_path):
    scene = tmp_path / "scene.json"
    scene.write_text(json.dumps({"objects": [{"name": "lamp", "sphere": 0.2, "xyz": [0.6, 0.0, 0.4]}]}))
    joints = tmp_path / "joints.csv"
    joints.write_text("q1,q2,q3,q4,q5,q6,q7\n-1.5,1.2,0,-1,0,0.9,0\n1.5,1.2,0,-1,0,0.9,0\n")
    return str(scene), str(joints)


def test_the_command_line_tells_what_meets(files):
    scene, joints = files
    assert answer("collisions", "iiwa14", "--file", joints, "--scene", scene)["collisions"] == []
    found = answer("collisions", "iiwa14", "--file", joints, "--scene", scene, "--path", exit_code=1)["collisions"]
    assert len(found) == 1
    assert found[0]["posture"] == 1
    assert found[0]["second"] == "lamp"
    told = run("collisions", "iiwa14", "--file", joints, "--scene", scene, "--path")
    assert told.exit_code == 1
    assert "lamp" in told.stdout
    assert "bodies meet on the line" in told.stderr
    alone = run("collisions", "iiwa14", "--q", *Q)
    assert alone.exit_code == 0
    assert "1 posture, nothing meets" in alone.stdout


@pytest.mark.parametrize(
    ("words", "named"), [((), "--q"), (("--q", *Q, "--path"), "--path"), (("--q", *Q, "--margin", "x"), "--margin")]
)
def test_wrong_words_are_named(words, named):
    result = run("collisions", "iiwa14", *words)
    assert result.exit_code == 2
    assert named in result.stderr
