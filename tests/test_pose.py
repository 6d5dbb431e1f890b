"""What callers give: any sensible form is taken, everything malformed is refused in one sentence."""

import warnings
from types import SimpleNamespace

import arms
import numpy as np
import pinocchio as pin
import pytest

import srs_ik
from srs_ik import InvalidConfiguration, InvalidPose, SrsIkError


def changed(index, value):
    T = np.eye(4)
    T[index] = value
    return T


BAD_POSES = {
    "nothing": None,
    "text": "pose",
    "number": 3.0,
    "rotation alone": np.eye(3),
    "three rows": np.eye(4)[:3],
    "flat": np.eye(4).ravel(),
    "many": np.zeros((2, 4, 4)),
    "ragged": [[1.0, 0.0], [0.0]],
    "objects": np.full((4, 4), None),
    "complex": np.eye(4) * 1j,
    "NaN in the position": changed((0, 3), np.nan),
    "NaN in the rotation": changed((1, 2), np.nan),
    "NaN in the last row": changed((3, 0), np.nan),
    "infinite position": changed((2, 3), np.inf),
    "infinities that cancel": changed(([0, 1], [3, 3]), [np.inf, -np.inf]),
    "position at the end of numbers": changed((1, 3), -1e308),
    "integers beyond floats": np.eye(4, dtype=object) * 10**400,
    "zeros": np.zeros((4, 4)),
    "mirror": np.diag([1.0, 1.0, -1.0, 1.0]),
    "scaled": np.diag([2.0, 2.0, 2.0, 1.0]),
    "sheared": changed((0, 1), 1e-3),
    "hardly a rotation": changed((0, 0), 1.0 + 1e-5),
    "scaled last row": changed((3, 3), 2.0),
    "projective": changed((3, 1), 0.1),
    "transposed": pin.SE3(np.eye(3), np.array([0.4, 0.0, 0.3])).homogeneous.T,
    "quaternion and position": np.array([0.4, 0.0, 0.3, 0.0, 0.0, 0.0, 1.0]),
}

BAD_VECTORS = {
    "nothing": None,
    "text": "home",
    "number": 1.0,
    "six": np.zeros(6),
    "eight": np.zeros(8),
    "column": np.zeros((7, 1)),
    "row": np.zeros((1, 7)),
    "NaN": [0, 0, np.nan, 0, 0, 0, 0],
    "infinite": [0, 0, np.inf, 0, 0, 0, 0],
    "infinities that cancel": [0, -np.inf, np.inf, 0, 0, 0, 0],
    "integers beyond floats": [10**400] * 7,
    "ragged": [[0.0], [0.0, 1.0]],
    "complex": np.full(7, 1j),
    "names": {"a": 1.0},
}


def assert_one_sentence(raised):
    text = str(raised.value)
    assert isinstance(raised.value, SrsIkError)
    assert isinstance(raised.value, ValueError)
    assert 10 < len(text) < 200
    assert "\n" not in text
    assert ". " not in text


@pytest.mark.parametrize("pose", BAD_POSES.values(), ids=BAD_POSES)
@pytest.mark.parametrize("method", ["solve", "solve at angle", "solve_all", "solve_all at angle", "intervals"])
def test_malformed_poses_are_refused(method, pose):
    arm = arms.load("iiwa14")
    call, *at_angle = method.split(" at ")
    with pytest.raises(InvalidPose) as raised, warnings.catch_warnings(action="error"):
        getattr(arm, call)(pose, **({"arm_angle": 0.1} if at_angle else {}))
    assert_one_sentence(raised)


@pytest.mark.parametrize("pose", BAD_POSES.values(), ids=BAD_POSES)
def test_malformed_poses_are_not_verified(pose):
    with pytest.raises(InvalidPose) as raised:
        arms.load("iiwa14").verify(pose, np.zeros(7))
    assert_one_sentence(raised)


