"""What a preview draws lies where Pinocchio says that it is, and wrong input is one clear error."""

import json
import subprocess
import sys

import numpy as np
import pinocchio as pin
import pytest
import trimesh
import umsgpack
from meshcat.servers.tree import find_node
from robot_files import joint_xml, robot_xml, serial_arm
from scene import Scene

import srs_ik
from srs_ik.preview import Preview, palette, words
from srs_ik.robot import zoo
from srs_ik.solve.path.solution import PathSolution

Q = np.array([0.3, 0.7, -0.4, -1.2, 0.5, 0.8, -0.2])


@pytest.fixture(scope="module")
def arm():
    return srs_ik.load("iiwa14")


@pytest.fixture
def view(arm):
    with Preview(arm) as view:
        yield view


def bounds(points: np.ndarray) -> np.ndarray:
    return np.array([points.min(axis=0), points.max(axis=0)])


def pinocchio_bounds(name: str, q: np.ndarray) -> list[np.ndarray]:
    """Bounding box of every visual of a built-in robot in its base frame, from the untouched file, by Pinocchio."""
    card = zoo.card(name)
    model = pin.buildModelFromUrdf(str(card.urdf))
    visuals = pin.buildGeomFromUrdf(model, str(card.urdf), pin.GeometryType.VISUAL)
    data, placed = model.createData(), visuals.createData()
    configuration = pin.neutral(model)
    for joint, angle in zip(model.joints[1:], q, strict=True):
        if joint.nq == 1:
            configuration[joint.idx_q] = angle
        else:
            configuration[joint.idx_q : joint.idx_q + 2] = np.cos(angle), np.sin(angle)
    pin.updateGeometryPlacements(model, data, visuals, placed, configuration)
    pin.updateFramePlacements(model, data)
    T_world_base = data.oMf[model.getFrameId(card.base, pin.FrameType.BODY)]
    boxes = []
    for shape, T_world_shape in zip(visuals.geometryObjects, placed.oMg, strict=True):
        T = T_world_base.actInv(T_world_shape)
        geometry, R = shape.geometry, T.rotation
        if hasattr(geometry, "halfSide"):
            half = np.abs(R) @ geometry.halfSide
        elif hasattr(geometry, "halfLength"):
            half = np.abs(R[:, 2]) * geometry.halfLength + geometry.radius * np.sqrt(
                np.maximum(0.0, 1.0 - R[:, 2] ** 2)
            )
        else:
            half = np.full(3, geometry.radius)
        boxes.append(np.array([T.translation - half, T.translation + half]))
    return boxes


@pytest.mark.parametrize("name", zoo.robots())
def test_shapes_are_drawn_where_pinocchio_puts_them(name):
    arm, rng = srs_ik.load(name), np.random.default_rng(7)
    q = rng.uniform(np.maximum(arm.lower, -3.0), np.minimum(arm.upper, 3.0))
    with Preview(arm) as view:
        view.show(q)
        drawn = [bounds(points) for points in Scene(view).solids("robot")]
        assert view.missing == []
    expected = pinocchio_bounds(name, q)
    assert len(drawn) == len(expected) > 20
    # Round things are drawn with edges, and come out smaller by up to 0.3 % of a radius of 0.1 m.
    for box in drawn:
        assert min(np.abs(box - other).max() for other in expected) < 5e-4
    for box in expected:
        assert min(np.abs(box - other).max() for other in drawn) < 5e-4


def test_the_tip_frame_is_where_the_tip_is(view, arm):
    view.show(Q)
    scene = Scene(view)
    T = scene.transform("tip/joint 7") @ scene.transform("tip/joint 7/frame")
    assert np.abs(T - arm.forward_kinematics(Q).homogeneous).max() < 1e-12


def test_the_limb_ends_at_the_tip_and_bends_at_the_elbow(view, arm):
    view.show(Q)
    tip = arm.forward_kinematics(Q).translation
    hand = np.concatenate(Scene(view).solids("limb", [7]))
    # The rod ends in a disc of 5 mm about the tip.
    assert np.linalg.norm(hand - tip, axis=1).min() < 6e-3
    upper_arm = np.concatenate(Scene(view).solids("limb", [3]))
    forearm = np.concatenate(Scene(view).solids("limb", [4]))
    gap = np.linalg.norm(upper_arm[:, None] - forearm[None], axis=-1).min()
    assert gap < 6e-3


