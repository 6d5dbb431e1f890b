"""Maps: arcs of yaw against turned poses, cells against Pinocchio, volumes against closed forms; stores and exports."""

import base64
import json
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ET

import arms
import numpy as np
import pinocchio as pin
import pytest
from oracles import random_limb

import srs_ik
from srs_ik.maps import (
    build_map,
    cloud,
    combine,
    compare,
    estimate,
    measures_of,
    open_map,
    to_numpy,
    to_reuleaux,
    to_vtk,
    yaw_arcs,
)
from srs_ik.maps.plan import YAW
from srs_ik.maps.tasks import in_base, job_of, run_task
from srs_ik.robot import changes

pytest.importorskip("zarr")

TURN = 2.0 * np.pi


def limited(arm, **limits):
    """The arm with other limits, joint_k=(lower, upper)."""
    given = {arm.joint_names[int(k[-1]) - 1]: {"lower": a, "upper": b} for k, (a, b) in limits.items()}
    return arm._again(changes.within_limits(arm._chain, given), arm.limb.reference, arm.hand)


def about_axis_1(arm, T, yaw):
    """A pose turned about the axis of joint 1."""
    R, point = pin.exp3(arm.limb.axes[0] * yaw), arm.limb.points[0]
    turned = np.eye(4)
    turned[:3, :3], turned[:3, 3] = R @ T[:3, :3], point + R @ (T[:3, 3] - point)
    return turned


def is_in(arcs, yaw, room=0.0):
    return bool(((yaw - arcs[:, 0] + room) % TURN <= arcs[:, 1] + 2.0 * room).any())


def check_arcs(arm, poses, rng):
    """Every pose is in its arcs, turned or not; inside an arc it is reached, outside it is not."""
    arcs = yaw_arcs(arm, poses)
    yaws = rng.uniform(-np.pi, np.pi, len(poses))
    for each, pose in zip(arcs, poses, strict=True):
        assert is_in(each, 0.0, 1e-9), (each, pose)
    # So close to an end, rounding decides.
    clear = [is_in(a, y, 1e-7) == is_in(a, y, -1e-7) for a, y in zip(arcs, yaws, strict=True)]
    assert np.mean(clear) > 0.99
    reached = arm.reachable_batch([about_axis_1(arm, T, y) for T, y in zip(poses, yaws, strict=True)])
    inside = [is_in(a, y) for a, y in zip(arcs, yaws, strict=True)]
    np.testing.assert_array_equal(np.array(inside)[clear], reached[clear])
    return np.mean([a[:, 1].sum() for a in arcs]) / TURN


@pytest.mark.parametrize("name", arms.EXACT)
def test_arcs_of_yaw_are_those_of_turned_poses(name):
    forward, rng = arms.forward(name), arms.generator(name, 30)
    check_arcs(arms.load(name), [forward(q).homogeneous for q in arms.configurations(name, 300, 31)], rng)


@pytest.mark.parametrize(("lower", "upper"), [(-0.3, 0.5), (1.0, 1.6), (-9.0, -2.0), (-2.0, 9.0)])
def test_arcs_of_yaw_follow_the_limits_of_joint_1(lower, upper):
    arm = limited(srs_ik.load("iiwa14"), joint_1=(lower, upper))
    arm = arm.with_tool(srs_ik.pose_from_xyz_rpy([0.1, 0.05, 0.2], [0.4, 1.0, -0.3]))
    arm = arm.with_base(srs_ik.pose_from_xyz_rpy([0.4, -0.3, 0.9], [0.2, 2.0, 0.7]))
    rng = np.random.default_rng(32)
    Q = rng.uniform(arm.lower, arm.upper, (400, 7))
    covered = check_arcs(arm, [arm.forward_kinematics(q).homogeneous for q in Q], rng)
    assert covered < 1.0 or upper - lower > TURN


ALMOST_STRAIGHT = [-2.01506443, 0.63066242, -0.17583778, -0.00377648, -1.24705197, 1.36350753, -1.88393722]


