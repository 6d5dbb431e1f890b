"""Scenes: what they take and refuse, moving, files and messages, answers in them, and two arms."""

import copy
import json
import pickle
import threading
from types import SimpleNamespace as Message

import numpy as np
import pinocchio as pin
import pytest
import trimesh
from arms import generator
from collision_oracle import Truth, clearance, file_of_and
from robot_files import joint_xml, serial_arm
from scipy.spatial.transform import Rotation

import srs_ik
from srs_ik.errors import InvalidScene

Q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
AT = srs_ik.pose_from_xyz_rpy


@pytest.fixture(scope="module")
def arm():
    return srs_ik.load("iiwa14")


@pytest.fixture(scope="module")
def pose(arm):
    return arm.forward_kinematics(Q).homogeneous


def ends(intervals):
    return np.array([(i.branch, i.lower, i.upper) for i in intervals])


WRONG = [
    lambda s: s.add_sphere("a", [0, 0, np.nan], 0.1),
    lambda s: s.add_sphere("a", [0, 0], 0.1),
    lambda s: s.add_sphere("a", [0, 0, 1], 0.0),
    lambda s: s.add_sphere("a", [0, 0, 1], -0.1),
    lambda s: s.add_sphere("a", [0, 0, 1], np.inf),
    lambda s: s.add_sphere("", [0, 0, 1], 0.1),
    lambda s: s.add_box("a", np.eye(4), [0.1, 0.1, 0.0]),
    lambda s: s.add_box("a", np.eye(3), [0.1, 0.1, 0.1]),
    lambda s: s.add_box("a", np.full((4, 4), np.nan), [0.1, 0.1, 0.1]),
    lambda s: s.add_cylinder("a", np.eye(4), -1.0, 1.0),
    lambda s: s.add_capsule("a", np.eye(4), 1.0, "long"),
    lambda s: s.add_points("a", np.empty((0, 3)), 0.01),
    lambda s: s.add_points("a", [[0, 0, np.nan]], 0.01),
    lambda s: s.add_points("a", [[0, 0, 1]], np.nan),
    lambda s: s.add_points("a", [0, 0, 1], 0.01),
    lambda s: s.add_points("a", np.zeros((2_000_001, 3)), 0.01),
    lambda s: s.add_half_space("a", [0, 0, 0], [0, 0, 0]),
    lambda s: s.add_mesh("a", np.eye(4), "nothing.stl"),
    lambda s: s.add_mesh("a", np.eye(4), "nothing.exe"),
    lambda s: s.add_triangles("a", np.eye(4), [[0, 0, 0]], [[0, 0, 1]]),
    lambda s: s.move("nobody", np.eye(4)),
    lambda s: s.remove("nobody"),
    lambda s: s.add_message(3),
    lambda s: srs_ik.Scene(margin=-1.0),
]


@pytest.mark.parametrize("wrong", WRONG)
def test_what_makes_no_sense_is_refused_in_one_line(wrong):
    scene = srs_ik.Scene()
    with pytest.raises(InvalidScene) as told:
        wrong(scene)
    assert "\n" not in str(told.value)
    assert len(scene) == 0


def test_wrong_questions(arm, pose):
    for wrong in ({"scene": 3}, {"scene": srs_ik.Scene(), "margin": -0.1}, {"scene": srs_ik.Scene(), "margin": np.nan}):
        with pytest.raises(InvalidScene):
            arm.intervals(pose, **wrong)
    scene = srs_ik.Scene()
    scene.add_sphere("a", [0, 0, 1], 0.1)
    with pytest.raises(InvalidScene, match="already"):
        scene.add_sphere("a", [0, 0, 2], 0.1)
    with pytest.raises(InvalidScene, match="did you mean"):
        scene.add_box("apple", np.eye(4), [1, 1, 1]) or scene.remove("aple")


@pytest.mark.parametrize("ask", ["solve", "solve_all", "intervals", "solve_batch", "intervals_batch", "solve_path"])
def test_a_margin_needs_a_scene(arm, pose, ask):
    one = ask in ("solve", "solve_all", "intervals")
    asked = pose if one else np.array([pose, pose])
    for margin in (0.05, 1, -0.1, "wide"):
        with pytest.raises(InvalidScene, match="margin"):
            getattr(arm, ask)(asked, margin=margin)
    with pytest.raises(InvalidScene, match=r"scene=srs_ik.Scene\(\) is the arm alone"):
        getattr(arm, ask)(asked, margin=0.05)
    for nothing in (0.0, 0, np.float64(0.0)):
        getattr(arm, ask)(asked, margin=nothing)


def test_clearance_needs_a_scene(arm, pose):
    for asked in (lambda: arm.optimise(pose, "clearance"), lambda: srs_ik.Objective("clearance")):
        with pytest.raises(srs_ik.InvalidTask, match="'clearance' needs a scene"):
            asked()
    with pytest.raises(InvalidScene, match="goes with scene="):
        arm.optimise(pose, "clearance", margin=0.01)


