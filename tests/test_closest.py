"""Poses out of reach whose stretched arm breaks the limits: the answer is the closest posture, by SciPy."""

import arms
import numpy as np
import pinocchio as pin
import pytest
from scipy.optimize import least_squares, minimize

import srs_ik
from srs_ik import Status

NAMES = arms.here("iiwa14", "gen3", "human_arm", "sia5d", "openarm_left")


def around_reach(arm, rng, nearest, farthest):
    """200 random poses, so far from the shoulder as parts of the arm's length."""
    span = np.linalg.norm(arm.limb.elbow - arm.limb.shoulder) + np.linalg.norm(arm.limb.wrist - arm.limb.elbow)
    for _ in range(200):
        way = rng.normal(size=3)
        way *= span * rng.uniform(nearest, farthest) / np.linalg.norm(way)
        yield pin.SE3(pin.Quaternion(*rng.normal(size=4)).normalized().matrix(), arm.limb.shoulder + way)


def out_of_reach(name, count):
    """Poses whose answer is UNREACHABLE and does not keep the orientation: limits are in the way as well."""
    arm, rng = arms.load(name), arms.generator(name, 77)
    found = 0
    for pose in around_reach(arm, rng, 0.9, 3.0):
        solution = arm.solve(pose)
        if solution.status == Status.UNREACHABLE and solution.orientation_error > 1e-6:
            found += 1
            yield arm, pose, solution, rng
        if found == count:
            return


def errors(arm, pose, q):
    error = arm.verify(pose, q)
    return np.array([error.position, error.orientation])


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_no_other_posture_betters_both_errors(name):
    tried = 0
    for arm, pose, solution, rng in out_of_reach(name, 4):
        tried += 1
        own = errors(arm, pose, solution.q)
        np.testing.assert_allclose(own, [solution.position_error, solution.orientation_error], atol=1e-9)
        assert (solution.q >= arm.lower).all()
        assert (solution.q <= arm.upper).all()
        box = [(max(low, -np.pi), min(high, np.pi)) for low, high in zip(arm.lower, arm.upper, strict=True)]

        def worse(q, arm=arm, pose=pose, own=own):
            """What is least where both errors are lowered by as much as can be, made smooth."""
            return float(np.logaddexp.reduce(200.0 * (errors(arm, pose, q) - own)) / 200.0)

        for _ in range(6):
            found = minimize(worse, rng.uniform(*np.transpose(box)), bounds=box, method="L-BFGS-B").x
            assert (errors(arm, pose, found) - own).max() > -1e-4
    assert tried == 4


HIDDEN = {
    "a valley that turning joint by joint never enters": (
        [
            [0.8803885620393113, -0.44794353349867827, -0.15576447164572604, -0.7039230750477395],
            [-0.4062698278009182, -0.5429061869153295, -0.7349814278113903, 0.5829253904439461],
            [0.24466468247167583, 0.7103516474294799, -0.6599543394396754, 0.24120869148776922],
        ],
        [0.281058, 2.617994, -3.141593, -2.177387, 1.396263, 1.22173, -0.123921],
    ),
    "down a slope on three limits, where Newton's step leads up": (
        [
            [0.3731983645410304, -0.41009955299969025, -0.8321906856804842, -0.12792266939627392],
            [0.05423612607879544, -0.8858193217645352, 0.4608498365157395, 0.649769980172348],
            [-0.926164900723335, -0.2171232042368412, -0.30834411110002047, 0.12138637004415401],
        ],
        [0.893881, -1.492353, -3.141593, -1.954918, -1.396263, -1.396263, -0.349066],
    ),
    "bent beside a saddle of straight postures, near": (
        [
            [0.22101480501510928, 0.7296836570973437, 0.6470813059648526, -0.9032757736551642],
            [0.9745108227862374, -0.139049382637344, -0.1760509172389177, 0.44953323117326155],
            [-0.03848522101565627, 0.6694975950316921, -0.7418165932426672, -0.2889987355816683],
        ],
        [-0.698132, 2.617994, 0.974915, -0.360509, -1.396263, 0.504981, 0.523599],
    ),
    "bent beside a saddle of straight postures, far": (
        [
            [0.314997933874372, 0.6131739582125971, -0.724426668907746, -1.526860359408303],
            [-0.23283395141561256, 0.7898841164225798, 0.5673371428802388, 2.2172088426948813],
            [0.9200894808240495, -0.010038903984824543, 0.39157958026908735, -1.5441443112263749],
        ],
        [-0.698132, 2.617994, 1.22173, -0.05275, -0.623472, -1.396263, -0.349066],
    ),
}
"""Poses, the upper three rows of each, and the postures of `human_arm` that are closest to them."""


