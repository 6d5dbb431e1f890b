"""Measures for a scene and for a task: against sweeps of arm angles by Pinocchio, stored, resumed and read again."""

import coal
import numpy as np
import pytest
from collision_oracle import Truth, file_of

import srs_ik
from srs_ik.maps import build_map, estimate, measures_of, open_map
from srs_ik.maps.fingerprint import fingerprint
from srs_ik.maps.tasks import in_base

pytest.importorskip("zarr")

BOX = [[0.3, 0.7], [-0.2, 0.2], [0.3, 0.7]]
VELOCITY, FORCE = [1.0, 0.0, 0.2], [0.0, 0.0, -2.0]


def shelf():
    scene = srs_ik.Scene(margin=0.01)
    scene.add_box("shelf", srs_ik.pose_from_xyz_rpy([0.5, 0.35, 0.5], [0.0, 0.0, 0.0]), [0.6, 0.1, 1.0])
    return scene


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    arm, scene = srs_ik.load("iiwa14"), shelf()
    path = tmp_path_factory.mktemp("maps") / "box.zarr"
    return (
        build_map(arm, 0.2, path, orientations=12, box=BOX, scene=scene, velocity=VELOCITY, force=FORCE),
        arm,
        scene,
    )


def pose_of(chart, at):
    T = np.eye(4)
    T[:3, :3] = in_base(chart.plan).reshape(-1, 3, 3)[at[-1]]
    T[:3, 3] = chart.plan.grid.points([slice(i, i + 1) for i in at[:-1]])[0]
    return T


def some_reached(chart, count):
    reached = np.argwhere(chart.measure("reached") > 0)
    return [tuple(at) for at in reached[np.linspace(0, len(reached) - 1, count).astype(int)]]


def ratio_by_pinocchio(arm, q):
    return srs_ik.force_velocity_ratio(arm.jacobian(q), FORCE, VELOCITY)


@pytest.mark.slow
def test_the_ratio_is_the_smallest_of_all_postures_and_its_posture_is_rebuilt(made):
    chart, arm, _ = made
    ratio, angle, branch = (chart.measure(name) for name in ("ratio", "ratio_arm_angle", "ratio_branch"))
    for at in some_reached(chart, 12):
        T = pose_of(chart, at)
        best = arm.solve(T, arm_angle=angle[at], branch=int(branch[at]))
        assert best
        assert ratio_by_pinocchio(arm, best.q) == pytest.approx(ratio[at], rel=1e-5)
        swept = [
            ratio_by_pinocchio(arm, each.q)
            for interval in arm.intervals(T)
            for psi in np.linspace(interval.lower, interval.upper, 60)
            if (each := arm.solve(T, arm_angle=psi, branch=interval.branch))
        ]
        assert ratio[at] <= min(swept) * (1.0 + 1e-5)


def test_the_mean_ratio_is_that_of_what_is_reached(made):
    ratio, reached = (made[0].measure(name) for name in ("ratio", "reached"))
    expected = [r[m > 0].mean() if m.any() else 0.0 for r, m in zip(_rows(ratio), _rows(reached), strict=True)]
    np.testing.assert_allclose(made[0].mean("ratio").ravel(), expected, rtol=1e-6)


def _rows(values):
    return values.reshape(-1, values.shape[-1]).astype(float)