def test_no_object_has_the_name_of_a_link(arm, pose):
    scene = srs_ik.Scene()
    scene.add_sphere("iiwa_link_3", [0.0, 0.0, 3.0], 0.1)
    for ask in (arm.solve, arm.intervals):
        with pytest.raises(InvalidScene, match="'iiwa_link_3' is a body of the arm"):
            ask(pose, scene=scene)
    scene.remove("iiwa_link_3")
    scene.add_arm("iiwa_link_3", arm, np.zeros(7), srs_ik.pose_from_xyz_rpy([3.0, 0.0, 0.0], [0.0, 0.0, 0.0]))
    assert arm.solve(pose, scene=scene)


def test_an_object_around_the_whole_arm_leaves_nothing(arm, pose):
    for add in (
        lambda s: s.add_sphere("world", [0, 0, 0.5], 3.0),
        lambda s: s.add_box("world", np.eye(4), [5, 5, 5]),
        lambda s: s.add_half_space("world", [0, 0, 5], [0, 0, 1]),
    ):
        scene = srs_ik.Scene()
        add(scene)
        assert arm.intervals(pose, scene=scene) == []
        answer = arm.solve(pose, scene=scene)
        assert answer.status == "COLLISION"
        assert not answer
        assert "world" in answer.collision[:2]
        assert "world" in answer.message
        assert np.isfinite(answer.q).all()
        assert len(arm.solve_all(pose, scene=scene)) == 0
        assert arm.optimise(pose, "clearance", scene=scene).status == "COLLISION"


def test_reach_and_limits_come_first(arm, pose):
    scene = srs_ik.Scene()
    scene.add_sphere("world", [0, 0, 0.5], 3.0)
    far = pose.copy()
    far[0, 3] += 5.0
    assert arm.solve(far, scene=scene).status == "UNREACHABLE"
    rng = generator("iiwa14", 2)
    for _ in range(200):
        T = arm.forward_kinematics(rng.uniform(-3, 3, 7))
        plain = arm.solve(T)
        if not plain:
            assert arm.solve(T, scene=scene).status == plain.status
            return
    pytest.fail("no pose outside the limits was found")


@pytest.mark.slow
def test_answers_keep_the_margin(arm):
    rng, scene = generator("iiwa14", 1), srs_ik.Scene()
    scene.add_sphere("ball", [0.45, 0.25, 0.5], 0.1)
    scene.add_capsule("post", AT([0.4, -0.4, 0.4], [0.2, 0, 0]), 0.05, 0.6)
    tables = arm.tables(scene)
    solved = 0
    for _ in range(25):
        q = rng.uniform(0.8 * arm.lower, 0.8 * arm.upper)
        T = arm.forward_kinematics(q)
        for seed in (None, q):
            answer = arm.solve(T, seed=seed, scene=scene, margin=0.01)
            if answer:
                solved += 1
                assert clearance(arm, tables, answer.q) > 0.01 - 1e-9
                assert arm.verify(T, answer.q).position < 1e-9
                if seed is not None:
                    plain = np.sum((arm.solve(T, seed=q).q - q) ** 2)
                    assert np.sum((answer.q - q) ** 2) >= plain - 1e-9
        for each in arm.solve_all(T, scene=scene, margin=0.01):
            assert clearance(arm, tables, each.q) > 0.01 - 1e-9
    assert solved > 10


def test_the_nearest_free_posture_is_nearest(arm, pose):
    scene = srs_ik.Scene()
    elbow = arm.joint_frames(Q)[4, :3, 3]
    scene.add_sphere("ball", elbow + np.array([0, 0.05, 0]), 0.05)
    answer = arm.solve(pose, seed=Q, scene=scene)
    assert answer
    least = np.inf
    for each in arm.intervals(pose, scene=scene):
        for psi in np.linspace(each.lower, each.upper, 400):
            other = arm.solve(pose, arm_angle=psi, branch=each.branch, seed=Q)
            if other:
                least = min(least, np.sum((other.q - Q) ** 2))
    assert np.sum((answer.q - Q) ** 2) <= least + 1e-6


@pytest.mark.slow
def test_the_largest_clearance_is_that_of_a_sweep(arm, pose):
    scene = srs_ik.Scene()
    scene.add_sphere("ball", [0.3, 0.3, 0.5], 0.08)
    best = arm.optimise(pose, "clearance", scene=scene)
    tables = arm.tables(scene)
    assert abs(clearance(arm, tables, best.q) - best.value) < 1e-9
    swept = [
        clearance(arm, tables, arm.solve(pose, arm_angle=psi, branch=each.branch).q)
        for each in arm.intervals(pose, scene=scene)
        for psi in np.linspace(each.lower + 1e-9, each.upper - 1e-9, 40)
    ]
    assert best.value >= max(swept) - 2e-6
    assert best.interval is not None
    assert best.arm_angle in best.interval


