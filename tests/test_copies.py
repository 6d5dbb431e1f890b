"""Copied and pickled arms and answers: as guarded as the first ones, and nothing is compiled for them."""

import copy
import gc
import multiprocessing
import os
import pickle
from concurrent.futures import ProcessPoolExecutor

import arms
import numpy as np
import pytest
from numba.core.dispatcher import Dispatcher

import srs_ik
from srs_ik import Task
from srs_ik.control import TorqueController

COPIES = {
    "pickled": lambda thing: pickle.loads(pickle.dumps(thing)),
    "pickled by the oldest protocol": lambda thing: pickle.loads(pickle.dumps(thing, protocol=2)),
    "copied": copy.copy,
    "deeply copied": copy.deepcopy,
    "twice": lambda thing: pickle.loads(pickle.dumps(copy.deepcopy(thing))),
}
TASK = Task([0.45, 0.1, 0.5], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0])


def arrays_of(arm):
    for owner in (arm, arm.limb):
        yield from ((name, value) for name, value in vars(owner).items() if isinstance(value, np.ndarray))


def compiled() -> tuple[int, int]:
    """Signatures of all functions that Numba has compiled or read in this process, and how often it had to compile."""
    functions = [thing for thing in gc.get_objects() if isinstance(thing, Dispatcher)]
    return sum(len(f.signatures) for f in functions), sum(sum(f.stats.cache_misses.values()) for f in functions)


def ask(arm) -> list:
    """Everything that an arm can be asked, or as much as calls each kind of kernel."""
    q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    pose = arm.forward_kinematics(q)
    poses = np.array([pose.homogeneous] * 9)
    batch = arm.solve_batch(poses, seed=q)
    return [
        arm.solve(pose).q,
        arm.solve(pose, seed=q).q,
        arm.solve(pose, arm_angle=0.2).q,
        arm.solve_all(pose).q,
        arm.solve_all(pose, arm_angle=0.2).q,
        batch.q,
        np.array([[i.branch, i.lower, i.upper] for i in arm.intervals(pose)]),
        np.array([arm.arm_angle(q), arm.branch(q), *arm.arm_angle_jacobian(q), *arm.self_motion_tangent(q)]),
        arm.optimise(pose, "manipulability").q,
        arm.optimise(pose, "gravity_torque").q,
        arm.solve_task(TASK).q,
    ]


def ask_little(arm) -> list:
    """What Numba compiles in a minute."""
    q = np.tile([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2], (9, 1))
    splits = arm.free_splits(arm.forward_kinematics([0.3, 0.0, 0.2, -1.1, 0.4, 0.0, 0.1]))
    return [
        arm.forward_kinematics_batch(q),
        arm.jacobian_batch(q),
        arm.arm_angle_jacobian(q[0]),
        arm.self_motion_tangent(q[0]),
        np.array(arm.posture(TASK).arm_angle),
        np.array(len(splits)),
    ]


@pytest.mark.parametrize("how", COPIES)
def test_arrays_of_a_copy_take_no_changes(how):
    arm = srs_ik.load("iiwa14")
    ask(arm)
    other = COPIES[how](arm)
    for one in (arm, other):
        for name, array in arrays_of(one):
            if not name.startswith("_"):
                with pytest.raises(ValueError, match="read-only"):
                    array[...] = 0.1
    assert {name for name, _ in arrays_of(other)} >= {"lower", "upper", "velocity_limit", "effort_limit", "axes"}


@pytest.mark.jit
def test_nothing_is_compiled_for_copies():
    arm = srs_ik.load("iiwa14")
    moved = arm.with_tool(np.eye(4))
    some = ask if os.environ.get("SRS_IK_JIT") == "all" else ask_little
    expected, expected_moved = some(arm), some(moved)
    before = compiled()
    assert before[0] > 6
    for how in COPIES.values():
        for one, answers in ((arm, expected), (moved, expected_moved)):
            for a, b in zip(some(how(one)), answers, strict=True):
                assert a.tobytes() == b.tobytes()
    assert compiled() == before


def asked_elsewhere(arm):
    return [array.tobytes() for array in ask(arm)], compiled()[1]


@pytest.mark.parametrize("method", ["spawn", "forkserver"])
def test_nothing_is_compiled_in_other_processes(method):
    if method not in multiprocessing.get_all_start_methods():
        pytest.skip(f"there is no {method} here")
    arm = srs_ik.load("iiwa14")
    expected = [array.tobytes() for array in ask(arm)]
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context(method)) as pool:
        answers, misses = pool.submit(asked_elsewhere, arm).result(timeout=300)
    assert answers == expected
    assert misses == 0


