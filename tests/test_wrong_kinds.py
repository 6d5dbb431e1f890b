"""Things of the wrong kind are refused in one sentence, wherever arguments of that kind are taken."""

import re
import warnings

import arms
import numpy as np
import pytest
from wrong_things import Odd

import srs_ik
from srs_ik import maps, paper, plots, preview

Q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])


class Refusing:
    """An object that fails on being made a number or an array."""

    def __float__(self):
        raise RuntimeError("no number")

    def __array__(self, *_, **__):
        raise RuntimeError("no array")


MASKED = {
    "pose": lambda arm, poses, q: arm.solve(poses[1]),
    "poses": lambda arm, poses, q: arm.solve_batch(poses),
    "reachable": lambda arm, poses, q: arm.reachable_batch(poses),
    "path": lambda arm, poses, q: arm.solve_path(poses),
    "q": lambda arm, poses, q: arm.forward_kinematics(q[1]),
    "seed": lambda arm, poses, q: arm.solve(poses.data[1], seed=q[1]),
    "many q": lambda arm, poses, q: arm.forward_kinematics_batch(q),
}


@pytest.mark.parametrize("what", MASKED)
def test_what_a_masked_array_hides_is_no_figure(arm, what):
    q = np.ma.masked_array(np.tile(Q, (3, 1)), mask=np.zeros((3, 7), bool))
    poses = np.ma.masked_array(arm.forward_kinematics_batch(q), mask=np.zeros((3, 4, 4), bool))
    MASKED[what](arm, poses, q)
    q[1, 2] = poses[1, 0, 3] = np.ma.masked
    with pytest.raises(srs_ik.SrsIkError, match="not finite numbers"):
        MASKED[what](arm, poses, q)


@pytest.fixture(scope="module")
def arm():
    return arms.load("iiwa14")


@pytest.fixture(scope="module")
def pose(arm):
    return arm.forward_kinematics(Q)


NO_FLAGS = ("no", "", "False", None, 0, 1, 1.0, [True], np.array([True, False]), Odd())
TASK = srs_ik.Task([0.45, 0.1, 0.5], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0])
FLAGS = {
    "solve": ("respect_limits", lambda arm, pose, flag: arm.solve(pose, respect_limits=flag)),
    "solve_all": ("respect_limits", lambda arm, pose, flag: arm.solve_all(pose, respect_limits=flag)),
    "solve_batch": ("respect_limits", lambda arm, pose, flag: arm.solve_batch([pose], respect_limits=flag)),
    "all branches": ("all_branches", lambda arm, pose, flag: arm.solve_batch([pose], 0.1, all_branches=flag)),
    "free axis": ("respect_limits", lambda arm, pose, flag: arm.solve(pose, respect_limits=flag, free_axis=[0, 0, 1])),
    "intervals": ("respect_limits", lambda arm, pose, flag: arm.intervals(pose, flag)),
    "intervals_batch": ("respect_limits", lambda arm, pose, flag: arm.intervals_batch([pose], None, flag)),
    "optimise": ("respect_limits", lambda arm, pose, flag: arm.optimise(pose, "manipulability", flag)),
    "self_motion": ("respect_limits", lambda arm, pose, flag: arm.self_motion(pose, respect_limits=flag)),
    "free_splits": ("respect_limits", lambda arm, pose, flag: arm.free_splits(pose, flag)),
    "solve_task": ("respect_limits", lambda arm, pose, flag: arm.solve_task(TASK, respect_limits=flag)),
    "solve_path": ("closed", lambda arm, pose, flag: arm.solve_path([pose, pose], closed=flag)),
    "Scene": ("exact", lambda arm, pose, flag: srs_ik.Scene(exact=flag)),
    "force_polytope": ("gravity", lambda arm, pose, flag: srs_ik.force_polytope(arm, Q, gravity=flag)),
    "printed_optimum": (
        "respect_limits",
        lambda arm, pose, flag: paper.printed_optimum(arm, pose, "manipulability", respect_limits=flag),
    ),
    "load": ("allow_xacro", lambda arm, pose, flag: srs_ik.load("iiwa14", allow_xacro=flag)),
}


@pytest.mark.parametrize("case", FLAGS)
def test_a_flag_is_true_or_false(case, arm, pose):
    name, call = FLAGS[case]
    for wrong in NO_FLAGS:
        with pytest.raises(srs_ik.SrsIkError, match=f"{name} must be True or False, not ") as caught:
            call(arm, pose, wrong)
        assert "\n" not in str(caught.value)


