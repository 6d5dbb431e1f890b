"""Pictures show the figures: what is drawn is read back from the axes, and checked apart from the drawing."""

import re
import sys

import arms
import numpy as np
import pytest
from command_line import POSE, Q, run
from oracles import inside, random_limb
from tip import STRETCHED

import srs_ik

pytest.importorskip("matplotlib")
from matplotlib.colors import to_rgb

from srs_ik.errors import install_command
from srs_ik.plots import solids
from srs_ik.plots.figure import FORCE, VELOCITY
from srs_ik.plots.intervals import bars

ANGLES = np.array([float(q) for q in Q])


def drawn(axes) -> tuple[np.ndarray, np.ndarray]:
    """Corners (n, 4, 3) of the patches in space, and whether each is see-through, as the ellipsoid is."""
    (body,) = axes.collections
    return np.array(body._faces).reshape(-1, 4, 3), np.asarray(body._facecolor3d)[:, 3] < 1.0


@pytest.mark.parametrize("name", arms.here("iiwa14", "gen3", "human_arm", "openarm_left"))
def test_the_drawn_arm_goes_through_its_centres(name):
    arm, forward = arms.load(name), arms.forward(name)
    for q in arms.configurations(name, 5, salt=20):
        shape = solids.skeleton(arm, q)
        limb = arm.limb
        expected = [
            np.zeros(3),
            limb.shoulder,
            forward.carried(q, 3, limb.elbow),
            forward.carried(q, 5, limb.wrist),
            forward(q).translation,
        ]
        assert np.allclose(shape.line, expected, rtol=0.0, atol=1e-12)
        for joint in range(7):
            # A joint leaves the points of its own axis where they are.
            turned = q.copy()
            turned[joint] += 0.7
            again = solids.skeleton(arm, turned)
            assert np.allclose(again.points[joint], shape.points[joint], rtol=0.0, atol=1e-12)
            assert np.allclose(again.axes[joint], shape.axes[joint], rtol=0.0, atol=1e-12)


def test_solids_are_closed_and_turn_outwards():
    tube = solids.tube(np.array([0.1, 0.2, 0.3]), np.array([0.5, -0.1, 0.4]), 0.05)
    ball = solids.ellipsoid(np.array([1.0, 2.0, 3.0]), np.diag([0.3, 0.2, 0.1]))
    for patches, volume in ((tube, np.pi * 0.05**2 * np.linalg.norm([0.4, 0.3, 0.1])), (ball, 4 / 3 * np.pi * 0.006)):
        a, b, c, d = (patches[:, k] for k in range(4))
        halves = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
        signed = np.einsum("ij,ij->i", halves[:, 0], np.cross(halves[:, 1], halves[:, 2])).sum() / 6.0
        # A little less than the round solid, and positive only if every patch turns outwards.
        assert 0.96 * volume < signed < volume


@pytest.mark.parametrize("part", ["linear", "angular"])
def test_the_drawn_ellipsoids_are_at_the_tip_and_to_their_scale(part):
    arm = arms.load("iiwa14")
    figure = srs_ik.plots.plot_ellipsoids(arm, ANGLES, limits=True, part=part)
    tip, J = arm.forward_kinematics(ANGLES).translation, arm.jacobian(ANGLES)
    expected = (
        srs_ik.velocity_ellipsoid(J, arm.velocity_limit, part),
        srs_ik.force_ellipsoid(J, arm.effort_limit, part),
    )
    for axes, ellipsoid, colour in zip(figure.axes, expected, (VELOCITY, FORCE), strict=True):
        patches, clear = drawn(axes)
        points = patches[clear].reshape(-1, 3) - tip
        size = ellipsoid.radii / ellipsoid.radii.max() * 0.35 * (arm.limb.upper_arm + arm.limb.forearm)
        assert np.allclose(np.linalg.norm(points @ ellipsoid.axes / size, axis=1), 1.0)
        assert np.argmax(to_rgb(colour)) == np.argmax(axes.collections[0]._facecolor3d[clear][:, :3].mean(axis=0))
        assert f"{ellipsoid.radii[0]:.3g}" in axes.get_title()
        assert ellipsoid.unit in axes.get_title()
        assert [axes.get_xlabel(), axes.get_ylabel(), axes.get_zlabel()] == ["x (m)", "y (m)", "z (m)"]
        limits = np.array([axes.get_xlim(), axes.get_ylim(), axes.get_zlim()])
        assert (patches.reshape(-1, 3) > limits[:, 0] - 1e-9).all()
        assert (patches.reshape(-1, 3) < limits[:, 1] + 1e-9).all()