@pytest.mark.parametrize("room", [0.0, 1e-6, 0.3, np.inf])
def test_a_pose_that_the_curves_from_the_closed_form_pass_by_is_in_its_arcs(room):
    """Of gen3, its elbow almost straight: one of 10^5 random ones. Joint 1 has this much room on either side."""
    q1 = ALMOST_STRAIGHT[0]
    arm = srs_ik.load("gen3")
    if room < np.inf:
        arm = limited(arm, joint_1=(q1 - max(room, 0.5), q1 + room))
    T = arm.forward_kinematics(ALMOST_STRAIGHT).homogeneous
    assert arm.reachable_batch([T]).all()
    (arcs,) = yaw_arcs(arm, [T])
    assert is_in(arcs, 0.0, 1e-9)
    found = measures_of(arm, [T])
    if room > 0.1:
        # All around this arm angle it is reached, as single solutions tell.
        psi = arm.solve(T, seed=ALMOST_STRAIGHT).arm_angle
        assert all(arm.solve(T, arm_angle=psi + step) for step in (-0.01, 0.01))
        assert found["widest"][0] > 0.02


@pytest.mark.parametrize("name", ["made_near", "gen3"])
def test_arcs_of_yaw_of_near_arms(name):
    arm, rng = limited(arms.load(name), joint_1=(-1.0, 1.5)), arms.generator(name, 33)
    Q = rng.uniform(np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi), (15, 7))
    assert check_arcs(arm, [arm.forward_kinematics(q).homogeneous for q in Q], rng) < 1.0


@pytest.mark.parametrize("seed", range(12))
def test_arcs_of_yaw_of_any_axes_and_limits(seed):
    case = random_limb(seed, pattern=("coordinate", "tilted", "oblique")[seed % 3], limits="usual")
    arm = srs_ik.load(case.model, base="base", tip="tool")
    check_arcs(arm, [arm.forward_kinematics(case.configuration()).homogeneous for _ in range(60)], case.rng)