@pytest.mark.parametrize("which", HIDDEN)
def test_the_closest_posture_is_found(which):
    rows, close = HIDDEN[which]
    arm = arms.load("human_arm")
    pose = np.vstack([rows, [0.0, 0.0, 0.0, 1.0]])
    reach = arm.limb.upper_arm + arm.limb.forearm

    def measure(q):
        position, angle = errors(arm, pose, q)
        return (position / reach) ** 2 + 2.0 - 2.0 * np.cos(angle)

    assert measure(arm.solve(pose).q) < measure(np.clip(close, arm.lower, arm.upper)) + 1e-6


@pytest.mark.parametrize("name", NAMES)
def test_seeds_choose_the_turn_and_batches_agree(name):
    for arm, pose, solution, rng in out_of_reach(name, 2):
        seed = rng.uniform(np.maximum(arm.lower, -3.0), np.minimum(arm.upper, 3.0))
        seeded = arm.solve(pose, seed=seed)
        assert seeded.status == Status.UNREACHABLE
        free = ~np.isfinite(arm.lower)
        assert (np.abs(seeded.q - seed)[free] <= np.pi + 1e-9).all()
        batch = arm.solve_batch([pose, pose], threads=2)
        np.testing.assert_array_equal(batch.q[1], solution.q)


@pytest.mark.parametrize("distance", [1e3, 1e7, 1e150, 1e299])
def test_far_beyond_all_reach(distance):
    arm = arms.load("iiwa14")
    pose = pin.SE3(pin.rpy.rpyToMatrix(0.1, 2.0, 0.3), np.array([0.3, -0.5, -0.8]) * distance)
    solution = arm.solve(pose)
    assert solution.status == Status.UNREACHABLE
    assert np.isfinite(solution.q).all()
    assert ((solution.q >= arm.lower) & (solution.q <= arm.upper)).all()


STRAIGHT = {"iiwa14": 0.0, "gen3": 0.0, "j2s7s300": np.pi, "rm75": 0.0}


def beyond(name, count):
    """Poses of postures that are almost straight, moved on by up to 10 mm, that no posture meets, and that far."""
    arm, rng = arms.load(name), arms.generator(name, 78)
    low, high = np.maximum(arm.lower, -3.0), np.minimum(arm.upper, 3.0)
    found = 0
    for _ in range(400):
        q = rng.uniform(low, high)
        q[3] = STRAIGHT[name] + rng.normal() * 10.0 ** rng.uniform(-6.0, -2.0)
        pose = arm.forward_kinematics(q)
        far = 10.0 ** rng.uniform(-4.0, -2.0)
        out = pose.translation - arm.limb.shoulder
        moved = pin.SE3(pose.rotation, pose.translation + far * out / np.linalg.norm(out))
        solution = arm.solve(moved)
        if solution.status == Status.UNREACHABLE:
            found += 1
            yield arm, moved, solution, q, far
        if found == count:
            return