def test_singular_ellipsoids_are_drawn_flat_and_with_a_dashed_line():
    arm = arms.load("iiwa14")
    velocity, force = srs_ik.plots.plot_ellipsoids(arm, STRETCHED).axes
    assert "flat" in velocity.get_title()
    assert "unbounded" in force.get_title()
    assert "∞" in force.get_title()
    tip = arm.forward_kinematics(STRETCHED).translation
    line = tip - arm.limb.shoulder
    patches, clear = drawn(velocity)
    assert np.abs((patches[clear] - tip) @ line / np.linalg.norm(line)).max() < 1e-2
    assert len(velocity.lines) == 0
    (dashed,) = force.lines
    ends = np.array(dashed.get_data_3d()).T
    assert np.allclose(np.cross(ends[1] - ends[0], line), 0.0, atol=1e-9)


@pytest.mark.parametrize(("name", "branch"), [("iiwa14", None), ("iiwa14", 2), ("gen3", None)])
def test_lines_against_the_arm_angle_are_postures_at_the_pose(name, branch):
    arm, forward = arms.load(name), arms.forward(name)
    pose = forward(ANGLES)
    figure = srs_ik.plots.plot_arm_angle(arm, pose, branch)
    top, middle, bottom = figure.axes
    assert [line.get_label() for line in top.lines] == list(arm.joint_names)
    psi = middle.lines[0].get_xdata()
    assert psi[0] == -180.0
    assert psi[-1] == 180.0
    # The lines of joint angles have gaps where an angle passes half a turn: read by arm angle, not by place.
    angles = [dict(zip(*line.get_data(), strict=True)) for line in top.lines]
    chosen = arm.solve(pose).branch if branch is None else branch
    assert f"branch {chosen}" in top.get_title()
    limited = np.isfinite(arm.lower) & np.isfinite(arm.upper)
    lower, upper = arm.lower[limited], arm.upper[limited]
    for i in range(0, 721, 45):
        q = np.deg2rad([joint[psi[i]] for joint in angles])
        reached = forward(q)
        assert np.allclose(reached.homogeneous, pose.homogeneous, rtol=0.0, atol=1e-9)
        J = arm.jacobian(q)
        assert middle.lines[0].get_ydata()[i] == pytest.approx(np.sqrt(np.linalg.det(J @ J.T)), rel=1e-6)
        margin = 2.0 * np.min(np.minimum(q[limited] - lower, upper - q[limited]) / (upper - lower))
        assert bottom.lines[0].get_ydata()[i] == pytest.approx(margin, abs=1e-9)
        white = any(p.get_x() <= psi[i] <= p.get_x() + p.get_width() for p in bottom.patches)
        assert white == bool(inside(q, arm.lower, arm.upper)) or abs(margin) < 1e-9
    assert (top.get_ylabel(), bottom.get_xlabel()) == ("joint angle (deg)", "arm angle (deg)")


@pytest.mark.parametrize("seed", range(6))
def test_joints_are_drawn_in_the_turn_that_their_limits_leave(seed):
    limb = random_limb(seed, limits="beyond")
    arm = srs_ik.load(limb.model, base="base", tip="tool")
    pose = arm.forward_kinematics(limb.configuration())
    top, _, bottom = srs_ik.plots.plot_arm_angle(arm, pose, arm.solve(pose).branch).axes
    psi, margin = bottom.lines[0].get_data()
    white = np.array([any(p.get_x() <= x <= p.get_x() + p.get_width() for p in bottom.patches) for x in psi])
    assert white.any()
    assert margin[white].min() > -1e-9
    assert np.nanmax(margin[~white], initial=-1.0) < 1e-9
    angles = np.concatenate([line.get_ydata() for line in top.lines])
    assert np.nanmax(np.abs(angles)) <= top.get_ylim()[1]


def test_where_nothing_reaches_the_panels_are_empty():
    arm = arms.load("iiwa14")
    far = np.eye(4)
    far[0, 3] = 5.0
    top, middle, _ = srs_ik.plots.plot_arm_angle(arm, far).axes
    assert all(np.isnan(line.get_ydata()).all() for line in (*top.lines, *middle.lines))
    (intervals,) = srs_ik.plots.plot_intervals(arm, far).axes
    (yaws,) = srs_ik.plots.plot_yaw_arcs(arm, far).axes
    for axes in (top, intervals, yaws):
        assert axes.get_title().startswith("iiwa14: UNREACHABLE")
    # Postures reach this one, but none inside the limits.
    beyond = arm.forward_kinematics([0.0, 0.0, 0.0, arm.lower[3] - 0.1, 0.0, 0.0, 0.0])
    assert srs_ik.plots.plot_intervals(arm, beyond).axes[0].get_title().startswith("iiwa14: OUT_OF_LIMITS")
    assert "meets the pose" in srs_ik.plots.plot_intervals(arm, beyond, respect_limits=False).axes[0].get_title()