def test_flags_of_numpy_are_flags(arm, pose):
    for flag in (True, False):
        assert repr(arm.solve(pose, respect_limits=np.bool_(flag))) == repr(arm.solve(pose, respect_limits=flag))


def test_the_sense_of_a_function_is_true_or_false_or_not_said(arm, pose):
    with pytest.raises(srs_ik.InvalidTask, match="maximise must be True or False, not 'no'"):
        arm.optimise(pose, lambda q: q[0], maximise="no")
    least, most = (arm.optimise(pose, lambda q: q[0], maximise=sense).value for sense in (None, True))
    assert least < most


ARMS = {
    "velocity_polytope": lambda arm: srs_ik.velocity_polytope(arm, Q),
    "force_polytope": lambda arm: srs_ik.force_polytope(arm, Q),
    "Objective.value": lambda arm: srs_ik.Objective("manipulability").value(arm, Q),
    "base_placement": lambda arm: srs_ik.base_placement(arm, [np.eye(4)], [np.eye(4)]),
    "build_map": lambda arm: srs_ik.build_map(arm, path="never.zarr"),
    "estimate": lambda arm: maps.estimate(arm),
    "measures_of": lambda arm: maps.measures_of(arm, [np.eye(4)]),
    "yaw_arcs": lambda arm: maps.yaw_arcs(arm, [np.eye(4)]),
    "printed_optimum": lambda arm: paper.printed_optimum(arm, np.eye(4), "manipulability"),
    "plot_arm_angle": lambda arm: plots.plot_arm_angle(arm, np.eye(4)),
    "plot_ellipsoids": lambda arm: plots.plot_ellipsoids(arm, Q),
    "plot_intervals": lambda arm: plots.plot_intervals(arm, np.eye(4)),
    "plot_yaw_arcs": lambda arm: plots.plot_yaw_arcs(arm, np.eye(4)),
    "Preview": lambda arm: srs_ik.Preview(arm),
    "InteractivePreview": lambda arm: preview.InteractivePreview(arm),
    "FollowingPreview": lambda arm: preview.FollowingPreview(arm),
    "add_arm": lambda arm: srs_ik.Scene().add_arm("other", arm, Q, pose=np.eye(4)),
    "beside": lambda arm: srs_ik.Scene().add_arm("other", arms.load("iiwa14"), Q, beside=arm or "None"),
}


@pytest.mark.parametrize("case", ARMS)
def test_a_name_is_no_arm(case):
    if case.startswith(("plot", "Interactive", "Following")):
        pytest.importorskip("matplotlib" if case.startswith("plot") else "viser")
    for wrong in ("iiwa14", None, Odd(), 7):
        with pytest.raises(srs_ik.SrsIkError, match=r"an arm is what srs_ik\.load gives, not ") as caught:
            ARMS[case](wrong)
        assert ("load it first" in str(caught.value)) == isinstance(wrong, str) or case == "beside"


MAPS = {
    "cloud": maps.cloud,
    "to_numpy": lambda chart: maps.to_numpy(chart, "never.npz"),
    "to_vtk": lambda chart: maps.to_vtk(chart, "never.vti"),
    "to_reuleaux": lambda chart: maps.to_reuleaux(chart, "never.h5"),
    "plot_map": plots.plot_map,
    "plot_shell": plots.plot_shell,
    "show_map": lambda chart: preview.show_map(None, chart),
}


@pytest.mark.parametrize("case", MAPS)
def test_a_folder_is_no_map(case):
    if case.startswith("plot") or case == "to_reuleaux":
        pytest.importorskip("matplotlib" if case.startswith("plot") else "h5py")
    for wrong in ("map.zarr", None, Odd(), 7):
        with pytest.raises(srs_ik.InvalidMap, match="a map is what build_map or open_map gives, not ") as caught:
            MAPS[case](wrong)
        assert ("open it first" in str(caught.value)) == isinstance(wrong, str)