def test_other_objectives_keep_clear(arm, pose):
    scene = srs_ik.Scene()
    scene.add_box("wall", AT([0.3, 0.45, 0.5], [0, 0, 0]), [0.6, 0.1, 1.0])
    for objective, more in (("manipulability", {}), (lambda q: float(q[0]), {}), ("limit_margin", {})):
        best = arm.optimise(pose, objective, scene=scene, **more)
        assert best
        assert any(i.branch == best.branch and best.arm_angle in i for i in arm.intervals(pose, scene=scene))
        assert abs(best.value - best.objective.value(arm, best.q)) < 1e-12


def test_an_arm_angle_is_free_or_not(arm, pose):
    scene = srs_ik.Scene()
    scene.add_sphere("ball", arm.joint_frames(Q)[4, :3, 3], 0.05)
    psi = arm.arm_angle(Q)
    assert arm.solve(pose, psi)
    hit = arm.solve(pose, psi, branch=arm.branch(Q), scene=scene)
    assert hit.status == "COLLISION"
    assert hit.collision.second == "ball"
    assert abs(hit.arm_angle - psi) < 1e-9
    free = arm.intervals(pose, scene=scene)[0]
    assert arm.solve(pose, 0.5 * (free.lower + free.upper), scene=scene)


def test_batches_answer_like_single_calls(arm):
    rng, scene = generator("iiwa14", 3), srs_ik.Scene()
    scene.add_box("box", AT([0.5, 0, 0.4], [0, 0, 0]), [0.3, 0.3, 0.3])
    poses = np.array([arm.forward_kinematics(rng.uniform(arm.lower, arm.upper)).homogeneous for _ in range(20)])
    batch = arm.solve_batch(poses, scene=scene, threads=2)
    several = arm.intervals_batch(poses, scene=scene, threads=2)
    for i, T in enumerate(poses):
        one = arm.solve(T, scene=scene)
        assert batch[i].status == one.status
        assert np.allclose(batch.q[i], one.q, atol=1e-12)
        assert (batch[i].collision is None) == (one.collision is None)
        assert np.allclose(ends(several[i]), ends(arm.intervals(T, scene=scene)))
    assert set(batch.collisions) == {(i,) for i in range(20) if batch.status[i] == srs_ik.Status.COLLISION}


def test_a_moved_object_is_where_it_was_moved(arm, pose):
    moved, made = srs_ik.Scene(), srs_ik.Scene()
    there = AT([0.5, 0.2, 0.5], [0.3, 0.2, 0.1])
    moved.add_box("box", AT([3, 3, 3], [0, 0, 0]), [0.2, 0.3, 0.4])
    far = arm.intervals(pose, scene=moved)
    moved.move("box", there)
    made.add_box("box", there, [0.2, 0.3, 0.4])
    near = arm.intervals(pose, scene=moved)
    assert np.array_equal(ends(near), ends(arm.intervals(pose, scene=made)))
    assert sum(i.width for i in near) < sum(i.width for i in far)
    moved.remove("box")
    assert np.array_equal(ends(far), ends(arm.intervals(pose, scene=moved)))


def test_clouds_are_their_points(arm, pose):
    rng = generator("iiwa14", 6)
    points = np.column_stack([rng.uniform(0.3, 0.5, 300), rng.uniform(0.1, 0.4, 300), rng.uniform(0.2, 0.6, 300)])
    cloud, balls = srs_ik.Scene(), srs_ik.Scene()
    cloud.add_points("cloud", points, 0.01)
    for k, point in enumerate(points):
        balls.add_sphere(str(k), point, 0.01)
    a, b = arm.intervals(pose, scene=cloud), arm.intervals(pose, scene=balls)
    assert np.allclose(ends(a), ends(b), atol=1e-9)


@pytest.mark.slow
def test_a_million_points(arm, pose):
    scene = srs_ik.Scene()
    points = generator("iiwa14", 7).uniform(-2, 2, (1_000_000, 3))
    scene.add_points("cloud", points, 0.002)
    assert arm.solve(pose, scene=scene).status == "COLLISION"