@pytest.mark.parametrize("q", BAD_VECTORS.values(), ids=BAD_VECTORS)
@pytest.mark.parametrize("method", ["forward_kinematics", "jacobian", "configuration", "arm_angle", "branch"])
def test_malformed_joint_vectors_are_refused(method, q):
    if method in ("arm_angle", "branch") and isinstance(q, np.ndarray) and q.shape == (1, 7):
        assert len(getattr(arms.load("iiwa14"), method)(q)) == 1  # these take rows of joint angles, too
        return
    with pytest.raises(InvalidConfiguration) as raised, warnings.catch_warnings(action="error"):
        getattr(arms.load("iiwa14"), method)(q)
    assert_one_sentence(raised)


@pytest.mark.parametrize("q", [bad for bad in BAD_VECTORS.values() if bad is not None])
def test_malformed_seeds_are_refused_by_name(q):
    with pytest.raises(InvalidConfiguration, match="seed") as raised, warnings.catch_warnings(action="error"):
        arms.load("iiwa14").solve(np.eye(4), seed=q)
    assert_one_sentence(raised)


@pytest.mark.parametrize(
    "arm_angle", [np.nan, np.inf, -np.inf, "north", [0.1, 0.2], {}, 1j, np.zeros((2, 2)), 1e9, 10**400]
)
def test_malformed_arm_angles_are_refused(arm_angle):
    arm = arms.load("iiwa14")
    for call in (arm.solve, arm.solve_all):
        with pytest.raises(InvalidConfiguration, match="arm angle") as raised:
            call(np.eye(4), arm_angle=arm_angle)
        assert_one_sentence(raised)
        with pytest.raises(InvalidConfiguration, match="arm_angle") as raised:
            arm.solve_batch([np.eye(4)] * 3, arm_angle=arm_angle)
        assert_one_sentence(raised)


SEEDED = {
    "solve": lambda arm, pose, seed: arm.solve(pose, seed=seed),
    "solve at angle": lambda arm, pose, seed: arm.solve(pose, arm_angle=0.2, seed=seed),
    "solve_batch": lambda arm, pose, seed: arm.solve_batch([pose] * 2, seed=seed),
    "solve_batch of seeds": lambda arm, pose, seed: arm.solve_batch([pose] * 2, seed=[np.zeros(7), seed]),
    "solve_path": lambda arm, pose, seed: arm.solve_path([pose] * 2, seed=seed),
    "solve_task": lambda arm, pose, seed: arm.solve_task(
        srs_ik.Task(pose.translation, [1, 0, 0], [0, 0, 1]), seed=seed
    ),
}


@pytest.mark.filterwarnings("ignore:seed has joint 3 more than a turn outside")
@pytest.mark.parametrize("call", SEEDED.values(), ids=SEEDED)
def test_seeds_far_outside_the_limits_are_refused(call):
    """Beyond them, the distance from the seed would hide whether the limits are kept."""
    arm = arms.load("iiwa14")
    q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    pose = arm.forward_kinematics(q)
    seed = q.copy()
    for turns in (1, -5, 40):
        seed[2] = q[2] + 2.0 * np.pi * turns
        found = call(arm, pose, seed)
        assert np.all(found.status == srs_ik.Status.OK), turns
    seed[2] = 1000.0
    with pytest.raises(InvalidConfiguration, match=r"seed has joint 3 997.*radians") as raised:
        call(arm, pose, seed)
    assert_one_sentence(raised)


def test_seeds_of_many_turns_are_kept_where_joints_are_continuous():
    arm = arms.load("gen3")
    q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    seed = q + 2.0 * np.pi * np.array([1000, 0, -3000, 0, 7, 0, 10000])
    pose = arm.forward_kinematics(q)
    solution = arm.solve(pose, seed=seed)
    assert np.abs(solution.q - seed).max() < 1e-9
    assert max(arm.verify(pose, solution.q)) < 1e-9
    for turned in (1e7, 1e160):
        seed[2] = turned
        assert np.isfinite(arm.forward_kinematics(seed).homogeneous).all()
        for call in SEEDED.values():
            with (
                pytest.raises(InvalidConfiguration, match=r"seed has an angle of 1e\+"),
                warnings.catch_warnings(action="error"),
            ):
                call(arm, pose, seed)