def test_the_circle_passes_every_elbow_of_the_pose(view, arm):
    view.show(Q)
    (circle,) = Scene(view).vertices("elbow circle")
    pose = arm.forward_kinematics(Q)
    for psi in np.linspace(-3.0, 3.0, 13):
        q = arm.solve(pose, arm_angle=psi, respect_limits=False).q
        # Joint 4 of this robot has its origin in the elbow, and the ring is 3.3 mm thick, drawn in steps of 12 mm.
        distance = np.linalg.norm(circle - arm.joint_frames(q)[4, :3, 3], axis=1).min()
        assert distance < 8e-3


@pytest.mark.slow
def test_arcs_are_on_the_rays_of_feasible_elbows(view, arm):
    pose = arm.forward_kinematics(Q)
    intervals = view.show_intervals(pose)
    assert {f"branch {interval.branch}" for interval in intervals} == Scene(view).names("intervals")
    shoulder = np.array([0.0, 0.0, 0.36])
    q = arm.solve(pose, respect_limits=False).q
    wrist = arm.joint_frames(q)[6, :3, 3]
    axis = (wrist - shoulder) / np.linalg.norm(wrist - shoulder)
    elbow = arm.joint_frames(q)[4, :3, 3]
    centre = shoulder + axis * (axis @ (elbow - shoulder))
    psi = arm.arm_angle(q)
    across = (elbow - centre) / np.linalg.norm(elbow - centre)
    for branch in {interval.branch for interval in intervals}:
        points = np.concatenate(Scene(view).vertices(f"intervals/branch {branch}")) - centre
        angles = psi + np.arctan2(points @ np.cross(axis, across), points @ across)
        own = [interval for interval in intervals if interval.branch == branch]
        # The round ends reach a little beyond: 6 mm at a radius of 0.2 m.
        for angle in angles:
            beyond = min(
                max(0.0, interval.lower - turned, turned - interval.upper)
                for interval in own
                for turned in angle + 2.0 * np.pi * np.arange(-2, 3)
            )
            assert beyond < 0.05


def test_ellipsoids_are_centred_on_the_tip_and_as_long_as_they_are_wide(view, arm):
    view.show_ellipsoids(Q)
    tip, J = arm.forward_kinematics(Q).translation, arm.jacobian(Q)[:3]
    surface = Scene(view).vertices("velocity")[0] - tip
    lengths = np.linalg.norm(surface, axis=1)
    # On the ellipsoid u' (J J')^-1 u is the same for all points.
    values = np.einsum("ni,ij,nj->n", surface, np.linalg.inv(J @ J.T), surface)
    assert np.ptp(values) < 1e-4 * values.mean()
    force = Scene(view).vertices("force")[0] - tip
    values = np.einsum("ni,ij,nj->n", force, J @ J.T, force)
    assert np.ptp(values) < 1e-4 * values.mean()
    assert 0.1 < lengths.max() < 0.5


def test_singular_ellipsoids_are_flat_and_finite(view):
    view.show_ellipsoids(np.zeros(7))
    for name in ("velocity", "force"):
        assert all(np.isfinite(points).all() for points in Scene(view).vertices(name))
    thickness = np.ptp(Scene(view).vertices("velocity")[0][:, 2])
    assert thickness < 0.02


@pytest.mark.slow
def test_a_task_is_shown_at_its_place():
    human = srs_ik.load("human_arm")
    task = srs_ik.Task([0.35, 0.15, -0.2], [1, 0, 0], [0, 0, -1], grasp=[1, 0, 0])
    posture = human.posture(task)
    with Preview(human) as view:
        view.show_posture(posture, task)
        scene = Scene(view)
        plate, *arrows = scene.vertices("task")
        assert np.abs((plate - task.position) @ posture.task_normal).max() < 2e-3
        assert len(arrows) == 4
        balls = scene.vertices("posture")[:4]
        expected = (posture.shoulder, posture.elbow, posture.wrist, posture.hand)
        for ball, point in zip(balls, expected, strict=True):
            assert np.abs(bounds(ball).mean(axis=0) - point).max() < 1e-4
        with pytest.raises(srs_ik.InvalidTask, match="choose one by its index"):
            view.show_posture(human.posture(srs_ik.Task(np.zeros((2, 3)), [1, 0, 0], [0, 0, 1])))
        with pytest.raises(srs_ik.InvalidTask, match="a Posture is shown"):
            view.show_posture(task)


def test_ghosts_are_the_other_branches(view, arm):
    pose = arm.forward_kinematics(Q)
    view.show(Q)
    count = view.show_ghosts(pose)
    names = Scene(view).names("ghosts")
    assert len(names) == count > 3
    assert f"branch {arm.branch(Q)}" not in names
    flange = pose.homogeneous @ np.linalg.inv(Scene(view).transform("tip/joint 7/frame"))
    for name in names:
        assert np.abs(Scene(view).transform(f"ghosts/{name}/joint 7") - flange).max() < 1e-9