def test_wrong_input_is_named():
    arm = arms.load("iiwa14")
    with pytest.raises(srs_ik.InvalidTask, match="'full'"):
        srs_ik.plots.plot_ellipsoids(arm, ANGLES, part="full")
    with pytest.raises(srs_ik.InvalidConfiguration):
        srs_ik.plots.plot_ellipsoids(arm, ANGLES[:6])
    with pytest.raises(srs_ik.InvalidConfiguration):
        srs_ik.plots.plot_arm_angle(arm, arm.forward_kinematics(ANGLES), branch=8)
    with pytest.raises(srs_ik.MissingLimits):
        srs_ik.plots.plot_ellipsoids(arms.load("human_arm"), ANGLES, limits=True)


def test_a_path_is_drawn_over_its_own_poses():
    arm = arms.load("iiwa14")
    pose = arm.forward_kinematics(ANGLES)
    path = arm.solve_path([pose, pose], seed=ANGLES)
    assert srs_ik.plots.plot_path(arm, [pose, pose], path)
    for poses in ([pose] * 7, [pose], []):
        with pytest.raises(srs_ik.InvalidPose, match=f"over its own poses: it has 2, and {len(poses)} are given"):
            srs_ik.plots.plot_path(arm, poses, path)
    for wrong in (path.q, None, 3):
        with pytest.raises(srs_ik.InvalidConfiguration, match=r"a path is what Arm\.solve_path gives"):
            srs_ik.plots.plot_path(arm, [pose, pose], wrong)


def test_without_matplotlib_the_pip_command_is_given(monkeypatch):
    monkeypatch.delitem(sys.modules, "srs_ik.plots.picture", raising=False)
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(srs_ik.MissingExtra, match=re.escape(install_command("plot"))):
        srs_ik.plots.plot_ellipsoids(arms.load("iiwa14"), ANGLES)


# srs-ik plot


@pytest.mark.parametrize(
    "words",
    [
        ["ellipsoids", "iiwa14", "--q", *Q],
        ["ellipsoids", "iiwa14", *POSE, "--part", "angular", "--limits"],
        ["arm-angle", "iiwa14", *POSE, "--branch", "0"],
        ["intervals", "gen3", "--q", *Q],
    ],
)
def test_the_command_writes_a_picture_with_something_in_it(words, tmp_path):
    from matplotlib import image

    path = tmp_path / "picture.png"
    result = run("plot", *words, "--output", str(path))
    assert result.exit_code == 0, result.stderr or result.exception
    assert result.stdout == result.stderr == ""
    pixels = image.imread(path)[..., :3]
    assert 0.02 < (pixels.min(axis=2) < 0.9).mean() < 0.95


@pytest.mark.parametrize("kind", ["ellipsoids", "arm-angle", "intervals"])
def test_a_pose_out_of_reach_is_exit_status_1_with_one_line(kind, tmp_path):
    path = tmp_path / "none.png"
    result = run("plot", kind, "iiwa14", "--xyz", "5", "0", "0", "--rpy", "0", "0", "0", "--output", str(path))
    assert result.exit_code == 1
    assert result.stderr.count("\n") == 1
    assert not path.exists()


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["ellipsoids", "iiwa14", "--q", *Q], "--output FILE.png"),
        (["ellipsoids", "iiwa14", "--output", "a.png"], "--xyz"),
        (["shadow", "iiwa14", "--q", *Q, "--output", "a.png"], "shadow"),
        (["intervals", "iiwa14", "--q", *Q, "--output", "a.colour"], "a.colour"),
        (["intervals", "iiwa14", "--q", *Q, "--output", "no/such/folder/a.png"], "no/such/folder"),
        (["arm-angle", "iiwa14", "--q", *Q, "--output", "a.png", "--branch", "9"], "not 9"),
        (["intervals", "iiwa14", "--q", *Q, "--output", "a.png", "--branch", "2"], "--branch is of 'arm-angle'"),
        (["arm-angle", "iiwa14", "--q", *Q, "--output", "a.png", "--part", "linear"], "--part is of 'ellipsoids'"),
        (["intervals", "iiwa14", "--q", *Q, "--output", "a.png", "--limits"], "--limits is of 'ellipsoids'"),
        (
            ["ellipsoids", "iiwa14", "--q", *Q, "--output", "a.png", "--part", "full"],
            "'full' is not one of 'linear', 'angular'",
        ),
        (
            ["ellipsoids", "human_arm", "--q", *Q, "--output", "a.png", "--limits"],
            "velocity limit for shoulder_yaw",
        ),
    ],
)
def test_wrong_words_are_one_line_and_exit_status_2(words, named):
    result = run("plot", *words)
    assert result.exit_code == 2, result.exception
    assert "Value error" not in result.stderr
    assert result.stdout == ""
    assert result.stderr.count("\n") == 1
    assert named in result.stderr