@pytest.mark.parametrize("branch", [-1, 8, 1.5, "0", True, np.nan, [0]])
def test_malformed_branches_are_refused(branch):
    with pytest.raises(InvalidConfiguration, match="branch") as raised:
        arms.load("iiwa14").solve(np.eye(4), branch=branch)
    assert_one_sentence(raised)


@pytest.mark.parametrize("configuration", [None, "home", np.zeros(7), np.zeros(12), np.full(11, np.nan), 1.0])
def test_malformed_configurations_are_refused(configuration):
    arm = arms.load("gen3")
    assert arm.model.nq == 11
    with pytest.raises(InvalidConfiguration) as raised:
        arm.angles(configuration)
    assert_one_sentence(raised)


@pytest.mark.parametrize(("length", "maker"), [(3, "xyz_rpy"), (6, "xyz_rpy"), (7, "xyz_quaternion")])
def test_vectors_that_are_no_pose_are_answered_with_what_makes_one(length, maker):
    with pytest.raises(InvalidPose, match=rf"not an array of shape \({length},\); pose_from_{maker}\("):
        srs_ik.load("iiwa14").solve(np.zeros(length))
    assert callable(getattr(srs_ik, f"pose_from_{maker}"))


def test_poses_in_any_form_are_the_same():
    arm = arms.load("iiwa14")
    pose = arm.forward_kinematics([0.1, 0.5, 0.2, -1.2, 0.3, 0.8, 0.0])
    T = pose.homogeneous
    frozen = T.copy()
    frozen.flags.writeable = False
    wide = np.zeros((4, 8))
    wide[:, ::2] = T
    expected = arm.solve(pose).q
    for form in (T, frozen, T.tolist(), np.asfortranarray(T), wide[:, ::2], T.astype(np.longdouble), [*map(tuple, T)]):
        before = np.array(form, dtype=float)
        assert (arm.solve(form).q == expected).all()
        assert (np.array(form, dtype=float) == before).all(), "the caller's pose was changed"


def test_joint_vectors_in_any_form_are_the_same():
    arm = arms.load("iiwa14")
    q = [0, 1, 0, -1, 0, 1, 0]
    expected = arm.forward_kinematics(np.array(q, dtype=float)).homogeneous
    for form in (q, tuple(q), np.array(q), np.array(q, dtype=np.float32), np.repeat(q, 2)[::2]):
        assert (arm.forward_kinematics(form).homogeneous == expected).all()


def test_rounding_in_a_rotation_is_removed():
    """Rotations from files in single precision: the nearest rotation is what is solved."""
    arm, rng = arms.load("iiwa14"), arms.generator("iiwa14", 61)
    for q in arms.configurations("iiwa14", 20, 62):
        T = arm.forward_kinematics(q).homogeneous
        rounded = T.copy()
        rounded[:3, :3] += rng.uniform(-1e-7, 1e-7, (3, 3))
        u, _, vt = np.linalg.svd(rounded[:3, :3])
        nearest = rounded.copy()
        nearest[:3, :3] = u @ vt
        solution = arm.solve(rounded)
        assert solution
        error = arm.verify(nearest, solution.q)
        assert max(error) < 1e-11


@pytest.mark.parametrize("far", [1e3, 1e9, 1e150, 1e160, 1e300])
def test_poses_at_absurd_distances_are_answered(far):
    for name in ("iiwa14", "gen3"):
        arm = arms.load(name)
        T = np.eye(4)
        T[:3, 3] = far * np.array([1.0, -0.5, 0.2])
        for solution in (arm.solve(T), arm.solve(T, arm_angle=0.1), arm.solve(T, seed=np.zeros(7))):
            assert not solution
            assert np.isfinite(solution.q).all()
            assert ((solution.q >= arm.lower) & (solution.q <= arm.upper)).all()
            assert solution.position_error > 0.5 * far
            assert -np.pi <= solution.arm_angle < np.pi