@pytest.mark.parametrize("how", [how for how in COPIES if how != "copied"])
def test_answers_can_be_copied(how):
    arm = arms.load("iiwa14")
    q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    pose, far = arm.forward_kinematics(q), np.eye(4)
    far[:3, 3] = 9.0
    poses = np.array([pose.homogeneous, far])
    answers = [
        arm.solve(pose),
        arm.solve(far),
        arm.solve_all(pose),
        arm.solve_all(far),
        arm.solve_batch(poses),
        arm.solve_path([pose, pose]),
        arm.optimise(pose, "manipulability"),
        arm.solve_task(TASK),
        arm.optimise(pose, "clearance", scene=srs_ik.Scene()),
    ]
    for answer in answers:
        other = COPIES[how](answer)
        assert repr(other) == repr(answer)
        if not isinstance(answer, srs_ik.BatchSolution) or isinstance(answer, srs_ik.PathSolution):
            assert bool(other) == bool(answer)
        assert other.q.tobytes() == answer.q.tobytes()
        assert (np.asarray(other.status) == np.asarray(answer.status)).all()
        if not callable(answer.message):
            assert other.message == answer.message
    batch = COPIES[how](answers[4])
    assert [batch.message(i) for i in range(2)] == [answers[4].message(i) for i in range(2)]
    widest = COPIES[how](answers[-1])
    assert widest.objective.value(arm, q) == answers[-1].objective.value(arm, q)
    intervals = arm.intervals(pose)
    assert COPIES[how](intervals) == intervals
    assert COPIES[how](TASK).position.tolist() == TASK.position.tolist()
    with pytest.raises(ValueError, match="read-only"):
        COPIES[how](TASK).position[0] = 1.0


@pytest.mark.parametrize("how", COPIES)
def test_trackers_can_be_copied_whatever_the_elbow_does(how):
    arm = arms.load("iiwa14")
    q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    scene = srs_ik.Scene()
    scene.add_sphere("ball", [0.4, 0.3, 0.8], 0.1)
    for elbow in ("keep", 0.2, "manipulability", TASK, scene):
        assert_goes_on_alike(arm, q, COPIES[how], elbow=elbow)


@pytest.mark.parametrize("how", COPIES)
def test_trackers_with_limits_of_jerk_can_be_copied(how):
    pytest.importorskip("ruckig")
    assert_goes_on_alike(arms.load("iiwa14"), np.full(7, 0.3), COPIES[how], jerk=100.0)


def assert_goes_on_alike(arm, q, how, **options):
    """A copy's updates are those of the tracker that was copied, and move that one nowhere."""
    tracker = arm.tracker(q, 0.01, **options)
    poses = [arm.forward_kinematics(q + 0.01 * min(k, 5)) for k in range(10)]
    tracker.update(arm.forward_kinematics(q + 0.02))
    other, here = how(tracker), tracker.q
    ahead = [other.update(pose).q.tobytes() for pose in poses]
    assert tracker.q.tobytes() == here.tobytes()
    assert [tracker.update(pose).q.tobytes() for pose in poses] == ahead
    for limit in (other.velocity_limit, other.acceleration_limit):
        with pytest.raises(ValueError, match="read-only"):
            limit[0] = 1.0


def tuples_of_arrays():
    arm, q = srs_ik.load("iiwa14"), np.full(7, 0.3)
    controller = TorqueController(arm, [], limits=True)
    path = arm.solve_path([arm.forward_kinematics(q), arm.forward_kinematics(q + 0.1)], seed=q, dt=1.0)
    return {
        "centres": arm.centres(q),
        "solution_derivatives": arm.solution_derivatives(q),
        "samples": path.trajectory().sample(0.5),
        "readings": controller.readings[0],
    }


@pytest.mark.parametrize("name", ["centres", "solution_derivatives", "samples", "readings"])
def test_tuples_of_arrays_are_equal_to_themselves_alone(name):
    mine, other = (tuples_of_arrays()[name] for _ in range(2))
    assert mine == mine
    assert mine != other
    assert not mine == other  # noqa: SIM201
    assert {mine: "mine", other: "other"}[mine] == "mine"
    assert mine in [other, mine]
    first, *_ = mine
    assert first is mine[0]
    for kept, value in zip(pickle.loads(pickle.dumps(mine)), mine, strict=True):
        np.testing.assert_array_equal(kept, value)