def test_files(tmp_path, arm, pose):
    objects = [
        {"name": "table", "box": [1.0, 1.0, 0.05], "xyz": [0.6, 0, -0.1]},
        {"name": "ball", "sphere": 0.1, "xyz": [0.5, 0.2, 0.5]},
        {"name": "can", "cylinder": [0.05, 0.2], "xyz": [0.4, -0.3, 0.3], "rpy": [0.1, 0, 0]},
        {"name": "post", "capsule": [0.05, 0.2], "xyz": [0.4, -0.5, 0.3], "quat": [0, 0, 0, 1]},
        {"name": "cloud", "points": [[1, 1, 1], [1, 1.1, 1]], "radius": 0.01},
        {"name": "floor", "half_space": [0, 0, 1], "xyz": [0, 0, -0.2]},
    ]
    (tmp_path / "scene.json").write_text(json.dumps({"margin": 0.01, "objects": objects}))
    scene = srs_ik.Scene.from_file(tmp_path / "scene.json")
    assert scene.names == ("table", "ball", "can", "post", "cloud", "floor")
    assert scene.margin == 0.01
    yaml = "margin: 0.01\nobjects:\n" + "".join(f"- {json.dumps(each)}\n" for each in objects)
    (tmp_path / "scene.yaml").write_text(yaml)
    again = srs_ik.Scene.from_file(tmp_path / "scene.yaml")
    assert np.array_equal(ends(arm.intervals(pose, scene=scene)), ends(arm.intervals(pose, scene=again)))
    for wrong in (
        {"sphere": 0.1, "box": [1, 1, 1]},
        {"spere": 1},
        {"cylinder": 3},
        {"sphere": -1},
        {"mesh": "no.stl"},
        3,
    ):
        (tmp_path / "wrong.json").write_text(json.dumps({"objects": [wrong]}))
        with pytest.raises(InvalidScene, match=r"wrong\.json"):
            srs_ik.Scene.from_file(tmp_path / "wrong.json")


def test_messages_of_ros(arm, pose):
    def at(x, y, z):
        return Message(position=Message(x=x, y=y, z=z), orientation=Message(x=0.0, y=0.0, z=0.0, w=1.0))

    box = Message(type=1, dimensions=[0.2, 0.2, 0.2])
    can = Message(type=3, dimensions=[0.4, 0.05])
    both = Message(
        id="both", pose=at(0.5, 0.2, 0.4), primitives=[box, can], primitive_poses=[at(0, 0, 0), at(0, 0, 0.3)]
    )
    scene, made = srs_ik.Scene(), srs_ik.Scene()
    scene.add_message(Message(world=Message(collision_objects=[both])))
    assert scene.names == ("both/0", "both/1")
    made.add_box("a", AT([0.5, 0.2, 0.4], [0, 0, 0]), [0.2, 0.2, 0.2])
    made.add_cylinder("b", AT([0.5, 0.2, 0.7], [0, 0, 0]), 0.05, 0.4)
    assert np.allclose(ends(arm.intervals(pose, scene=scene)), ends(arm.intervals(pose, scene=made)))
    cone = Message(id="cone", primitives=[Message(type=4, dimensions=[1, 1])], primitive_poses=[at(0, 0, 0)])
    with pytest.raises(InvalidScene, match="cone"):
        scene.add_message(cone)


def truth_of_two(arm, beside):
    """What collides with the arm itself and with another one like it, which stands beside it at Q, by Pinocchio."""
    truth, other = Truth(*file_of_and(arm)), Truth(*file_of_and(arm))
    q = arm.configuration(Q, other.model)
    pin.updateGeometryPlacements(other.model, other.data, other.shapes, other.shape_data, q)
    for k, shape in enumerate(other.shapes.geometryObjects):
        truth.add(f"other {k}", beside @ other.shape_data.oMg[k].homogeneous, shape.geometry)
    return truth


def test_two_arms_keep_clear_of_each_other(arm):
    """The other arm, standing, is an obstacle like any other; moved onto this one it leaves nothing."""
    scene = srs_ik.Scene()
    beside = AT([0.0, 0.6, 0.0], [0, 0, 0])
    scene.add_arm("other", arm, Q, pose=beside)
    rng, truth = generator("iiwa14", 8), truth_of_two(arm, beside.homogeneous)
    hit = solved = 0
    for _ in range(20):
        T = arm.forward_kinematics(rng.uniform(0.8 * arm.lower, 0.8 * arm.upper))
        answer = arm.solve(T, scene=scene)
        if answer:
            solved += 1
            assert not truth.collides(answer.q)
        hit += answer.collision is not None and answer.collision.second.startswith("other/")
    assert solved > 5
    scene.move("other", np.eye(4))
    assert arm.solve(arm.forward_kinematics(Q), Q[0], scene=scene).status != "OK"
    with pytest.raises(InvalidScene, match="stands"):
        scene.add_arm("third", arm, Q)


@pytest.mark.slow
def test_copies_keep_their_plan(arm, pose):
    import copy

    changed = arm.with_bodies(drop=[("iiwa_link_0", "iiwa_link_6")])
    for other in (copy.deepcopy(changed), pickle.loads(pickle.dumps(changed))):
        assert np.array_equal(
            ends(other.intervals(pose, scene=srs_ik.Scene())), ends(changed.intervals(pose, scene=srs_ik.Scene()))
        )


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"margn": 0.1}, "'margn' .*margin"),
        ({"object": []}, "has 'object' .did you mean 'objects'"),
        ({"exact": "false"}, "exact is true or false, not 'false'"),
        ({"objects": [{"name": "a", "box": [1, 1, 1], "radius": 0.1}]}, "'a' has 'radius'"),
        ({"objects": [{"name": "a", "sphere": 1, "scale": 2}]}, "'a' has 'scale'"),
        ({"objects": [{"name": "a", "box": [1, 1, 1], "rpy": [0, 0, 1], "quat": [0, 0, 0, 1]}]}, "rpy and quat"),
    ],
)
def test_what_a_file_says_in_vain_is_refused(tmp_path, more, said):
    (tmp_path / "scene.json").write_text(json.dumps({"objects": [], **more}))
    with pytest.raises(InvalidScene, match=said):
        srs_ik.Scene.from_file(tmp_path / "scene.json")