@pytest.mark.filterwarnings("ignore:the arm angle is in radians")
def test_arm_angles_of_many_turns_are_the_same_angle():
    arm = arms.load("iiwa14")
    pose = arm.forward_kinematics([0.1, 0.5, 0.2, -1.2, 0.3, 0.8, 0.0])
    expected = arm.solve(pose, arm_angle=0.7)
    for turns in (-3, -1, 1, 50):
        solution = arm.solve(pose, arm_angle=0.7 + 2.0 * np.pi * turns)
        assert np.abs(solution.q - expected.q).max() < 1e-10
        assert solution.arm_angle == pytest.approx(0.7)


# A matrix that is nearly a pose


@pytest.mark.parametrize("size", [0.0, 1e-7, 1e-5, 1e-3, 0.03])
def test_the_nearest_pose_is_nearer_than_any_other(size):
    rng = np.random.default_rng(3)
    rounded = 4e-15  # nine entries of a product of three matrices; 1.7e-15 at most over 100,000 random poses
    for _ in range(20):
        T = pin.SE3.Random().homogeneous
        noisy = T.copy()
        noisy[:3, :3] += size * rng.uniform(-1.0, 1.0, (3, 3))
        pose = srs_ik.nearest_pose(noisy)
        R = pose.rotation
        assert np.abs(R.T @ R - np.eye(3)).max() < 1e-15 * 10
        assert np.linalg.det(R) > 0.0
        assert (pose.translation == T[:3, 3]).all()
        best = np.linalg.norm(R - noisy[:3, :3])
        assert best <= np.linalg.norm(T - noisy) + rounded
        for axis in np.vstack([np.eye(3), -np.eye(3), rng.normal(size=(10, 3))]):
            for angle in (1e-6, 1e-4, 1e-2):
                other = R @ pin.exp3(angle * axis / np.linalg.norm(axis))
                assert np.linalg.norm(other - noisy[:3, :3]) >= best - rounded
        arm = arms.load("iiwa14")
        if size > 1e-6:
            with pytest.raises(InvalidPose, match=r"srs_ik\.nearest_pose\(matrix\)"):
                arm.solve(noisy)
        assert arm.solve(pose).q.shape == (7,)


def test_single_precision_is_near_enough():
    arm = arms.load("iiwa14")
    q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    pose = arm.forward_kinematics(q)
    rounded = np.round(pose.homogeneous, 4)
    with pytest.raises(InvalidPose):
        arm.solve(rounded)
    solution = arm.solve(srs_ik.nearest_pose(rounded), seed=q)
    assert solution.status == "OK"
    assert np.abs(solution.q - q).max() < 1e-3


@pytest.mark.parametrize(
    ("matrix", "says"),
    [
        (np.diag([1.0, 1.0, -1.0, 1.0]), "left-handed"),
        (np.diag([1000.0, 1000.0, 1000.0, 1.0]), "stretches by 1000, 1000, 1000"),
        (np.diag([1.0, 1.0, 0.0, 1.0]), "stretches by 1, 1, 0"),
        (np.zeros((4, 4)), "last row of a pose is 0 0 0 1, not 0 0 0 0"),
        (np.full((4, 4), np.nan), "not finite"),
        (np.eye(3), "not an array of shape"),
        (np.eye(4) * (1 + 0j), "not complex numbers"),
    ],
    ids=str,
)
def test_what_is_far_from_a_pose_has_no_nearest_one(matrix, says):
    with pytest.raises(InvalidPose, match=says):
        srs_ik.nearest_pose(matrix)


# What is no number, and arguments that nobody means