@pytest.mark.slow
def test_the_free_width_is_that_of_arm_angles_that_clear_the_scene(made):
    chart, arm, scene = made
    free, width = chart.measure("free"), chart.measure("width")
    assert (free <= width + 1e-5).all()
    assert (free < width - 0.1).any()
    assert (free > 0.1).any()
    truth = Truth(file_of(arm)[0], arm, file_of(arm)[1])
    truth.add("shelf", srs_ik.pose_from_xyz_rpy([0.5, 0.35, 0.5], [0.0, 0.0, 0.0]).homogeneous, coal.Box(0.6, 0.1, 1.0))
    step, same = 0.02, 0
    for at in some_reached(chart, 6):
        T = pose_of(chart, at)
        # A map asks spheres alone; where these leave nothing, `intervals` asks the real shapes.
        if free[at] > 0.0:
            assert free[at] == pytest.approx(sum(each.width for each in arm.intervals(T, scene=scene)), abs=1e-5)
            same += 1
        clear = 0.0
        for interval in arm.intervals(T):
            for psi in np.arange(interval.lower + 0.5 * step, interval.upper, step):
                clear += step * (not truth.collides(arm.solve(T, psi, branch=interval.branch).q))
        # Each end of a free piece may be half a step off.
        # Spheres cover the real shapes, so what is free is free of these for certain.
        assert free[at] <= clear + 0.5 * step * 2 * 12
    assert same > 1