@pytest.mark.parametrize("turn", ["rpy", "quat"])
def test_a_half_space_of_a_file_is_turned(tmp_path, arm, pose, turn):
    """A floor that is turned is the wall whose normal SciPy gives, and takes other arm angles than the floor."""
    rotation = Rotation.from_euler("xyz", [-0.9, 0.1, 0.2])
    figures = rotation.as_euler("xyz") if turn == "rpy" else rotation.as_quat()
    point, normal = [0.0, -0.2, 0.2], rotation.apply([0.0, 0.6, 0.8])
    floor = {"name": "floor", "half_space": [0.0, 0.6, 0.8], "xyz": point}
    (tmp_path / "turned.json").write_text(json.dumps({"objects": [floor | {turn: figures.tolist()}]}))
    (tmp_path / "level.json").write_text(json.dumps({"objects": [floor]}))
    turned, level = (srs_ik.Scene.from_file(tmp_path / f"{name}.json") for name in ("turned", "level"))
    wall = srs_ik.Scene()
    wall.add_half_space("wall", point, normal)
    expected = ends(arm.intervals(pose, scene=wall))
    assert np.allclose(ends(arm.intervals(pose, scene=turned)), expected, rtol=0.0, atol=1e-9)
    assert not np.array_equal(ends(arm.intervals(pose, scene=level)), expected)


def test_degrees_in_a_file_are_noticed(tmp_path):
    turned = {"name": "a", "box": [1, 1, 1], "rpy": [0, 0, 90]}
    (tmp_path / "scene.json").write_text(json.dumps({"objects": [turned]}))
    with pytest.warns(UserWarning, match="rpy of 'a' is in radians, and 90 rad is more than a turn: are these degrees"):
        srs_ik.Scene.from_file(tmp_path / "scene.json")


def test_millimetres_are_noticed(tmp_path, arm, recwarn):
    """A beam of 80 mm in millimetres is no beam of 80 m: whoever adds it hears of it, and of how to scale it."""
    stl = tmp_path / "beam.stl"
    trimesh.creation.box([80.0, 20.0, 20.0]).export(stl)
    part = {"name": "beam", "mesh": "beam.stl"}
    (tmp_path / "scene.json").write_text(json.dumps({"objects": [part]}))
    (tmp_path / "scaled.json").write_text(json.dumps({"objects": [part | {"scale": 0.001}]}))
    beam = trimesh.creation.box([80.0, 20.0, 20.0])
    said = "the mesh of 'beam' is in metres, and 80 m wide: are these millimetres. A scale of 0.001 makes metres"
    for add in (
        lambda: srs_ik.Scene().add_mesh("beam", np.eye(4), stl),
        lambda: srs_ik.Scene().add_triangles("beam", np.eye(4), beam.vertices, beam.faces),
        lambda: srs_ik.Scene.from_file(tmp_path / "scene.json"),
        lambda: arm.with_object("beam", np.eye(4), file=stl),
    ):
        with pytest.warns(UserWarning, match=said):
            add()
    with pytest.warns(UserWarning, match="the box 'table' is in metres, and 800 m long: are these millimetres"):
        srs_ik.Scene().add_box("table", np.eye(4), [600, 800, 50])
    recwarn.clear()
    srs_ik.Scene().add_box("floor", np.eye(4), [100.0, 100.0, 0.1])
    srs_ik.Scene().add_box("table", np.eye(4), [0.6, 0.8, 0.05])
    srs_ik.Scene().add_mesh("beam", np.eye(4), stl, scale=0.001)
    srs_ik.Scene.from_file(tmp_path / "scaled.json")
    held = arm.with_object("beam", np.eye(4), file=stl, scale=0.001).plan.held[-1]
    assert not recwarn.list
    assert np.allclose(np.ptp(held.forms[0].vertices, axis=0).max(), 0.08, rtol=0.1)
    with pytest.raises(InvalidScene, match="scale goes with the file of a mesh"):
        arm.with_object("ball", np.eye(4), radius=0.1, scale=0.001)