REMEDIES = {
    "seed of a solution": (
        lambda arm, T: arm.solve(T, seed=arm.solve(T)),
        "not Solution; give its q",
    ),
    "seed of a joint state": (
        lambda arm, T: arm.solve(T, seed=SimpleNamespace(name=["a"], position=[0.0])),
        "seed must be 7 joint angles, not SimpleNamespace; arm.joint_vector",
    ),
    "seed of a mapping": (lambda arm, T: arm.solve(T, seed=arm.solve(T).as_dict()), "not dict; arm.joint_vector"),
    "seeds of a mapping": (
        lambda arm, T: arm.solve_batch([T], seed={"a": 0.0}),
        "seed .*, not dict; arm.joint",
    ),
    "seed of text": (lambda arm, T: arm.solve(T, seed=["0"] * 7), "seed must be 7 joint angles, not text"),
    "seeds of text": (lambda arm, T: arm.solve_batch([T], seed=["0"] * 7), "one row for each pose, not text"),
    "complex seed": (lambda arm, T: arm.solve(T, seed=[1j] * 7), "seed must be 7 joint angles, not complex numbers"),
    "several seeds": (lambda arm, T: arm.solve(T, seed=np.zeros((3, 7))), r"shape \(3, 7\); solve_batch takes one for"),
    "ragged seed": (lambda arm, T: arm.solve(T, seed=[[0.0], [0.0, 1.0]]), "not lists of different lengths"),
    "seed with something else in it": (lambda arm, T: arm.solve(T, seed=[0.0] * 6 + [{}]), "not list with {} in it"),
    "no joints": (lambda arm, T: arm.forward_kinematics(None), "q must be 7 joint angles, not None"),
    "many joints": (lambda arm, T: arm.jacobian(np.zeros((3, 7))), "forward_kinematics_batch and jacobian_batch take"),
    "many joints of a solution": (lambda arm, T: arm.forward_kinematics_batch(arm.solve(T)), "Solution; give its q"),
    "several arm angles": (lambda arm, T: arm.solve(T, [0.1, 0.2]), "solve_batch takes one for each pose"),
    "arm angles of text": (
        lambda arm, T: arm.solve_batch([T], ["a"]),
        "arm_angle must be a number .*, not text",
    ),
    "pose of text": (lambda arm, T: arm.solve(T.homogeneous.astype(str)), "a pose is .*, not text"),
    "complex pose": (lambda arm, T: arm.solve(T.homogeneous * (1 + 0j)), "a pose is .*, not complex numbers"),
    "no pose": (lambda arm, T: arm.solve(None), "a pose is .*, not None"),
    "pose of a mapping": (
        lambda arm, T: arm.solve({"position": [0, 0, 0], "orientation": [0, 0, 0, 1]}),
        "not dict; pose_from_xyz_quaternion",
    ),
    "pose of a quaternion": (lambda arm, T: arm.solve(pin.Quaternion.Identity()), "not Quaternion; pose_from_xyz_quat"),
    "poses of a quaternion": (
        lambda arm, T: arm.solve_batch(pin.Quaternion.Identity()),
        "poses are .*, not Quat",
    ),
    "pose of a rotation": (lambda arm, T: arm.solve(T.rotation), r"pinocchio\.SE3\(R, xyz\) makes one"),
    "several poses": (lambda arm, T: arm.solve([T, T]), r"shape \(2, 4, 4\); solve_batch, intervals_batch"),
    "one pose for several": (
        lambda arm, T: arm.solve_batch(T.homogeneous),
        r"\(4, 4\); \[pose\] is a list of one",
    ),
    "quaternion": (
        lambda arm, T: srs_ik.pose_from_xyz_quaternion([0, 0, 0], pin.Quaternion.Identity(), order="xyzw"),
        r"4 finite numbers, not Quaternion; \[q\.x, q\.y, q\.z, q\.w\] are, in the order 'xyzw'",
    ),
}


@pytest.mark.parametrize(("call", "says"), REMEDIES.values(), ids=REMEDIES)
def test_messages_name_what_is_wrong_and_what_would_be_right(call, says):
    arm = arms.load("iiwa14")
    with pytest.raises(SrsIkError, match=says) as raised:
        call(arm, arm.forward_kinematics([0.1, 0.5, 0.2, -1.2, 0.3, 0.8, 0.0]))
    assert_one_sentence(raised)