def test_a_pose_that_a_path_does_not_meet_is_no_point_of_the_path():
    arm = arms.load("iiwa14")
    pose, far = arm.forward_kinematics(ANGLES).homogeneous, np.eye(4)
    far[0, 3] = 5.0
    path = arm.solve_path([pose, far, pose], seed=ANGLES)
    figure = srs_ik.plots.plot_path(arm, [pose, far, pose], path)
    for axes in figure.axes:
        lines = [line for line in axes.lines if line.get_color() == FORCE]
        assert not any(np.isfinite(y) and x == 1 for line in lines for x, y in zip(*line.get_data(), strict=True))
        assert any(list(line.get_xdata()) == [1, 1] and line.get_color() != FORCE for line in axes.lines)
        assert all(float(tick).is_integer() for tick in axes.get_xticks())


def test_angular_ellipsoids_are_called_what_their_units_say():
    panels = srs_ik.plots.plot_ellipsoids(arms.load("iiwa14"), ANGLES, part="angular").axes
    assert [axes.get_title().split(" ellipsoid")[0] for axes in panels] == ["angular velocity", "moment"]


def test_in_a_scene_the_pictures_show_the_arm_angles_that_hit_nothing(tmp_path):
    arm, scene = arms.load("iiwa14"), srs_ik.Scene()
    scene.add_sphere("ball", [0.2, 0.35, 0.6], 0.1)
    pose = arm.forward_kinematics(ANGLES)
    free = arm.intervals(pose, scene=scene, margin=0.01)
    assert 0.1 < sum(each.width for each in free) < 0.95 * sum(each.width for each in arm.intervals(pose))
    (axes,) = srs_ik.plots.plot_intervals(arm, pose, scene=scene, margin=0.01).axes
    drawn = [[path.get_extents().x0 for path in each.get_paths()] for each in axes.collections[1::2]]
    assert drawn == [pytest.approx([start for start, _ in pieces]) for pieces in bars(free)]
    path = arm.solve_path([pose, pose], scene=scene, margin=0.01)
    strips = srs_ik.plots.plot_path(arm, [pose, pose], path, scene=scene, margin=0.01)
    width = sum(bar.get_height() for axes in strips.axes for bar in axes.patches)
    assert width == pytest.approx(2.0 * np.degrees(sum(each.width for each in free)))
    file = tmp_path / "scene.json"
    file.write_text('{"margin": 0.01, "objects": [{"name": "ball", "sphere": 0.1, "xyz": [0.2, 0.35, 0.6]}]}')
    words = "intervals", "iiwa14", "--q", *map(str, ANGLES), "--plot"
    assert run(*words, str(tmp_path / "all.svg")).exit_code == 0
    assert run(*words, str(tmp_path / "free.svg"), "--scene", str(file)).exit_code == 0
    everything, clear = ((tmp_path / name).read_text() for name in ("all.svg", "free.svg"))
    assert len(clear) != len(everything)


def test_a_path_that_chose_its_turns_is_in_the_strips_of_its_picture():
    arm = arms.load("iiwa14")
    # As they are given, the hand points back at the arm, and no posture inside the limits meets them.
    poses = srs_ik.pose_from_xyz_rpy([[0.5, 0.1 + 0.02 * k, 0.6] for k in range(4)], [[0.0, np.pi, 0.0]] * 4)
    assert not arm.reachable_batch(poses).any()
    path = arm.solve_path(poses, free_axis="any")
    assert path
    panels = srs_ik.plots.plot_path(arm, poses, path).axes
    for k in range(4):
        axes = next(axes for axes in panels if axes.get_title() == f"branch {path.branch[k]}")
        strips = [bar for bar in axes.patches if abs(bar.get_x() + 0.5 * bar.get_width() - k) < 0.1]
        angle = np.degrees(path.arm_angle[k])
        assert any(bar.get_y() - 1e-6 <= angle <= bar.get_y() + bar.get_height() + 1e-6 for bar in strips)