def test_arcs_of_yaw_at_a_singular_shoulder_hold_every_split():
    # With joint 2 at zero only the sum of joints 1 and 3 counts, so the arc holds the ranges of both.
    arm = limited(srs_ik.load("iiwa14"), joint_1=(-0.4, 0.4), joint_3=(-0.5, 0.7))
    for q in ([0.1, 0.0, 0.3, -1.2, 0.4, 0.8, 0.2], [-0.4, 0.0, -0.5, 1.3, -0.4, 0.5, 0.1]):
        T = arm.forward_kinematics(q).homogeneous
        (arcs,) = yaw_arcs(arm, [T])
        for q1 in (-0.4, 0.0, 0.4):
            for q3 in (-0.5, 0.1, 0.7):
                assert is_in(arcs, q1 + q3 - q[0] - q[2], 1e-9)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A coarse map of an arm whose joint 1 is limited, and the arm."""
    arm = limited(srs_ik.load("iiwa14"), joint_1=(-1.5, 1.0))
    path = tmp_path_factory.mktemp("maps") / "half.zarr"
    return build_map(arm, 0.15, path, orientations=144, measures=["margin"]), arm


@pytest.mark.slow
def test_cells_are_what_the_arm_answers_at_their_poses(made):
    chart, arm = made
    rng, plan = np.random.default_rng(34), chart.plan
    rotations = in_base(plan).reshape(-1, 3, 3)
    values = {name: chart.measure(name) for name in chart.store.names}
    free = limited(arm, joint_1=(-np.inf, np.inf))
    worst, empty = 0.0, 0
    for _ in range(300):
        at = tuple(int(rng.integers(n)) for n in values["reached"].shape)
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = rotations[at[-1]], plan.grid.points([slice(i, i + 1) for i in at[:-1]])[0]
        intervals = free.intervals(T)
        assert values["pieces"][at] == len(intervals)
        assert values["branches"][at] == sum(1 << b for b in {i.branch for i in intervals})
        assert values["width"][at] == pytest.approx(sum(i.width for i in intervals), rel=1e-6)
        assert values["widest"][at] == pytest.approx(max((i.width for i in intervals), default=0.0), rel=1e-6)
        arcs = values[YAW][at]
        for start, width in arcs[arcs[:, 1] > 0.0]:
            for share in (1e-6, 0.5, 1.0 - 1e-6):
                turned = about_axis_1(arm, T, start + share * width)
                solution = arm.solve(turned)
                assert solution
                worst = max(worst, *arm.verify(turned, solution.q))
        if not len(intervals):
            empty += 1
            assert not any(arm.solve(about_axis_1(arm, T, yaw)) for yaw in (-2.0, 0.0, 2.0))
    assert worst < 1e-9
    assert 20 < empty < 280


def test_no_configuration_is_missed_by_an_exact_query_nor_far_from_a_reached_cell(made):
    chart, arm = made
    Q = np.random.default_rng(35).uniform(arm.lower, arm.upper, (500, 7))
    poses = np.array([arm.forward_kinematics(q).homogeneous for q in Q])
    assert chart.query(poses, exact=True).reached.all()
    rough = chart.query(poses)
    assert rough.inside.all()
    assert rough.reached.mean() > 0.6  # cells of 0.15 m and half a radian
    assert (rough.measures["width"][~rough.reached] == 0.0).all()


def test_a_box_says_what_the_half_plane_says(made, tmp_path):
    _, arm = made
    chart = build_map(arm, 0.2, tmp_path / "box.zarr", orientations=72, box=[[0.1, 0.7], [-0.5, 0.4], [0.2, 0.9]])
    assert chart.plan.grid.shape == (4, 5, 4)
    points = chart.plan.grid.points([slice(0, n) for n in chart.plan.grid.shape])
    T = np.tile(np.eye(4), (len(points), 72, 1, 1))
    T[..., :3, 3], T[..., :3, :3] = points[:, None], in_base(chart.plan).reshape(-1, 3, 3)
    reached = chart.measure("reached").ravel() > 0
    assert 0.05 < reached.mean() < 0.95
    expected = [is_in(arcs, 0.0) if len(arcs) else False for arcs in yaw_arcs(arm, T.reshape(-1, 4, 4))]
    np.testing.assert_array_equal(reached, expected)


def test_the_shell_of_an_elbow_alone_has_its_volume(tmp_path):
    arm = srs_ik.load("iiwa14")
    arm = limited(arm, **{f"joint_{k}": (-np.inf, np.inf) for k in (1, 2, 3, 5, 6, 7)}, joint_4=(-1.9, 1.2))
    wrist = np.linalg.inv(arm.limb.T_base_tip_zero) @ np.append(arm.limb.wrist, 1.0)
    arm = arm.with_tool(srs_ik.pose_from_xyz_rpy(wrist[:3], [0.0, 0.0, 0.0]))
    a, b = arm.limb.upper_arm, arm.limb.forearm
    inner = np.sqrt(a * a + b * b + 2.0 * a * b * np.cos(1.9))
    exact = 4.0 / 3.0 * np.pi * ((a + b) ** 3 - inner**3)
    for step in (0.1, 0.05, 0.025, 0.0125):
        chart = build_map(arm, step, tmp_path / f"{step}.zarr", orientations=12)
        rho = chart.plan.grid.centres(0)
        volume = (chart.mean("reached") * TURN * rho[:, None] * step**2).sum()
        # Cells at the two edges are counted in or out by chance, so the error falls faster than the step.
        assert abs(volume / exact - 1.0) < 2.0 * step**1.5
        assert np.isin(chart.mean("reached"), [0.0, 1.0]).all()


def test_an_unlimited_joint_1_has_whole_circles():
    arm = srs_ik.load("gen3")
    (arcs,) = yaw_arcs(arm, [arm.forward_kinematics(np.full(7, 0.5))])
    np.testing.assert_allclose(arcs, [[-np.pi, TURN]])


def test_a_checked_map_is_right_and_a_damaged_one_is_not(made, tmp_path):
    chart, arm = made
    found = chart.verify(400)
    assert found
    assert found.cells == 400
    assert found.rebuilt > 50
    copy = tmp_path / "copy.zarr"
    shutil.copytree(chart.path, copy)
    chunk = max((copy / "width" / "c").rglob("*"), key=lambda p: p.stat().st_size if p.is_file() else -1)
    data = bytearray(chunk.read_bytes())
    data[len(data) // 2] ^= 0xFF
    chunk.write_bytes(bytes(data))
    again = open_map(copy, arm).verify(100) if _readable(copy, arm) else None
    assert again is None or (not again and again.damaged)


def _readable(path, arm):
    try:
        open_map(path, arm).measure("width")
    except Exception:
        return False
    return True


def test_a_store_of_another_robot_is_refused(made):
    chart, arm = made
    other = arm.with_tool(srs_ik.pose_from_xyz_rpy([0.0, 0.0, 0.01], [0.0, 0.0, 0.0]))
    with pytest.raises(srs_ik.InvalidMap, match="another robot"):
        open_map(chart.path, other)
    with pytest.raises(srs_ik.InvalidMap, match="map of another robot"):
        build_map(other, 0.15, chart.path, orientations=144, measures=["margin"])
    with pytest.raises(srs_ik.InvalidMap, match=r"another grid \(step 0\.15, not 0\.2; .*shape \["):
        build_map(arm, 0.2, chart.path, orientations=144, measures=["margin"])
    with pytest.raises(srs_ik.InvalidMap, match="with other measures: give"):
        build_map(arm, 0.15, chart.path, orientations=144)
    with pytest.raises(srs_ik.InvalidMap, match="holds no map"):
        open_map(chart.path.parent)
    with pytest.raises(srs_ik.InvalidMap, match="did you mean 'margin'"):
        build_map(arm, 0.2, "x.zarr", measures=["margins"])
    with pytest.raises(srs_ik.InvalidMap, match="step of a map"):
        build_map(arm, 0.0, "x.zarr")
    for wrong in ([[-1, -1, 0], [1, 1, 1]], [[1, -1], [-1, 1], [0, 1]], "all"):
        with pytest.raises(srs_ik.InvalidMap, match=r"\(3, 2\) metres: rows of x, y and z, each a lower and an upper"):
            build_map(arm, 0.2, "x.zarr", box=wrong)


@pytest.mark.parametrize("where", ["/proc/map.zarr", "a file/map.zarr"])
def test_where_no_map_can_be_written_one_clear_error_says_so(where, tmp_path):
    (tmp_path / "a file").touch()
    path = tmp_path / where
    with pytest.raises(srs_ik.InvalidMap, match=r"map\.zarr cannot be written: [^']*$"):
        build_map(arms.load("iiwa14"), 0.4, path, orientations=12)


def test_maps_of_two_tools_are_compared_and_of_two_places_combined(made, tmp_path):
    _, arm = made
    box = [[-0.3, 0.6], [-0.6, 0.6], [0.2, 0.8]]
    moved = arm.with_base(srs_ik.pose_from_xyz_rpy([0.1, 0.2, 0.0], [0.0, 0.0, 1.0]))
    a = build_map(arm, 0.3, tmp_path / "a.zarr", orientations=72, box=box)
    b = build_map(moved, 0.3, tmp_path / "b.zarr", orientations=72, box=box)
    first, second = a.measure("reached") > 0, b.measure("reached") > 0
    found = compare(a, b)
    assert found.both == pytest.approx((first & second).mean())
    assert found.first == pytest.approx((first & ~second).mean())
    assert found.second == pytest.approx((second & ~first).mean())
    with pytest.warns(
        UserWarning, match="given in 'iiwa_link_0', those of .* in 'world', and are taken as in one frame"
    ):
        both = combine(a, b, tmp_path / "both.zarr")
    assert both.plan.robot["base"] == "iiwa_link_0, world"
    np.testing.assert_array_equal(both.measure("reached") > 0, first | second)
    np.testing.assert_array_equal(both.measure("width"), np.maximum(a.measure("width"), b.measure("width")))


def test_two_arms_reach_what_either_does_though_joints_that_are_held_leave_no_width(tmp_path):
    """And the larger margin and manipulability are theirs."""
    arm = arms.load("iiwa14")
    # Coarse, yet each arm reaches some cells that the other does not.
    of = {"orientations": 12, "box": [[-0.9, 0.9], [-0.9, 0.9], [0.0, 1.2]], "measures": ["margin", "manipulability"]}
    a = build_map(limited(arm, joint_3=(-0.4, -0.4)), 0.3, tmp_path / "a.zarr", **of)
    b = build_map(limited(arm, joint_1=(2.0, 2.0)), 0.3, tmp_path / "b.zarr", **of)
    first, second = a.measure("reached") > 0, b.measure("reached") > 0
    assert not a.measure("width").any()
    assert (second & ~first).any()
    assert (first & ~second).any()
    both = combine(a, b, tmp_path / "both.zarr")
    assert both.plan.robot["base"] == "iiwa_link_0"
    np.testing.assert_array_equal(both.measure("reached") > 0, first | second)
    for name in ("widest", "margin", "manipulability"):
        np.testing.assert_array_equal(both.measure(name), np.maximum(a.measure(name), b.measure(name)))


def test_exports_hold_what_the_map_holds(made, tmp_path):
    chart, _ = made
    to_numpy(chart, tmp_path / "m.npz")
    with np.load(tmp_path / "m.npz") as arrays:
        np.testing.assert_array_equal(arrays["width"], chart.measure("width"))
    points, share = cloud(chart)
    assert (share > 0.0).all()
    to_vtk(chart, tmp_path / "m.vti")
    image = ET.parse(tmp_path / "m.vti").getroot().find("ImageData")
    shape = [int(n) + 1 for n in image.get("WholeExtent").split()[1::2]]
    data = base64.b64decode(image.find(".//DataArray").text)
    assert int(np.frombuffer(data[:8], "<u8")[0]) == len(data) - 8
    values = np.frombuffer(data[8:], "<f4").reshape(shape[::-1])
    origin, spacing = ([float(x) for x in image.get(k).split()] for k in ("Origin", "Spacing"))
    for point, value in zip(points[::50], share[::50], strict=True):
        x, y, z = np.rint((point - origin) / spacing).astype(int)
        assert values[z, y, x] == pytest.approx(value, abs=1e-6)


def test_a_map_is_written_to_no_folder_that_is_not_there(made, tmp_path):
    pytest.importorskip("h5py")
    chart, _ = made
    for write, name in ((to_numpy, "m.npz"), (to_vtk, "m.vti"), (to_reuleaux, "m.h5")):
        with pytest.raises(srs_ik.InvalidMap, match=f"{name} cannot be written: there is no folder"):
            write(chart, tmp_path / "none" / name, *([0.5] if write is to_reuleaux else []))


def test_answers_of_maps_are_told_in_a_line(made):
    chart, _ = made
    found = chart.query(np.tile(np.eye(4), (200, 1, 1)))
    assert repr(found) == f"MapAnswer(200 poses, 0 reached, measures {', '.join(chart.plan.measures)})"
    assert repr(compare(chart, chart)).startswith("Compared(both=0.")
    assert len(repr(compare(chart, chart))) < 100


def test_candidates_are_ranked_in_a_list_best_first():
    arm = arms.load("iiwa14")
    candidates = [srs_ik.pose_from_xyz_rpy([x, 0.0, 0.0], [0.0, 0.0, 0.0]) for x in (3.0, 0.1)]
    ranked = srs_ik.base_placement(arm, [arm.forward_kinematics([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])], candidates)
    assert ranked[0].candidate == 1
    assert [ranked[k] for k in range(len(ranked))] == list(ranked)
    assert ranked[-1].candidate == 0
    with pytest.raises(IndexError):
        ranked[2]


def test_a_file_of_reuleaux_is_read_as_its_programs_read_it(made, tmp_path):
    # Rows of poses: sphere x y z, then pose x y z qx qy qz qw; of spheres: x y z, and 0 to 100. Both are read as
    # doubles, and poses are looked up by the figures of their sphere.
    h5py = pytest.importorskip("h5py")
    chart, arm = made
    to_reuleaux(chart, tmp_path / "m.h5", step=0.5)
    with h5py.File(tmp_path / "m.h5") as file:
        spheres, poses = file["Spheres/sphere_dataset"], file["Poses/poses_dataset"]
        resolution = spheres.attrs.get_id("Resolution")
        assert resolution.shape == (1,)
        assert resolution.dtype == np.float32
        assert file["Spheres/sphere_dataset"].attrs["Resolution"][0] == pytest.approx(0.5)
        spheres, poses = spheres[...].astype("<f8"), poses[...].astype("<f8")
    assert spheres.shape[1:] == (4,)
    assert poses.shape[1:] == (10,)
    by_sphere = {}
    for row in poses:
        by_sphere.setdefault(tuple(row[:3]), []).append(row[3:])
    assert set(by_sphere) == {tuple(row[:3]) for row in spheres}
    for *centre, index in spheres:
        assert 100.0 * len(by_sphere[tuple(centre)]) / len(chart.plan.orientations) == pytest.approx(index)
    np.testing.assert_allclose(np.linalg.norm(poses[:, 6:], axis=1), 1.0)
    # Positions are those of spheres, not of cells, so a posture is near: within a cell's half diagonal, and a bit.
    reached = [bool(arm.solve(pin.XYZQUATToSE3(row))) for row in poses[:: max(1, len(poses) // 60), 3:]]
    assert np.mean(reached) > 0.8


@pytest.mark.slow
def test_xarray_opens_a_map_as_it_is(made):
    xarray = pytest.importorskip("xarray")
    chart, _ = made
    opened = xarray.open_zarr(chart.path, consolidated=False)
    np.testing.assert_allclose(opened.width.sel(rho=0.2, z=0.1, method="nearest").values, _at(chart, 0.2, 0.1))
    assert json.loads(json.dumps(opened.attrs["srs_ik"]))["robot"]["name"] == "iiwa14"


def _at(chart, rho, z):
    i, j = (int(np.argmin(np.abs(chart.plan.grid.centres(k) - x))) for k, x in enumerate((rho, z)))
    return chart.measure("width")[i, j]


def test_an_estimate_counts_the_cells_that_are_made(made):
    chart, arm = made
    found = estimate(arm, 0.15, orientations=144, measures=["margin"])
    assert found.cells == chart.plan.cells
    assert found.tasks == len(chart.plan.blocks)
    assert 0.0 < found.seconds < 100.0


@pytest.mark.slow
def test_pictures_and_previews_show_the_arcs(made):
    from srs_ik.plots import plot_map, plot_yaw_arcs
    from srs_ik.preview import Preview, show_map, show_yaw_arcs

    chart, arm = made
    pose = arm.forward_kinematics(0.5 * (arm.lower + arm.upper) + 0.1)
    (arcs,) = yaw_arcs(arm, [pose])
    drawn = plot_yaw_arcs(arm, pose).axes[0].patches[1:]
    assert sum(bar.get_width() for bar in drawn) == pytest.approx(arcs[:, 1].sum())
    shown = plot_map(chart, "yaw").axes[0].images[0].get_array()
    assert shown.T.filled(0.0) == pytest.approx(chart.mean("yaw"))
    with pytest.raises(srs_ik.InvalidMap, match="no picture of 'rotation'"):
        plot_map(chart, "rotation")
    with Preview(arm) as view:
        np.testing.assert_array_equal(show_yaw_arcs(view, pose), arcs)
        assert show_map(view, chart, cut=False) == len(cloud(chart)[0])
        assert "turned about axis 1" in view.html()


@pytest.mark.slow
def test_what_is_left_of_a_half_made_map_is_not_inside(tmp_path):
    def stop(done, total):
        if done > 0.4 * total:
            raise KeyboardInterrupt

    arm, path = arms.load("iiwa14"), tmp_path / "map.zarr"
    rest = {"orientations": 12, "box": [[-0.8, 0.8], [-0.8, 0.8], [0.0, 1.2]]}
    with pytest.raises(KeyboardInterrupt):
        build_map(arm, 0.1, path, progress=stop, threads=1, **rest)
    poses = np.array([arm.forward_kinematics(q).homogeneous for q in arms.configurations("iiwa14", 200, 5)])
    half = open_map(path)
    before = half.query(poses)
    whole = build_map(arm, 0.1, path, **rest).query(poses)
    assert 0.0 < before.inside.mean() < whole.inside.mean()
    np.testing.assert_array_equal(before.reached[before.inside], whole.reached[before.inside])
    assert not before.reached[~before.inside].any()
    np.testing.assert_array_equal(half.query(poses).inside, whole.inside)


@pytest.mark.parametrize("step", [0.1, 0.25, 0.2])
def test_a_folder_that_was_removed_takes_another_map_in_the_same_process(step, tmp_path):
    arm, path = srs_ik.load("iiwa14"), tmp_path / "map.zarr"
    first = build_map(arm, 0.2, path, orientations=72)
    job = job_of(arm, first.plan)
    shutil.rmtree(path)
    second = build_map(arm, step, path, orientations=72)
    other = build_map(arm, step, tmp_path / "other.zarr", orientations=72)
    np.testing.assert_array_equal(second.measure("width"), other.measure("width"))
    assert second.verify(50)
    if step != 0.2:
        # What is still at work on the first one leaves the second one alone.
        with pytest.raises(srs_ik.InvalidMap, match="a map with another grid"):
            run_task(job, str(path), 0)
    shutil.rmtree(path)
    with pytest.raises(srs_ik.InvalidMap, match="holds no map"):
        run_task(job, str(path), 0)
    assert not path.exists()


@pytest.mark.parametrize("where", ["half-plane", "box"])
def test_what_is_not_done_counts_as_not_reached_wherever_it_is_read(tmp_path, where):
    """Written but not recorded, as a task is that is killed at its end; every other one here."""
    arm, path = srs_ik.load("iiwa14"), tmp_path / "map.zarr"
    rest = {} if where == "half-plane" else {"box": [[-0.8, 0.8], [-0.8, 0.8], [0.0, 1.2]]}
    whole = build_map(arm, 0.1, path, orientations=72, **rest)
    poses = [arm.forward_kinematics(q).homogeneous for q in arms.configurations("iiwa14", 300, 6)]
    before = {name: whole.measure(name) for name in whole.store.names}
    share, full, shown = whole.mean("reached"), whole.query(poses), len(cloud(whole)[0])
    files = sorted((path / "done" / "c").iterdir(), key=lambda each: int(each.name))
    assert len(files) > 1
    made = np.zeros(whole.plan.grid.shape, bool)
    for file, block in zip(files, whole.plan.blocks, strict=True):
        made[block] = int(file.name) % 2 == 0
        if int(file.name) % 2:
            file.unlink()
    half = open_map(path)
    assert 0.0 < half.done < 1.0
    for name, values in before.items():
        kept = np.where(made.reshape(*made.shape, *(1,) * (values.ndim - made.ndim)), values, 0)
        np.testing.assert_array_equal(half.measure(name), kept)
    np.testing.assert_array_equal(half.mean("reached"), np.where(made, share, 0.0))
    to_numpy(half, tmp_path / "half.npz")
    with np.load(tmp_path / "half.npz") as arrays:
        np.testing.assert_array_equal(arrays["reached"], half.measure("reached"))
    points, _ = cloud(half)
    assert 0 < len(points) < shown
    assert (half.share(points) > 0.0).all()
    # Between positions, those that are not made count as not reached, so that widths are smaller there.
    there = half.query(poses)
    assert (there.measures["width"] <= full.measures["width"] + 1e-12).all()
    inside = there.reached
    assert (there.measures["width"] < full.measures["width"] - 1e-6)[inside].any()
    shutil.rmtree(path / "done" / "c")
    none = open_map(path)
    assert none.done == 0.0
    assert not none.mean("reached").any()
    assert not len(cloud(none)[0])


@pytest.mark.parametrize("step", [0.0, -0.1, np.nan, "x", True, 1e-9, 2e-4, 900.0])
def test_points_too_close_and_too_far_are_refused_before_they_are_made(made, step, tmp_path):
    chart = made[0]
    for ask in (cloud, lambda chart, step: to_vtk(chart, tmp_path / "m.vti", step)):
        with pytest.raises(srs_ik.InvalidMap, match=r"length from 0\.0001 to 1000 m|there may be 1 to 20,000,000"):
            ask(chart, step)
    assert not (tmp_path / "m.vti").exists()


@pytest.mark.parametrize("points", [np.zeros((3, 4)), np.zeros(6), "abc", [[np.nan, 0, 0]], 3.0])
def test_points_are_three_figures_each(made, points):
    chart = made[0]
    with pytest.raises(srs_ik.InvalidPose):
        chart.share(points)


def test_maps_are_made_and_read_where_the_system_has_no_locks(tmp_path):
    """Such as Windows, whose Python has no fcntl."""
    code = f"""
import sys
sys.modules["fcntl"] = None
import srs_ik
arm = srs_ik.load("iiwa14")
pose = arm.forward_kinematics([0.1, 0.5, 0.2, -1.0, 0.3, 0.4, 0.5]).homogeneous
print(srs_ik.build_map(arm, step=0.5, path={str(tmp_path / "map")!r}, orientations=12).done == 1.0)
print(srs_ik.base_placement(arm, [pose], [srs_ik.pose_from_xyz_rpy([0, 0, 0], [0, 0, 0])]).share[0] == 1.0)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=600)
    assert done.stdout.split() == ["True", "True"], done.stderr