DEGREES = [30.0, 40.0, -20.0, -60.0, 30.0, 45.0, -10.0]
ASKED_IN_DEGREES = {
    "seed": lambda arm, T: arm.solve(T, seed=DEGREES),
    "one of several seeds": lambda arm, T: arm.solve_batch([T, T], seed=[np.zeros(7), DEGREES]),
    "seed of a path": lambda arm, T: arm.solve_path([T], seed=DEGREES),
    "q": lambda arm, T: arm.forward_kinematics(DEGREES),
    "arm angle": lambda arm, T: arm.solve(T, arm_angle=45.0),
    "one of several arm angles": lambda arm, T: arm.solve_batch([T, T], arm_angle=[0.1, 45.0]),
}


@pytest.mark.parametrize("name", ["iiwa14", "gen3"])
@pytest.mark.parametrize("call", ASKED_IN_DEGREES.values(), ids=ASKED_IN_DEGREES)
def test_what_looks_like_degrees_is_told_once_to_the_line_that_gave_it(call, name):
    arm = arms.load(name)
    T = arm.forward_kinematics(np.radians(DEGREES))
    with pytest.warns(UserWarning, match=r"radians.*: are these degrees\?$") as told:
        call(arm, T)
    assert [each.filename for each in told] == [__file__]


def test_turns_of_joints_without_end_are_not_taken_for_degrees():
    arm = arms.load("gen3")
    q = np.radians(DEGREES)
    wound = q + 2.0 * np.pi * np.array([3, 0, -3, 0, 5, 0, 50]) * np.isinf(arm.upper)
    with warnings.catch_warnings(action="error"):
        assert arm.solve(arm.forward_kinematics(wound), seed=wound)
        assert arm.solve(arm.forward_kinematics(q), arm_angle=-7.0)


def test_roll_pitch_and_yaw_that_look_like_degrees_are_told():
    with pytest.warns(UserWarning, match=r"^rpy is in radians, and 180 rad is more than a turn: are these degrees\?$"):
        T = srs_ik.pose_from_xyz_rpy([0, 0, 1], (180, 0, 0))
    np.testing.assert_allclose(T.rotation[1:, 1], [np.cos(180), np.sin(180)], atol=1e-12)  # in radians all the same
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        srs_ik.pose_from_xyz_rpy([0, 0, 1], [2 * np.pi, -np.pi, 0.1])


COMPLEX = np.complex128(0.5 + 0.1j)
SILLY = {
    "complex arm angle": lambda arm, T: arm.solve(T, arm_angle=COMPLEX),
    "complex position": lambda arm, T: srs_ik.pose_from_xyz_rpy(np.array([1j, 0, 0]), [0, 0, 0]),
    "complex quaternion": lambda arm, T: srs_ik.pose_from_xyz_quaternion(
        [0, 0, 0], np.array([0, 0, 0, 1 + 0j]), order="xyzw"
    ),
    "complex direction": lambda arm, T: srs_ik.Objective("twist", twist=np.full(6, COMPLEX)),
    "complex tolerance": lambda arm, T: srs_ik.Objective("force_then_velocity", tolerance=COMPLEX, **DIRECTIONS),
    "complex limit": lambda arm, T: srs_ik.load("iiwa14", limits={"iiwa_joint_1": {"lower": COMPLEX}}),
    "complex reference": lambda arm, T: srs_ik.load("iiwa14", reference=np.array([1, 1j, 0])),
    "complex hand": lambda arm, T: srs_ik.load("iiwa14", hand=np.array([[1j, 0, 1], [0, 1, 0]])),
    "complex time": lambda arm, T: arm.solve_path([T, T], dt=COMPLEX),
    "complex step": lambda arm, T: arm.solve_path([T, T], longest_step=COMPLEX),
    "complex value": lambda arm, T: arm.optimise(T, lambda q: COMPLEX),
    "text for a value": lambda arm, T: arm.optimise(T, lambda q: "3"),
    "huge value": lambda arm, T: arm.optimise(T, lambda q: 10**400),
    "huge position": lambda arm, T: srs_ik.pose_from_xyz_rpy([10**400, 0, 0], [0, 0, 0]),
    "huge direction": lambda arm, T: srs_ik.Objective("twist", twist=[10**400] * 6),
    "huge tolerance": lambda arm, T: srs_ik.Objective("force_then_velocity", tolerance=10**400, **DIRECTIONS),
    "huge limit": lambda arm, T: srs_ik.load("iiwa14", limits={"iiwa_joint_1": {"lower": 10**400}}),
    "huge reference": lambda arm, T: srs_ik.load("iiwa14", reference=[10**400, 0, 0]),
    "far reference posture": lambda arm, T: srs_ik.Objective("reference_posture", reference=[1e160] * 7),
    "far joints": lambda arm, T: arm.arm_angle([1e160] * 7),
    "far joints of a branch": lambda arm, T: arm.branch([1e7] * 7),
    "far joints of a gradient": lambda arm, T: arm.arm_angle_jacobian([1e160] * 7),
    "far joints of a tangent": lambda arm, T: arm.self_motion_tangent([1e160] * 7),
    "a thousand million postures": lambda arm, T: arm.self_motion(T, count=10**9),
    "more postures than memory": lambda arm, T: arm.self_motion(T, count=10**30),
    "limb": lambda arm, T: srs_ik.load("iiwa14", limb=5),
    "base": lambda arm, T: srs_ik.load("iiwa14", base=5),
    "tip": lambda arm, T: srs_ik.load("iiwa14", tip=[]),
    "name": lambda arm, T: srs_ik.load("iiwa14", name=5),
    "joint of a limit": lambda arm, T: srs_ik.load("iiwa14", limits={5: {}}),
    "limits": lambda arm, T: srs_ik.load("iiwa14", limits=5),
}
DIRECTIONS = {"force": [1, 0, 0], "velocity": [0, 1, 0]}