def test_an_opened_map_takes_an_arm_and_a_scene_or_none(tmp_path, arm):
    pytest.importorskip("zarr")
    srs_ik.build_map(arm, 0.4, tmp_path / "map.zarr", orientations=24)
    with pytest.raises(srs_ik.InvalidRobot, match=r"an arm is what srs_ik\.load gives, not 'iiwa14'; load it first"):
        srs_ik.open_map(tmp_path / "map.zarr", "iiwa14")
    with pytest.raises(srs_ik.InvalidScene, match=r"a scene is a srs_ik\.Scene, not 'scene.json'"):
        srs_ik.open_map(tmp_path / "map.zarr", arm, "scene.json")
    chart = srs_ik.open_map(tmp_path / "map.zarr", arm)
    with pytest.raises(srs_ik.InvalidMap, match="exact must be True or False, not 'no'"):
        chart.query([np.eye(4)], exact="no")
    for wrong in (10.5, None, -1, "10", np.nan, np.inf, True, 10**400):
        for name in ("count", "seed"):
            with pytest.raises(srs_ik.InvalidMap, match=f"{name} must be a whole number from 0 to 1e[+]12, not "):
                chart.verify(**{name: wrong})
    assert chart.verify(count=np.int64(3))
    for wrong in (None, 7, Odd(), b"map.zarr"):
        with pytest.raises(srs_ik.InvalidMap, match="the folder of a map is a path or text, not"):
            srs_ik.open_map(wrong)
        with pytest.raises(srs_ik.InvalidMap, match="a map is what build_map or open_map gives, not"):
            maps.compare(chart, wrong)
    for name, wrong in (("progress", 7), ("client", "local"), ("measures", 7), ("measures", [["margin"]])):
        with pytest.raises(srs_ik.InvalidMap, match=f"^{name} (is|are) "):
            srs_ik.build_map(arm, 0.4, tmp_path / "other.zarr", orientations=24, **{name: wrong})
    for name in (["reached"], np.zeros(3)):
        with pytest.raises(srs_ik.InvalidMap, match="has no measure"):
            chart.measure(name)
    with pytest.raises(srs_ik.InvalidMap, match="workers must be a whole number from 1 to"):
        maps.estimate(arm, 0.4, orientations=24, workers="two")