@pytest.mark.parametrize("name", [name for name in arms.here(*STRAIGHT) if name in STRAIGHT])
def test_just_out_of_reach_no_posture_with_the_rotation_is_closer(name):
    tried = 0
    for arm, pose, solution, q, far in beyond(name, 10):
        tried += 1
        position, orientation = errors(arm, pose, solution.q)
        assert orientation < 1e-9
        assert position < far + 1e-4
        box = list(zip(np.maximum(arm.lower, -10.0), np.minimum(arm.upper, 10.0), strict=True))

        def turn(x, arm=arm, pose=pose):
            return pin.log3(arm.forward_kinematics(x).rotation.T @ pose.rotation)

        def away(x, arm=arm, pose=pose):
            return 1e4 * float(np.sum((arm.forward_kinematics(x).translation - pose.translation) ** 2))

        for begin in (q, solution.q):
            found = minimize(
                away,
                begin,
                bounds=box,
                constraints={"type": "eq", "fun": turn},
                method="SLSQP",
                options={"maxiter": 300},
            )
            if np.abs(turn(found.x)).max() < 1e-7:
                assert errors(arm, pose, found.x)[0] > position - 1e-4
        batch = arm.solve_batch([pose, pose], threads=2)
        np.testing.assert_array_equal(batch.q[1], solution.q)
    assert tried > 1


def test_where_no_posture_has_an_arm_angle_the_answer_is_close_by():
    # At full stretch a near arm has a part of all arm angles; at the others nothing was answered but zeros.
    arm = srs_ik.load("gen3")
    q = [0.851407071, -0.524061669, 0.379871334, -2.37065425e-04, -0.878854323, -0.210387967, -0.297467241]
    solution = arm.solve(arm.forward_kinematics(q), arm_angle=0.4)
    assert solution.status == Status.UNREACHABLE
    assert solution.position_error < 0.02
    assert solution.orientation_error < 0.02


def test_at_an_arm_angle_that_no_posture_has_the_closer_one_is_answered():
    # Newton's method ends 63 mm from this pose, the nearest exact limb 80 mm.
    arm = srs_ik.load("gen3")
    pose = pin.SE3(pin.exp3(np.array([1.4, -0.1, 1.3])), np.array([-0.6, 0.1, 0.2]))
    solution = arm.solve(pose, arm_angle=0.1)
    assert solution.status == Status.UNREACHABLE
    assert solution.position_error < 0.07
    assert solution.orientation_error < 0.5


@pytest.mark.parametrize("name", arms.here("gen3", "h1_2_left", "rm75"))
def test_what_no_posture_reaches_is_unreachable_with_limits_too(name):
    arm, tried = arms.load(name), 0
    for pose in around_reach(arm, np.random.default_rng(3), 0.9, 1.1):
        if arm.solve(pose, respect_limits=False).status == Status.UNREACHABLE:
            tried += 1
            assert arm.solve(pose).status == Status.UNREACHABLE
    assert tried > 50


def kept_upright(arm, pose, seed):
    """The closest posture in the valley of a seed that keeps the orientation, by SciPy, and its distance, m."""
    reach = arm.limb.upper_arm + arm.limb.forearm

    def off(q):
        there = arm.forward_kinematics(q).homogeneous
        turn = pose[:3, :3].T @ there[:3, :3] - np.eye(3)
        return np.r_[(there[:3, 3] - pose[:3, 3]) / reach, 100.0 * turn.ravel()]

    q = least_squares(off, seed, xtol=1e-14, ftol=1e-14, gtol=1e-14).x
    return q, float(np.linalg.norm(arm.forward_kinematics(q).translation - pose[:3, 3]))


def test_an_elbow_is_not_turned_around_for_what_is_hardly_closer():
    """A near arm that is stretched, and its target a little farther: from micrometres to a centimetre."""
    arm, rng = arms.load("gen3"), arms.generator("stretched", 9)
    compared = 0
    for _ in range(20):
        q = rng.uniform(np.maximum(arm.lower, -2.0), np.minimum(arm.upper, 2.0))
        q[3] = 0.0
        pose, centres = arm.forward_kinematics(q).homogeneous, arm.centres(q)
        way = centres.wrist - centres.shoulder
        pose[:3, 3] += way / np.linalg.norm(way) * 10.0 ** rng.uniform(-5.0, -2.0)
        solution = arm.solve(pose, seed=q)
        near, distance = kept_upright(arm, pose, q)
        if solution.status == Status.UNREACHABLE and np.abs(near - q).max() < 0.8:
            compared += 1
            assert solution.position_error < distance + 6e-5
            assert np.abs(solution.q - q).max() < 1.2 or solution.position_error < distance - 1e-5
    assert compared > 5