def test_messages_are_read_as_moveit_reads_them(arm, pose):
    def at(x, y, z, w):
        return Message(position=Message(x=x, y=y, z=z), orientation=Message(x=0.0, y=0.0, z=0.0, w=w))

    boxes = [Message(type=1, dimensions=[0.2, 0.2, 0.2]), Message(type=2, dimensions=[0.1])]

    def read(**fields):
        scene = srs_ik.Scene()
        scene.add_message(Message(id="a", primitives=boxes, **fields))
        return scene

    made = srs_ik.Scene()
    made.add_box("a/0", AT([0.5, 0.2, 0.5], [0, 0, 0]), [0.2, 0.2, 0.2])
    made.add_sphere("a/1", [0.5, 0.2, 0.3], 0.1)
    # Nobody has turned the object, its second shape has no pose, and bytes are numbers.
    scene = read(pose=at(0.5, 0.2, 0.3, 0.0), primitive_poses=[at(0, 0, 0.2, 1.0)], operation=b"\x00")
    assert scene.names == made.names
    assert np.array_equal(ends(arm.intervals(pose, scene=scene)), ends(arm.intervals(pose, scene=made)))
    there = [at(0, 0, 0.2, 1.0), at(0, 0, 0, 1.0)]
    for wrong, said in (
        ({"operation": 2}, "neither adds, moves nor removes it"),
        ({"operation": b"\x02"}, "neither adds, moves nor removes it"),
        ({"operation": 1}, "the scene has no 'a'"),
        ({"operation": b"\x03"}, "the scene has no 'a'"),
        ({"planes": [Message(coef=[0, 0, 1, 0])]}, "planes"),
        ({"primitive_poses": [*there, there[0]]}, "2 primitives and 3 primitive_poses"),
        ({"pose": at(0, 0, 0, 0.5)}, "pose of 'a': a quaternion"),
        ({"pose": 3}, "no pose of geometry_msgs"),
    ):
        with pytest.raises(InvalidScene, match=said):
            read(**{"primitive_poses": there, **wrong})
    held = Message(object=Message(id="cup"))
    for more, words in (
        ({"robot_state": Message(attached_collision_objects=[held])}, "holds cup: give them to Arm.with_object"),
        ({"link_padding": [Message(link_name="hand", padding=0.02)]}, "link_padding of 'hand'"),
        ({"link_scale": [Message(link_name="hand", scale=1.1)]}, "link_scale of 'hand'"),
    ):
        with pytest.raises(InvalidScene, match=words):
            srs_ik.Scene().add_message(Message(world=Message(collision_objects=[]), **more))
    plain = {"link_padding": [Message(link_name="hand", padding=0.0)], "link_scale": [Message(scale=1.0)]}
    state = Message(attached_collision_objects=[])
    srs_ik.Scene().add_message(Message(world=Message(collision_objects=[]), robot_state=state, **plain))
    seen = Message(collision_objects=[], octomap=Message(octomap=Message(data=[1, 2])))
    with pytest.raises(InvalidScene, match="octomap"):
        srs_ik.Scene().add_message(Message(world=seen))
    seen.octomap.octomap.data = []
    srs_ik.Scene().add_message(Message(world=seen))


@pytest.mark.slow
def test_a_question_sees_objects_where_they_stood_when_it_was_asked():
    """Objects are moved by one thread, while another one asks for many poses."""
    arm, scene = srs_ik.load("iiwa14"), srs_ik.Scene()
    scene.add_box("box", np.eye(4), [0.3, 0.3, 0.3])
    here, there = np.eye(4), np.eye(4)
    here[:3, 3], there[:3, 3] = [0.5, 0.0, 0.5], [0.5, 0.4, 0.3]
    rng = np.random.default_rng(1)
    poses = arm.forward_kinematics_batch(rng.uniform(arm.lower, arm.upper, (3000, 7)))

    def ask():
        found = arm.intervals_batch(poses, scene=scene, threads=1)
        return [[(i.branch, i.lower, i.upper) for i in found[k]] for k in range(len(poses))]

    expected = []
    for place in (here, there):
        scene.move("box", place)
        expected.append(ask())
    assert expected[0] != expected[1]
    answers = []
    for _ in range(3):
        scene.move("box", here)
        asking = threading.Thread(target=lambda: answers.append(ask()))
        asking.start()
        count = 0
        while asking.is_alive():
            count += 1
            scene.move("box", (there, here)[count % 2])
            arm.intervals(poses[0], scene=scene)
        asking.join()
        assert count > 10
    assert all(answer in expected for answer in answers)


def test_tables_that_a_question_has_stay_as_they_are():
    arm, scene = srs_ik.load("iiwa14"), srs_ik.Scene()
    scene.add_sphere("ball", [0.5, 0.0, 0.5], 0.1)
    before = arm.tables(scene)
    rows = before.bodies.copy()
    T = np.eye(4)
    T[2, 3] = 1.0
    scene.move("ball", T)
    after = arm.tables(scene)
    assert (before.bodies == rows).all()
    assert (after.bodies != rows).any()
    assert arm.tables(scene) is after