@pytest.mark.parametrize("call", SILLY.values(), ids=SILLY)
def test_what_nobody_means_is_refused_in_one_line(call):
    arm = arms.load("iiwa14")
    T = arm.forward_kinematics([0.1, 0.5, 0.2, -1.2, 0.3, 0.8, 0.0])
    with pytest.raises(SrsIkError) as raised, warnings.catch_warnings(action="error"):
        call(arm, T)
    assert "\n" not in str(raised.value)
    assert 10 < len(str(raised.value)) < 400


@pytest.mark.parametrize("far", [1e7, 1e160, 1e308])
def test_limits_beyond_any_turn_are_none(far):
    arm = srs_ik.load("iiwa14", limits={"iiwa_joint_1": {"lower": -far, "upper": far}})
    assert (arm.lower[0], arm.upper[0]) == (-np.inf, np.inf)
    q = np.array([0.1, 0.5, 0.2, -1.2, 0.3, 0.8, 0.0])
    with warnings.catch_warnings(action="error"):
        solution = arm.solve(arm.forward_kinematics(q))
    assert solution
    assert np.abs(solution.q).max() < 10.0


@pytest.mark.parametrize("far", [1e3, 1e160, 1e308])
def test_directions_may_be_of_any_length(far):
    with warnings.catch_warnings(action="error"):
        arm = srs_ik.load("iiwa14", reference=[far, far, 0], hand=[[0, 0, far], [far, 0, 0]])
    np.testing.assert_allclose(arm.limb.reference, np.array([1, 1, 0]) / np.sqrt(2.0), atol=1e-15)
    assert arm.hand.grasp == (0.0, 0.0, 1.0)


@pytest.mark.parametrize("name", ["iiwa14", "gen3"])
def test_a_function_cannot_change_the_postures_that_it_judges(name):
    arm = arms.load(name)
    T = arm.forward_kinematics([0.1, 0.5, 0.2, -1.2, 0.3, 0.8, 0.0])

    def spoiling(q):
        q[:] = 0.0
        return 1.0

    with pytest.raises(ValueError, match="read-only"):
        arm.optimise(T, spoiling)
    best = arm.optimise(T, lambda q: float(np.sum((q - 0.2) ** 2)))
    assert max(arm.verify(T, best.q)) < 1e-9