@pytest.mark.slow
def test_a_self_motion_keeps_the_tip_and_moves_the_elbow(view, arm):
    pose = arm.forward_kinematics(Q)
    assert view.show_self_motion(pose)
    moving = Scene(view).animated()
    hand = np.array(moving["robot/joint 7"]["position"])
    elbow = np.array(moving["robot/joint 4"]["position"])
    assert np.ptp(hand, axis=0).max() < 1e-9
    assert np.ptp(elbow, axis=0).max() > 0.1
    view.show(Q)
    assert Scene(view).animated() == {}


def test_a_path_is_played_at_its_speed(view, arm):
    path = np.linspace(Q, Q + 0.5, 11)
    view.animate(path, 0.1)
    positions = np.array(Scene(view).animated()["robot/joint 7"]["position"])
    assert len(positions) == 31
    for k in (0, 15, 30):
        expected = arm.joint_frames(path[k // 3])[7, :3, 3]
        assert np.abs(positions[k] - expected).max() < 1e-9
    view.animate(path[:1], 0.1)
    assert Scene(view).animated() == {}


def test_a_path_solution_is_played(view, arm):
    rows = arm.solve_batch([arm.forward_kinematics(Q + step) for step in (0.0, 0.1)], seed=Q)._rows
    path = PathSolution(rows, arm.joint_names, np.diff(rows[:, :7], axis=0), [])
    view.animate(path, 0.2)
    assert (view.q == path.q[0]).all()
    assert len(Scene(view).animated()["robot/joint 7"]["position"]) == 7


def hands_of(view):
    return np.array(Scene(view).animated()["robot/joint 7"]["position"])


def test_a_path_is_played_at_its_own_times(view, arm):
    """From rest to rest it is slowest at its ends, where postures even in time would be as fast as in between."""
    poses = [arm.forward_kinematics(Q + step) for step in np.linspace(0.0, 0.6, 7)]
    path = arm.solve_path(poses, seed=Q, objective="time", acceleration_limit=np.full(7, 0.5))
    view.animate(path)
    hands = hands_of(view)
    fps = (len(hands) - 1) / path.times[-1]
    for k in range(len(hands)):
        q = [np.interp(k / fps, path.times, angles) for angles in path.q.T]
        assert np.abs(hands[k] - arm.joint_frames(q)[7, :3, 3]).max() < 1e-9
    even = arm.solve_path(poses, seed=Q, dt=0.3)
    view.animate(even)
    own = hands_of(view)
    view.animate(even, 0.3)
    np.testing.assert_array_equal(own, hands_of(view))
    view.animate(path.q[:1])
    assert Scene(view).animated() == {}


def test_a_trajectory_is_played(view, arm):
    poses = [arm.forward_kinematics(Q + step) for step in (0.0, 0.1, 0.3)]
    motion = arm.solve_path(poses, known={0: Q}, dt=0.4).trajectory()
    view.animate(motion)
    hands = hands_of(view)
    samples = motion.sample(motion.duration / (len(hands) - 1))
    assert len(samples.q) == len(hands) > 0.8 * 30.0
    for k, q in enumerate(samples.q):
        assert np.abs(hands[k] - arm.joint_frames(q)[7, :3, 3]).max() < 1e-9


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda v: v.animate(np.zeros((3, 7))), srs_ik.InvalidConfiguration, "how fast the path is passed: give dt"),
        (
            lambda v: v.animate(v.arm.solve_path([v.arm.forward_kinematics(Q)] * 2, dt=0.1).trajectory(), 0.1),
            srs_ik.InvalidConfiguration,
            "a trajectory has times of its own",
        ),
        (lambda v: v.show([1, 2]), srs_ik.InvalidConfiguration, "7 joint angles"),
        (lambda v: v.show([np.nan] * 7), srs_ik.InvalidConfiguration, "not finite"),
        (lambda v: v.show_target(np.zeros((4, 4))), srs_ik.InvalidPose, "no rigid transform"),
        (lambda v: v.show_intervals(np.eye(3)), srs_ik.InvalidPose, "4 x 4"),
        (lambda v: v.show_self_motion(np.eye(4), branch=9), srs_ik.InvalidConfiguration, "0 to 7"),
        (lambda v: v.animate(np.zeros((3, 6)), 0.1), srs_ik.InvalidConfiguration, r"\(N, 7\)"),
        (lambda v: v.animate(np.zeros((0, 7)), 0.1), srs_ik.InvalidConfiguration, r"\(N, 7\)"),
        (lambda v: v.animate(np.zeros((3, 7)), 0.0), srs_ik.InvalidConfiguration, "positive"),
        (lambda v: v.animate("path", 0.1), srs_ik.InvalidConfiguration, r"\(N, 7\)"),
        (lambda v: v.show_ellipsoids(Q, part="full"), srs_ik.InvalidTask, "three dimensions"),
        (lambda v: v.show_obstacles(3), srs_ik.InvalidScene, "a list of trimesh.Trimesh, not 3"),
        (lambda v: v.show_obstacles([np.eye(4)]), srs_ik.InvalidScene, "a list of trimesh.Trimesh"),
        (lambda v: v.show_obstacles(trimesh.creation.box()), srs_ik.InvalidScene, "a list of trimesh.Trimesh"),
        (lambda v: v.save("/no/such/folder/x.html"), srs_ik.PreviewError, "no folder"),
        (lambda v: v.save("/"), srs_ik.PreviewError, "is a folder"),
        (lambda v: v.save("motion.mp4"), srs_ik.PreviewError, "such as scene.html, not 'motion.mp4'"),
        (lambda v: v.save(3), srs_ik.PreviewError, "such as scene.html, not 3"),
    ],
)
def test_wrong_input_is_one_clear_error(view, call, error, words):
    with pytest.raises(error, match=words) as caught:
        call(view)
    assert "\n" not in str(caught.value)