@pytest.mark.slow
def test_a_copied_scene_is_another_one():
    """A shallow copy shared the objects, and moved them in the first scene without its knowing."""
    arm, scene = srs_ik.load("iiwa14"), srs_ik.Scene(margin=0.01)
    scene.add_sphere("ball", [0.4, 0.1, 0.7], 0.1)
    pose = arm.forward_kinematics(Q)
    before = ends(arm.intervals(pose, scene=scene))
    other = copy.copy(scene)
    T = np.eye(4)
    T[2, 3] = 5.0
    other.move("ball", T)
    other.add_sphere("another", [0.0, 0.0, 3.0], 0.1)
    assert scene.names == ("ball",)
    assert other.names == ("ball", "another")
    assert (ends(srs_ik.load("iiwa14").intervals(pose, scene=scene)) == before).all()
    assert ends(arm.intervals(pose, scene=other)).shape != before.shape


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("twice.json", '{"objects": [{"name": "a", "sphere": 1, "xyz": [0, 0, 0], "xyz": [5, 0, 0]}]}'),
        ("twice.yaml", "objects:\n  - {name: a, sphere: 1, xyz: [0, 0, 0], xyz: [5, 0, 0]}\n"),
    ],
)
def test_a_key_that_is_given_twice_is_refused(tmp_path, name, text):
    (tmp_path / name).write_text(text)
    with pytest.raises(InvalidScene, match="'xyz' is given twice"):
        srs_ik.Scene.from_file(tmp_path / name)
    (tmp_path / name).write_text(text.replace("xyz", "rpy", 1))
    assert srs_ik.Scene.from_file(tmp_path / name).names == ("a",)


def test_misspelt_attributes_are_refused():
    scene = srs_ik.Scene()
    with pytest.raises(AttributeError, match=r"no attribute 'excat' \(did you mean 'exact'\?\)"):
        scene.excat = True
    with pytest.raises(srs_ik.InvalidScene, match="margin"):
        scene.margin = -1.0
    scene.margin = 0.02
    assert pickle.loads(pickle.dumps(scene)).margin == 0.02


def test_an_arm_beside_is_of_the_same_robot():
    iiwa, gen3 = srs_ik.load("iiwa14"), srs_ik.load("gen3")
    with pytest.raises(srs_ik.InvalidScene, match="of another robot: iiwa14 has none of its links"):
        srs_ik.Scene().add_arm("other", gen3, [0.0] * 7, beside=iiwa)


def test_an_arm_is_not_beside_itself():
    iiwa = srs_ik.load("iiwa14")
    with pytest.raises(srs_ik.InvalidScene, match="'other' has joints of iiwa14 itself"):
        srs_ik.Scene().add_arm("other", iiwa, [0.0] * 7, beside=iiwa)


def test_arms_on_a_lift_stand_at_the_same_height():
    mounts = (
        '<robot name="cell"><link name="floor"/><link name="column"/>'
        '<joint name="lift" type="prismatic"><parent link="floor"/><child link="column"/><axis xyz="0 0 1"/>'
        '<limit lower="0" upper="1" effort="1" velocity="1"/></joint>'
    )
    arms = ""
    for side in ("left_", "right_"):
        arms += serial_arm(prefix=side) + joint_xml(f"{side}mount", "column", f"{side}l0", "fixed", "")
        arms += f'<link name="{side}ball"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>'
        arms += joint_xml(f"{side}fixed", f"{side}l7", f"{side}ball", "fixed", "")
    cell = f"{mounts}{arms}</robot>"
    left = srs_ik.load(cell, base="floor", limb="left", locked={"lift": 0.3})
    low = srs_ik.load(cell, limb="right")
    with pytest.raises(srs_ik.InvalidScene, match=r"joint 'lift' stands at 0\.3 for cell and at 0 for 'right'"):
        srs_ik.Scene().add_arm("right", low, [0.1] * 7, beside=left)
    scene = srs_ik.Scene()
    scene.add_arm("right", srs_ik.load(cell, limb="right", locked={"lift": 0.3}), [0.1] * 7, beside=left)
    hit = left.collision([0.1] * 7, scene)
    assert hit is not None
    assert {hit.first, hit.second} == {"left_ball", "right/right_ball"}


def test_where_objects_are_can_be_read():
    scene, pose = srs_ik.Scene(), srs_ik.pose_from_xyz_rpy([0.5, 0.0, 0.1], [0.0, 0.0, 0.3])
    scene.add_box("table", pose, [0.6, 0.8, 0.05])
    scene.add_sphere("ball", [1.0, 2.0, 3.0], 0.1)
    assert scene.pose("table") == pytest.approx(pose.homogeneous)
    scene.pose("table")[:] = 0.0
    scene.move("ball", pose)
    assert scene.pose("ball") == pytest.approx(pose.homogeneous) == scene.pose("table")
    assert [str(thing) for thing in scene] == [
        "<'table' at (0.5, 0, 0.1) m: box 0.6 x 0.8 x 0.05 m>",
        "<'ball' at (0.5, 0, 0.1) m: sphere 0.1 m>",
    ]
    with pytest.raises(srs_ik.InvalidScene, match="did you mean 'table'"):
        scene.pose("tabel")