@pytest.mark.parametrize(
    "wrong",
    [Refusing(), ["1"] * 7, np.zeros(7, dtype=[("a", float)]), np.array(["2026"] * 7, "datetime64"), "1", [b"1"] * 7],
    ids=["refusing", "digits", "records", "dates", "text", "bytes"],
)
def test_what_only_looks_like_numbers_is_refused(wrong, arm, pose):
    for call in (
        lambda: arm.solve(pose, seed=wrong),
        lambda: arm.solve_batch([pose], seed=wrong),
        lambda: arm.forward_kinematics(wrong),
        lambda: arm.tracker(Q, 0.01, velocity=wrong),
        lambda: arm.solve(wrong),
        lambda: arm.intervals_batch(wrong),
        lambda: srs_ik.velocity_ellipsoid(arm.jacobian(Q), limit=wrong),
        lambda: arm.solve(pose, free_axis=wrong),
        lambda: srs_ik.Scene().add_sphere("ball", wrong, 0.1),
        lambda: srs_ik.Task(wrong, [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
        lambda: arm.forward_kinematics_batch("" if isinstance(wrong, str) else wrong),
    ):
        with pytest.raises(srs_ik.SrsIkError):
            call()


def test_threads_are_checked_where_one_is_enough(arm):
    few = [arm.forward_kinematics(Q)] * 3
    batches = (arm.solve_batch, arm.intervals_batch, arm.reachable_batch)
    for ask, what in [*((ask, TASK) for ask in (arm.posture, arm.solve_task)), *((ask, few) for ask in batches)]:
        for wrong in ("two", 0, -1, 1.5, True):
            with pytest.raises(ValueError, match="threads must be a positive integer, not") as caught:
                ask(what, threads=wrong)
            assert isinstance(caught.value, srs_ik.InvalidConfiguration)


def test_texts_are_no_poses(arm):
    for ask in (arm.solve_batch, arm.intervals_batch, arm.reachable_batch, arm.solve_path):
        with pytest.raises(srs_ik.InvalidPose, match="or a list of poses, not ''"):
            ask("")


def test_what_has_a_length_and_items_is_a_list_of_poses(arm, pose):
    class Poses:
        def __len__(self):
            return 2

        def __getitem__(self, i):
            return (pose, pose)[i]

    assert arm.solve_batch(Poses()).q.shape == (2, 7)


def test_branches_of_any_size_are_named_briefly(arm, pose):
    for wrong in (10**4000, np.timedelta64(1, "s"), "a" * 5000):
        with pytest.raises(srs_ik.InvalidConfiguration, match="a branch is an integer from 0 to 7") as caught:
            arm.solve(pose, branch=wrong)
        assert len(str(caught.value)) < 400


def test_tools_out_of_any_reach_are_refused(arm):
    far = np.eye(4)
    far[0, 3] = 1e200
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for change in (arm.with_tool, arm.with_base):
            with pytest.raises(srs_ik.InvalidRobot, match=r"no farther away than 1e\+06 m"):
                change(far)


def test_parts_are_texts(arm):
    for wrong in (np.zeros(7), None, 10**4000, ["linear", "angular"]):
        for call in (srs_ik.velocity_polytope, srs_ik.force_polytope):
            with pytest.raises(srs_ik.InvalidTask, match="part is 'linear', 'angular' or 'full'") as caught:
                call(arm, Q, part=wrong)
            assert len(str(caught.value)) < 400


def test_messages_show_the_numbers_of_numpy_as_those_of_python(arm, pose):
    number, one = np.float64, np.int64(1)
    for call, said in (
        (lambda: srs_ik.Scene().add_box("c0", np.eye(4), [1, 1, 0]), "not 0.0"),
        (lambda: srs_ik.Scene().add_sphere("c0", [0, 0, 0], number(-1.5)), "not -1.5"),
        (lambda: arm.solve(pose, arm_angle=number("nan")), "not nan"),
        (lambda: arm.self_motion(pose, count=one), "not 1"),
        (lambda: arm.tracker(Q, number(-1)), "not -1.0"),
        (lambda: arm.tracker(Q, 0.01, smoothing=number(-1)), "not -1.0"),
        (lambda: arm.solve(pose, respect_limits=one), "not 1"),
        (lambda: arm.optimise(pose, np.str_("nix")), "objective 'nix'"),
        (lambda: srs_ik.FreeAxis([0, 0, 1], cone=number(7)), "not 7.0"),
        (lambda: srs_ik.pose_from_xyz_rpy([number(1)] * 2, [0, 0, 0]), "not [1.0, 1.0]"),
        (lambda: arm.with_base(np.eye(4), gravity=np.longdouble(2)), "2.0"),
    ):
        with pytest.raises(srs_ik.SrsIkError) as caught:
            call()
        assert said in str(caught.value)
        assert not re.search(r"np\.(float|int|str|bool)", str(caught.value))


@pytest.mark.parametrize("flag", [True, False, np.True_])
def test_a_flag_is_no_number(arm, pose, flag):
    with pytest.raises(srs_ik.InvalidConfiguration, match="arm angle must be a finite number of radians"):
        arm.solve(pose, arm_angle=flag)
    with pytest.raises(srs_ik.SrsIkError):
        srs_ik.FreeAxis([0.0, 0.0, 1.0], cone=flag)


def test_flags_are_no_array_of_numbers(arm, pose):
    for call in (
        lambda: arm.solve(pose, seed=np.ones(7, bool)),
        lambda: arm.solve(pose, arm_angle=np.array(True)),
        lambda: arm.solve(pose, elbow=[True, False, True]),
        lambda: arm.solve(pose, free_axis=[False, False, True]),
        lambda: arm.solve(np.eye(4, dtype=bool)),
        lambda: arm.forward_kinematics([True] * 7),
        lambda: arm.forward_kinematics_batch(np.ones((3, 7), bool)),
        lambda: arm.tracker(Q, 0.01, velocity=True),
        lambda: arm.tracker(Q, 0.01, acceleration=[True] * 7),
        lambda: arm.solve_path([pose], objective="time", acceleration_limit=True),
        lambda: srs_ik.Task([True, False, True], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
        lambda: srs_ik.Scene().add_box("crate", np.eye(4), [True, True, True]),
    ):
        with pytest.raises(srs_ik.SrsIkError) as caught:
            call()
        assert "\n" not in str(caught.value)
    with pytest.raises(srs_ik.InvalidConfiguration, match="q must be 7 joint angles, not flags, True and False"):
        arm.forward_kinematics(np.ones(7, bool))


def test_buffers_are_arrays(arm):
    q = np.tile(Q, (3, 1))
    poses = arm.forward_kinematics_batch(memoryview(q))
    assert (poses == arm.forward_kinematics_batch(q)).all()
    assert (arm.solve_batch(memoryview(poses)).q == arm.solve_batch(poses).q).all()


def test_what_fails_as_it_is_read_is_refused(arm):
    def broken():
        yield Q
        raise RuntimeError("no more")

    for call in (arm.forward_kinematics_batch, arm.jacobian_batch, arm.solve_batch):
        with pytest.raises(srs_ik.SrsIkError, match=" not generator"):
            call(broken())