def test_a_pose_out_of_reach_shows_no_intervals(view):
    far = np.eye(4)
    far[0, 3] = 5.0
    assert view.show_intervals(far) == []
    assert not view.show_self_motion(far)
    assert view.show_ghosts(far) == 0
    assert not Scene(view).names("intervals")


def test_a_saved_file_is_whole_or_not_there(view, tmp_path, monkeypatch):
    path = tmp_path / "scene.html"
    assert view.save(path) == path
    text = path.read_text()
    assert text.startswith("<!DOCTYPE html>")
    assert text.rstrip().endswith("</html>")
    (tmp_path / "other").touch()
    assert path.stat().st_mode == (tmp_path / "other").stat().st_mode
    before = path.read_bytes()

    def fail(*arguments):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.replace", fail)
    with pytest.raises(srs_ik.PreviewError, match="No space left"):
        view.save(path)
    assert path.read_bytes() == before
    assert sorted(file.name for file in tmp_path.iterdir()) == ["other", "scene.html"]


def test_a_notebook_gets_a_page_in_a_frame(view):
    text = view._repr_html_()
    assert text.startswith('<iframe sandbox="allow-scripts" srcdoc="&lt;!DOCTYPE html&gt;')
    assert text.count('"') == 6
    view.close()
    assert view._repr_html_() is None


def test_a_bare_model_is_a_skeleton():
    model = pin.buildModelFromUrdf(str(zoo.card("iiwa14").urdf))
    arm = srs_ik.load(model, tip="iiwa_link_ee")
    with Preview(arm) as view:
        view.show(Q)
        points = np.concatenate(Scene(view).solids("robot"))
        tip = arm.forward_kinematics(Q).translation
        # Its last rod ends in a disc of 21 mm about the tip; the first begins at the base.
        assert np.linalg.norm(points - tip, axis=1).min() < 0.025
        assert np.linalg.norm(points, axis=1).min() < 0.025
        assert view.missing == []


@pytest.mark.slow
def test_loading_reads_no_shapes_and_imports_nothing_for_them():
    code = (
        "import sys, srs_ik; arm = srs_ik.load('iiwa14');"
        "unwanted = {'meshcat', 'trimesh', 'viser', 'srs_ik.preview', 'srs_ik.robot.description.shapes'};"
        "print(sorted(unwanted & set(sys.modules)))"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=600, check=True)
    assert found.stdout.strip() == "[]"


def to_hex(colour) -> str:
    return "#" + "".join(f"{round(255 * x):02x}" for x in colour)


class Said:
    """The caption that a page is told, as it comes through the door."""

    def __init__(self, view) -> None:
        told = json.loads(view._window._bridge.caption)
        self.title, self.lines, self.legend = told["title"], told["lines"], dict(map(reversed, told["legend"]))