def test_a_file_that_is_not_there_is_no_scene(tmp_path):
    with pytest.raises(srs_ik.InvalidScene, match="there is no file"):
        srs_ik.Scene.from_file(tmp_path / "none.json")


def test_a_planning_scene_that_is_told_again_and_again():
    def at(x, y, z):
        return Message(position=Message(x=x, y=y, z=z), orientation=Message(x=0.0, y=0.0, z=0.0, w=1.0))

    def told(scene, *objects):
        scene.add_message(Message(world=Message(collision_objects=list(objects))))

    box, ball = Message(type=1, dimensions=[0.2, 0.2, 0.2]), Message(type=2, dimensions=[0.1])
    cup = Message(
        id="cup", pose=at(0.5, 0.2, 0.4), primitives=[box, ball], primitive_poses=[at(0, 0, 0), at(0, 0, 0.3)]
    )
    scene = srs_ik.Scene()
    scene.add_sphere("lamp", [0.0, 0.0, 2.0], 0.1)
    told(scene, cup)
    told(scene, cup)
    assert scene.names == ("lamp", "cup/0", "cup/1")
    scene.move("cup/1", np.eye(4))
    told(
        scene, Message(id="cup", operation=3, pose=at(0.1, 0.2, 0.3)), Message(id="lamp", operation=3, pose=at(1, 1, 1))
    )
    places = {thing.name: thing.T[:3, 3].round(12).tolist() for thing in scene}
    assert places == {"lamp": [1, 1, 1], "cup/0": [0.1, 0.2, 0.3], "cup/1": [0.1, 0.2, 0.6]}
    told(scene, Message(id="cup", primitives=[ball]))
    assert scene.names == ("lamp", "cup")
    # All of a message counts, or nothing.
    cone = Message(id="cone", primitives=[Message(type=4, dimensions=[1, 1])])
    bad = Message(id="bad", primitives=[Message(type=2, dimensions=[-1.0])])
    for wrong in (cone, bad, Message(id="none", operation=1)):
        with pytest.raises(InvalidScene):
            told(scene, Message(id="new", primitives=[box]), Message(id="cup", operation=1), wrong)
        assert scene.names == ("lamp", "cup")
    told(scene, Message(id="cup", operation=b"\x01"))
    assert scene.names == ("lamp",)
    for operation in (1, 3):
        with pytest.raises(InvalidScene, match="the scene has no 'cup'"):
            told(scene, Message(id="cup", operation=operation, pose=at(1, 1, 1)))
    told(scene, cup, Message(id="", operation=1))
    assert scene.names == ()


def test_an_object_of_one_shape_is_where_its_shape_is_and_moves_as_in_moveit():
    """Where the pose of its one shape is all that an object says, that is its pose; a move may place the shapes."""

    def at(x, y, z, w=1.0):
        return Message(position=Message(x=x, y=y, z=z), orientation=Message(x=0.0, y=0.0, z=0.0, w=w))

    box, unset = Message(type=1, dimensions=[0.1, 0.1, 0.1]), at(0.0, 0.0, 0.0, 0.0)
    for nothing in (unset, at(0.0, 0.0, 0.0)):
        scene = srs_ik.Scene()
        scene.add_message(Message(id="a", pose=nothing, primitives=[box], primitive_poses=[at(0.5, 0.0, 0.3)]))
        assert next(iter(scene)).T[:3, 3].tolist() == [0.5, 0.0, 0.3]
        scene.add_message(Message(id="a", operation=3, pose=at(0.2, 0.2, 0.2)))
        assert next(iter(scene)).T[:3, 3].tolist() == [0.2, 0.2, 0.2]
    scene.add_message(Message(id="a", operation=3, pose=unset, primitive_poses=[at(0.6, 0.1, 0.3)]))
    assert next(iter(scene)).T[:3, 3].tolist() == [0.6, 0.1, 0.3]
    two = [at(0.6, 0.1, 0.3), at(0.0, 0.0, 0.0)]
    with pytest.raises(InvalidScene, match="'a' has 1, and is moved with poses of 2 shapes"):
        scene.add_message(Message(id="a", operation=3, primitive_poses=two))


def test_a_whole_planning_scene_takes_the_place_of_what_messages_told_before():
    ball = Message(type=2, dimensions=[0.1])
    scene = srs_ik.Scene()
    scene.add_sphere("lamp", [0.0, 0.0, 2.0], 0.1)
    for is_diff, name, names in (
        (False, "a", ("lamp", "a")),
        (True, "b", ("lamp", "a", "b")),
        (False, "c", ("lamp", "c")),
    ):
        world = Message(collision_objects=[Message(id=name, primitives=[ball])])
        scene.add_message(Message(is_diff=is_diff, world=world))
        assert scene.names == names