def test_nothing_is_free_behind_a_wall_that_holds_the_hand():
    arm, scene = srs_ik.load("iiwa14"), srs_ik.Scene()
    pose = arm.forward_kinematics([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    scene.add_sphere("ball", pose.translation, 0.3)
    found = measures_of(arm, [pose], scene=scene)
    assert found["reached"][0] == 1
    assert found["width"][0] > 0.0
    assert found["free"][0] == 0.0


def with_a_rod():
    return srs_ik.load("iiwa14").with_object(
        "rod", srs_ik.pose_from_xyz_rpy([0.0, 0.0, 0.15], [0.0, 0.0, 0.0]), [0.05, 0.05, 0.4]
    )


def unwatched(arm):
    return arm.with_bodies(drop=[(pair.first, pair.second) for pair in arm.pairs if pair.kept])


CHANGES = {
    "limits": lambda arm: arm.with_limits(lower=[-2.8] * 7, upper=[2.0] * 7),
    "tool": lambda arm: arm.with_tool(srs_ik.pose_from_xyz_rpy([0.0, 0.0, 0.2], [0.0, 0.5, 0.0])),
    "base": lambda arm: arm.with_base(srs_ik.pose_from_xyz_rpy([1.0, 0.0, 0.2], [0.0, 0.5, 0.0])),
    "pairs": unwatched,
}


@pytest.mark.parametrize("change", CHANGES)
def test_what_is_free_is_that_of_the_arm_that_asks_not_of_one_that_asked_before(change):
    arm, scene = with_a_rod(), shelf()
    other, q = CHANGES[change](arm), [0.8, -1.0, -2.7, -2.0, 1.9, 1.7, 0.7]
    for each in (arm, other, arm):
        T = each.forward_kinematics(q).homogeneous
        expected = sum(interval.width for interval in each.intervals(T, scene=scene))
        assert expected > 0.1  # else `intervals` would have asked the real shapes
        assert measures_of(each, [T], scene=scene)["free"][0] == pytest.approx(expected, abs=1e-5)


def test_a_map_of_other_pairs_or_of_an_object_moved_meanwhile_is_another_one(tmp_path):
    arm, scene, path = with_a_rod(), shelf(), tmp_path / "box.zarr"
    chart = build_map(arm, 0.4, path, orientations=12, box=BOX, scene=scene)
    with pytest.raises(srs_ik.InvalidMap, match="no map of this scene"):
        open_map(path, unwatched(arm), scene)
    with pytest.raises(srs_ik.InvalidMap, match="another scene"):
        build_map(unwatched(arm), 0.4, path, orientations=12, box=BOX, scene=scene)
    scene.move("shelf", srs_ik.pose_from_xyz_rpy([0.4, 0.1, 0.5], [0.0, 0.0, 0.0]))
    assert chart.verify(100)


def test_things_of_the_same_spheres_with_other_shapes_are_others():
    """Where real shapes count, a capsule is less than the spheres that cover it."""
    arm, capsule, cloud = srs_ik.load("iiwa14"), srs_ik.Scene(exact=True), srs_ik.Scene(exact=True)
    capsule.add_capsule("thing", np.eye(4), 0.05, 0.1)
    (rows,) = next(iter(capsule)).rows
    cloud.add_points("thing", rows[:, :3], rows[0, 3])
    np.testing.assert_array_equal(next(iter(cloud)).rows, [rows])
    assert fingerprint(arm, capsule) != fingerprint(arm, cloud)


def test_it_is_resumed_checked_and_refused_to_others(made, tmp_path):
    chart, arm, scene = made
    before = chart.store.records().copy()
    again = build_map(arm, 0.2, chart.path, orientations=12, box=BOX, scene=shelf(), velocity=VELOCITY, force=FORCE)
    np.testing.assert_array_equal(again.store.records(), before)
    assert open_map(chart.path, arm, scene).verify(40)
    with pytest.raises(srs_ik.InvalidMap, match="need the scene of the map"):
        open_map(chart.path, arm).verify(10)
    other = shelf()
    other.move("shelf", srs_ik.pose_from_xyz_rpy([0.5, 0.36, 0.5], [0.0, 0.0, 0.0]))
    with pytest.raises(srs_ik.InvalidMap, match="no map of this scene"):
        open_map(chart.path, arm, other)
    with pytest.raises(srs_ik.InvalidMap, match="another scene"):
        build_map(arm, 0.2, chart.path, orientations=12, box=BOX, scene=other, velocity=VELOCITY, force=FORCE)
    with pytest.raises(srs_ik.InvalidMap, match="another task"):
        build_map(arm, 0.2, chart.path, orientations=12, box=BOX, scene=scene, velocity=VELOCITY, force=VELOCITY)
    at = some_reached(chart, 3)[1]
    found = chart.query([pose_of(chart, at)], exact=True).measures
    for name in ("ratio", "free", "ratio_arm_angle"):
        assert found[name][0] == pytest.approx(chart.measure(name)[at], rel=1e-6)


@pytest.mark.slow
def test_what_is_missing_is_said():
    arm = srs_ik.load("iiwa14")
    with pytest.raises(srs_ik.InvalidMap, match="map a box"):
        build_map(arm, 0.2, "x.zarr", scene=shelf())
    with pytest.raises(srs_ik.InvalidMap, match="give both"):
        build_map(arm, 0.2, "x.zarr", box=BOX, velocity=VELOCITY)
    with pytest.raises(srs_ik.InvalidMap, match="three numbers"):
        build_map(arm, 0.2, "x.zarr", box=BOX, velocity=VELOCITY, force=[0.0, 0.0, 0.0])
    with pytest.raises(srs_ik.InvalidMap, match="'free' is for a scene"):
        build_map(arm, 0.2, "x.zarr", box=BOX, measures=["free"])
    with pytest.raises(srs_ik.InvalidMap, match="'ratio' is for a task"):
        build_map(arm, 0.2, "x.zarr", box=BOX, measures=["ratio"])
    with pytest.raises(srs_ik.InvalidScene):
        build_map(arm, 0.2, "x.zarr", box=BOX, scene="shelf")
    found = estimate(arm, 0.2, orientations=12, box=BOX, velocity=VELOCITY, force=FORCE)
    assert found.rate < 50_000.0  # each pose that is reached is searched


def test_the_ratio_between_positions_is_that_of_those_that_are_reached(made):
    chart, _, _ = made
    ratio, reached = chart.measure("ratio"), chart.measure("reached") > 0
    partly = list(np.argwhere(reached[:-1] & ~reached[1:]))
    assert partly
    for at in partly:
        T = pose_of(chart, tuple(at))
        # Half-way to the next position, which is not reached, and whose 0 is no ratio.
        T[0, 3] += 0.45 * chart.plan.grid.step
        found = chart.query([T])
        assert found.reached.all()
        assert found.measures["ratio"][0] == pytest.approx(ratio[tuple(at)], rel=1e-6)