def test_the_page_says_which_arm_it_is_and_what_its_colours_mean(view, arm):
    view.show(Q)
    said = Said(view)
    assert said.title == "iiwa14, iiwa_link_0 to iiwa_link_ee"
    assert said.lines == [f"arm angle {np.rad2deg(arm.arm_angle(Q)):.2f} deg, branch {arm.branch(Q)}"]
    assert said.legend == {}
    intervals = view.show_intervals(arm.forward_kinematics(Q))
    colours = {f"branch {k}": to_hex(palette.BRANCHES[k]) for k in {interval.branch for interval in intervals}}
    assert Said(view).legend == colours
    view.show_ellipsoids(Q)
    measures = {"ellipsoid of velocity": to_hex(palette.VELOCITY), "ellipsoid of force": to_hex(palette.FORCE)}
    assert Said(view).legend == colours | measures
    assert json.dumps(Said(view).lines)[1:-1] in view.html()
    view.clear()
    assert Said(view).legend == {}


def test_zero_is_said_without_a_sign(view):
    assert [words.degrees(angle) for angle in (-1e-9, 0.0, 4.3e-16, -0.5, np.pi)] == [
        "0.00", "0.00", "0.00", "-28.65", "180.00"
    ]  # fmt: skip
    q = np.array([0.0, 0.5, 0.0, 1.2, 0.0, 0.5, 0.0])
    message = view.arm.solve(view.arm.forward_kinematics(q), seed=q).message
    assert "arm angle 0 rad" in message


def test_a_saved_page_holds_no_secret(view, tmp_path):
    secret = view.url.rstrip("/").rpartition("/")[2]
    assert len(secret) == 32
    assert secret not in view.save(tmp_path / "scene.html").read_text()
    assert "127.0.0.1" not in view.html()


@pytest.mark.parametrize("name", zoo.robots())
def test_the_camera_sees_all_that_is_shown(name):
    """In a view of 75 degrees, as wide as high; also once something far away is shown."""
    arm = srs_ik.load(name)
    far = arm.forward_kinematics(np.zeros(7)).homogeneous
    far[:3, 3] += 2.5
    with Preview(arm) as view:
        spans = []
        for show in (lambda: None, lambda: view.show_target(far), lambda: view.show(np.zeros(7))):
            show()
            points = seen(view)
            assert np.degrees(np.arctan(np.abs(points[:, :2] / points[:, 2:]).max())) < 37.5
            spans.append(np.abs(points[:, :2] / points[:, 2:]).max())
            assert (points[:, 2] > 0.0).all()
        # It is not lost in a corner of the picture either.
        assert spans[0] > 0.35


def seen(view) -> np.ndarray:
    """All that is drawn in the frame of the camera: to the right, upwards, and away from it."""
    tree, scene = view._window._bridge.tree, Scene(view)
    points = np.concatenate([*scene.solids("robot"), *scene.solids("limb"), *scene.vertices("elbow circle")])
    if "target" in scene.names():
        T = scene.transform("target")
        points = np.concatenate([points, np.concatenate(scene.vertices("target")) @ T[:3, :3].T + T[:3, 3]])
    T = np.array(umsgpack.unpackb(find_node(tree, ["meshcat"]).transform)["matrix"], dtype=float).reshape(4, 4).T
    x, z, minus_y = umsgpack.unpackb(find_node(tree, ["Cameras", "default", "rotated", "<object>"]).properties[-1])[
        "value"
    ]
    eye = np.array([x, -minus_y, z])
    away = -eye / np.linalg.norm(eye)
    right = np.cross(away, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    return (points @ T[:3, :3].T + T[:3, 3] - eye) @ np.array([right, np.cross(right, away), away]).T


def test_other_limbs_are_shown_without_meshes():
    """Two legs and a head, as rods along the joints that carry them."""
    places = {"hip_l": "0 .1 -.1", "knee_l": "0 0 -.4", "hip_r": "0 -.1 -.1", "knee_r": "0 0 -.4", "head": "0 0 .5"}
    carriers = {"hip_l": "l0", "knee_l": "hip_l", "hip_r": "l0", "knee_r": "hip_r", "head": "l0"}
    moving = '<axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/>'
    limbs = [
        joint_xml(f"to_{link}", carriers[link], link, inside=f'<origin xyz="{at}"/>{moving}')
        for link, at in places.items()
    ]
    arm = srs_ik.load(robot_xml(serial_arm(), *limbs, links=" ".join(places)), base="l0", tip="l7")
    with Preview(arm) as view:
        still = np.concatenate(Scene(view).solids("robot", [0]))
    for end in ([0, 0.1, -0.5], [0, -0.1, -0.5], [0, 0, 0.5]):
        assert np.linalg.norm(still - end, axis=1).min() < 0.03
    assert still[:, 2].min() > -0.53


def test_force_has_one_colour_in_all_pictures():
    figure = pytest.importorskip("srs_ik.plots.figure")
    assert to_hex(palette.FORCE) == figure.FORCE
