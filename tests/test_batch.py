"""`Arm.solve_batch`: the same answers as one call at a time, bit for bit, on any number of threads."""

import multiprocessing
import subprocess
import sys
import threading
import tracemalloc
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from types import SimpleNamespace

import arms
import numpy as np
import pinocchio as pin
import pytest

from srs_ik import InvalidConfiguration, InvalidPose, Scene, SrsIkError, Status, Task
from srs_ik.kernels.layout.limb import LIMITED, STRAIGHT
from srs_ik.solve import threads as in_threads
from srs_ik.solve.threads import interruptible, processors, run_in_threads, watched

COUNT = 100
NAMES = ("iiwa14", "gen3", "romeo_left")


def poses_of(name, count=COUNT):
    """Poses inside the limits and outside, within reach and out of it."""
    arm = arms.load(name)
    q = np.vstack([arms.configurations(name, count // 2, 51), arms.generator(name, 52).uniform(-3, 3, (count // 2, 7))])
    poses = np.array([arm.forward_kinematics(x).homogeneous for x in q])
    poses[::10, :3, 3] *= 3.0
    return q, poses


def assert_same(one, other):
    """Bit for bit, signs of zeros included."""
    for field in ("q", "status", "branch", "arm_angle", "position_error", "orientation_error"):
        a, b = np.asarray(getattr(one, field)), np.asarray(getattr(other, field))
        assert a.tobytes() == b.tobytes(), field


def test_many_answers_have_no_truth_value():
    """`if batch:` would be true where nothing is solved."""
    arm, far = arms.load("iiwa14"), np.eye(4)
    far[:3, 3] = 9.0
    assert not arm.solve(far)
    for poses in ([far, far], np.empty((0, 4, 4))):
        for batch in (arm.solve_batch(poses), arm.solve_batch(poses, 0.3, all_branches=True)):
            with pytest.raises(TypeError, match=r"\.ok\.all\(\)"):
                bool(batch)
            assert not batch.ok.any()
        with pytest.raises(TypeError, match="counts"):
            bool(arm.intervals_batch(poses))
    assert not arm.solve_path([far, far])


def test_messages_are_read_when_they_are_printed():
    _, poses = poses_of("iiwa14")
    batch = arms.load("iiwa14").solve_batch(poses)
    lines = str(batch.message).splitlines()
    assert lines[0] == f"Messages of {COUNT} answers"
    assert lines[1:6] == [f"{k}: {batch[k].message}" for k in range(5)]
    assert lines[6] == "..."
    assert lines[7:] == [f"{k}: {batch[k].message}" for k in range(COUNT - 5, COUNT)]
    few = arms.load("iiwa14").solve_batch(poses[:1], 0.3, all_branches=True).message
    assert repr(few).splitlines()[1:] == [f"0, {k}: {few(0, k)}" for k in range(8)]


def options_of(name, q):
    rng = arms.generator(name, 53)
    angles, seeds = rng.uniform(-4.0, 4.0, len(q)), q + rng.uniform(-1.0, 1.0, q.shape)
    return {
        "none": ({}, lambda i: {}),
        "one arm angle": ({"arm_angle": 0.3}, lambda i: {"arm_angle": 0.3}),
        "arm angles": ({"arm_angle": angles}, lambda i: {"arm_angle": angles[i]}),
        "one seed": ({"seed": seeds[0]}, lambda i: {"seed": seeds[0]}),
        "seeds": ({"seed": seeds}, lambda i: {"seed": seeds[i]}),
        "seeds at arm angles": (
            {"seed": seeds, "arm_angle": angles},
            lambda i: {"seed": seeds[i], "arm_angle": angles[i]},
        ),
        "branch": ({"branch": 5}, lambda i: {"branch": 5}),
        "branches": ({"branch": np.arange(len(q)) % 8}, lambda i: {"branch": i % 8}),
        "branches and seeds at arm angles": (
            {"branch": list(np.arange(len(q)) % 8), "seed": seeds, "arm_angle": 0.3},
            lambda i: {"branch": i % 8, "seed": seeds[i], "arm_angle": 0.3},
        ),
        "no limits": ({"respect_limits": False}, lambda i: {"respect_limits": False}),
    }


@pytest.mark.parametrize("kind", list(options_of("iiwa14", np.zeros((1, 7)))))
@pytest.mark.parametrize("name", NAMES)
def test_batch_equals_single_calls(name, kind):
    arm = arms.load(name)
    q, poses = poses_of(name)
    batch_options, single_options = options_of(name, q)[kind]
    alone = arm.solve_batch(poses, threads=1, **batch_options)
    assert_same(alone, arm.solve_batch(poses, threads=2, **batch_options))
    assert_same(alone, arm.solve_batch(poses, **batch_options))
    for i, pose in enumerate(poses):
        single = arm.solve(pose, **single_options(i))
        assert_same(alone[i], single)
        assert alone[i].message == single.message == alone.message(i)
    assert alone.solved == np.count_nonzero(alone.ok) < COUNT
    assert alone.solved > 0 or kind == "branch"


@pytest.mark.parametrize("name", NAMES)
def test_all_branches_equal_solve_all(name):
    arm = arms.load(name)
    _, poses = poses_of(name)
    angles = arms.generator(name, 54).uniform(-3.0, 3.0, COUNT)
    for respect_limits in (True, False):
        options = {"arm_angle": angles, "all_branches": True, "respect_limits": respect_limits}
        batch = arm.solve_batch(poses, threads=1, **options)
        assert_same(batch, arm.solve_batch(poses, threads=2, **options))
        assert batch.q.shape == (COUNT, 8, 7)
        assert batch.status.shape == (COUNT, 8)
        assert (batch.branch == np.arange(8)).all()
        for i, pose in enumerate(poses):
            every = arm.solve_all(pose, arm_angle=angles[i], respect_limits=respect_limits)
            assert batch.branch[i][batch.ok[i]].tolist() == every.branch.tolist()
            assert batch.q[i][batch.ok[i]].tobytes() == every.q.tobytes()


@pytest.mark.slow
def test_many_python_threads_at_once():
    arm = arms.load("gen3")
    q, poses = poses_of("gen3")

    def work(i):
        return arm.solve(poses[i], seed=q[i]), arm.verify(poses[i], q[i]), arm.jacobian(q[i]), arm.intervals(poses[i])

    expected = [work(i) for i in range(COUNT)]
    with ThreadPoolExecutor(6) as pool:
        found = list(pool.map(work, list(range(COUNT)) * 3))
        batches = list(pool.map(lambda _: arm.solve_batch(poses, seed=q, threads=2), range(4)))
    for i, (solution, error, J, intervals) in enumerate(found):
        before = expected[i % COUNT]
        assert_same(solution, before[0])
        assert error == before[1]
        assert (before[2] == J).all()
        assert intervals == before[3]
    for batch in batches:
        assert_same(batch, batches[0])


def solved_in_a_process(arm, poses, angles):
    return arm.solve_batch(poses, arm_angle=angles, threads=2).q.tobytes()


@pytest.mark.parametrize("method", [m for m in ("fork", "spawn") if m in multiprocessing.get_all_start_methods()])
def test_several_processes_at_once(method):
    arm = arms.load("iiwa14")
    q, poses = poses_of("iiwa14")
    angles = np.array([arm.arm_angle(x) for x in q])
    expected = solved_in_a_process(arm, poses, angles)
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context(method)) as pool:
        assert set(pool.map(solved_in_a_process, [arm] * 3, [poses] * 3, [angles] * 3)) == {expected}


@pytest.mark.parametrize("all_branches", [False, True])
def test_memory_is_that_of_the_answers(all_branches):
    arm = arms.load("iiwa14")
    q = arms.configurations("iiwa14", 50, 55)
    poses = np.tile([arm.forward_kinematics(x).homogeneous for x in q], (400, 1, 1))
    angles = np.tile([arm.arm_angle(x) for x in q], 400)
    options = {"arm_angle": angles, "all_branches": all_branches}
    if not all_branches:
        options["seed"] = np.tile(q, (400, 1))
    arm.solve_batch(poses[:50], **{k: v[:50] if k != "all_branches" else v for k, v in options.items()})
    tracemalloc.start()
    try:
        batch = arm.solve_batch(poses, **options)
        now, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    given = poses.nbytes + angles.nbytes + (0 if all_branches else options["seed"].nbytes)
    assert batch.q.base.nbytes <= now < peak < batch.q.base.nbytes + 0.1 * (given + batch.q.base.nbytes)


def test_poses_in_any_form_are_the_same():
    arm = arms.load("iiwa14")
    _, poses = poses_of("iiwa14", 40)
    expected = arm.solve_batch(poses)
    frozen = poses.copy()
    frozen.flags.writeable = False
    wide = np.zeros((40, 4, 8))
    wide[:, :, ::2] = poses
    forms = [
        [pin.SE3(T) for T in poses],
        list(poses),
        poses.tolist(),
        tuple(poses),
        frozen,
        np.asfortranarray(poses),
        wide[:, :, ::2],
        np.ascontiguousarray(poses[::-1])[::-1],
        (T for T in poses),
    ]
    for form in forms:
        assert_same(arm.solve_batch(form), expected)
    assert (frozen == poses).all()


def test_no_pose_and_one_pose():
    arm = arms.load("iiwa14")
    for none in ([], np.empty((0, 4, 4))):
        empty = arm.solve_batch(none)
        assert len(empty) == 0
        assert empty.q.shape == (0, 7)
        assert empty.solved == 0
    pose = arm.forward_kinematics(np.full(7, 0.3))
    assert_same(arm.solve_batch([pose])[0], arm.solve(pose))
    assert arm.solve_batch([], arm_angle=0.0, all_branches=True).q.shape == (0, 8, 7)


def test_batches_index_into_solutions():
    arm = arms.load("iiwa14")
    _, poses = poses_of("iiwa14", 20)
    batch = arm.solve_batch(poses, arm_angle=0.1, all_branches=True)
    assert_same(batch[3], arm.solve_batch(poses[3:4], arm_angle=0.1, all_branches=True)[0])
    assert batch[3, 2].branch == 2
    assert batch[3, 2].message == batch.message(3, 2)
    for wrong in ((), (3,), (3, 2, 1)):
        with pytest.raises(IndexError, match=f"message takes 2 indices here, not {len(wrong)}"):
            batch.message(*wrong)
    every = [[one.message for one in batch[k]] for k in range(20)]
    assert np.asarray(batch.message).tolist() == batch.message[:].tolist() == every
    assert batch.message[3, 2] == every[3][2]
    assert batch.message[3].tolist() == every[3]
    assert [row.tolist() for row in batch.message] == every
    alone = arm.solve_batch(poses)
    assert alone.message[:1].tolist() == [alone[0].message]
    assert list(alone.message) == [one.message for one in alone]
    assert len(alone.message[alone.ok]) == alone.solved
    assert repr(batch) == f"BatchSolution({batch.solved} of 160 solved)"
    assert batch[0].status.tolist() == [int(batch[0, k].status) for k in range(8)]
    assert set(batch.status.ravel().tolist()) <= {int(s) for s in Status}


def test_an_index_beyond_poses_and_branches_picks_no_columns():
    arm = arms.load("iiwa14")
    _, poses = poses_of("iiwa14", 20)
    alone, every = arm.solve_batch(poses), arm.solve_batch(poses, 0.1, all_branches=True)
    tasks = arm.solve_task(Task(poses[:, :3, 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]))
    for answers in (alone, tasks, tasks.posture):
        for wrong in ((slice(None), 3), (0, 3), (..., 0, 3)):
            with pytest.raises(IndexError, match="too many indices"):
                answers[wrong]
    with pytest.raises(IndexError, match="too many indices"):
        every[:, :, 3]
    assert_same(alone[..., 3], alone[3])
    assert_same(every[..., 3], every[:, 3])
    assert_same(every[2, ..., 3], every[2, 3])


def test_what_chooses_nothing_beside_all_branches_is_told():
    iiwa = arms.load("iiwa14")
    poses = [iiwa.forward_kinematics([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])]
    every = iiwa.solve_batch(poses, 0.1, all_branches=True)
    for option in ({"seed": np.zeros(7)}, {"branch": 2}):
        with pytest.warns(UserWarning, match="seed and branch choose nothing"):
            assert_same(iiwa.solve_batch(poses, 0.1, all_branches=True, **option), every)


def test_a_bad_pose_is_named():
    arm = arms.load("iiwa14")
    _, poses = poses_of("iiwa14")
    for threads in (1, 2):
        for bad, value in (((70, 0, 3), np.nan), ((70, 1, 1), 4.0)):
            spoilt = poses.copy()
            spoilt[bad] = value
            with pytest.raises(InvalidPose, match=r"\b70\b"):
                arm.solve_batch(spoilt, threads=threads)


@pytest.mark.parametrize("scene", [None, Scene()], ids=["free", "scene"])
@pytest.mark.parametrize("name", ["iiwa14", "gen3"])
def test_every_pose_may_have_a_branch_of_its_own(name, scene):
    """The middle of every interval of several poses: known branches, which Pinocchio confirms to be on their poses."""
    arm = arms.load(name)
    poses = arm.forward_kinematics_batch(arms.configurations(name, 4 if scene else 30, 71))
    found = arm.intervals_batch(poses, scene=scene)
    of_pose = np.repeat(np.arange(len(poses)), found.counts)
    psis = 0.5 * (found.lower + found.upper)
    batch = arm.solve_batch(poses[of_pose], arm_angle=psis, branch=found.branch, scene=scene)
    assert len(set(found.branch.tolist())) > 4
    assert batch.ok.all()
    assert (batch.branch == found.branch).all()
    for q, i, branch in zip(batch.q, of_pose, found.branch, strict=True):
        assert max(arm.verify(poses[i], q)) < 1e-9
        assert arm.branch(q) == branch


def test_of_poses_with_branches_the_bad_one_and_the_hits_are_numbered_among_all():
    arm = arms.load("iiwa14")
    poses = arm.forward_kinematics_batch(arms.configurations("iiwa14", 8, 72))
    scene = Scene()
    scene.add_sphere("everywhere", [0.0, 0.0, 0.5], 3.0)
    batch = arm.solve_batch(poses, branch=np.arange(8), scene=scene)
    assert sorted(batch.collisions) == [(i,) for i in np.flatnonzero(batch.status == Status.COLLISION)]
    assert len(batch.collisions) > 4
    poses[5] = 0.0
    with pytest.raises(InvalidPose, match="the pose 5 of 8"):
        arm.solve_batch(poses, branch=np.arange(8))
    assert len(arm.solve_batch([], branch=[])) == 0


@pytest.mark.parametrize(
    ("options", "error"),
    [
        ({"arm_angle": np.zeros(3)}, InvalidConfiguration),
        ({"arm_angle": np.zeros((4, 1))}, InvalidConfiguration),
        ({"arm_angle": np.nan}, InvalidConfiguration),
        ({"arm_angle": [0.0, 1.0, np.inf, 0.0]}, InvalidConfiguration),
        ({"arm_angle": "zero"}, InvalidConfiguration),
        ({"seed": np.zeros(6)}, InvalidConfiguration),
        ({"seed": np.zeros((3, 7))}, InvalidConfiguration),
        ({"seed": np.full((4, 7), np.nan)}, InvalidConfiguration),
        ({"seed": "home"}, InvalidConfiguration),
        ({"branch": 8}, InvalidConfiguration),
        ({"branch": -1}, InvalidConfiguration),
        ({"branch": 1.0}, InvalidConfiguration),
        ({"branch": [0, 1, 2]}, InvalidConfiguration),
        ({"branch": [0, 1, 2, 8]}, InvalidConfiguration),
        ({"branch": [0.0, 1.0, 2.0, 3.0]}, InvalidConfiguration),
        ({"branch": [[0], [1, 2]]}, InvalidConfiguration),
        ({"branch": [True] * 4}, InvalidConfiguration),
        ({"branch": [0] * 4, "arm_angle": np.zeros(3)}, InvalidConfiguration),
        ({"all_branches": True}, InvalidConfiguration),
        ({"threads": 0}, SrsIkError),
        ({"threads": 1.5}, SrsIkError),
        ({"threads": True}, SrsIkError),
    ],
)
def test_malformed_options_are_refused(options, error):
    arm = arms.load("iiwa14")
    with pytest.raises(error) as raised:
        arm.solve_batch(np.broadcast_to(np.eye(4), (4, 4, 4)), **options)
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize("poses", [np.eye(4), np.zeros((3, 3, 3)), 7, None, "poses", [np.eye(4), np.eye(3)], pin.SE3()])
def test_malformed_poses_are_refused(poses):
    with pytest.raises(InvalidPose):
        arms.load("iiwa14").solve_batch(poses)


@pytest.mark.parametrize("threads", [1, 2, 3, 16, None])
@pytest.mark.parametrize("count", [0, 1, 7, 8, 15, 16, 17, 100, 1001])
@pytest.mark.parametrize("slow", [False, True])
def test_ranges_cover_every_pose_once(count, threads, slow):
    done = np.zeros(count, int)
    together = []
    at_work = set()

    def work(first, last):
        at_work.add(threading.get_ident())
        together.append(len(at_work))
        done[first:last] += 1
        if slow:
            threading.Event().wait(0.001)

    run_in_threads(work, count, threads)
    assert (done == 1).all()
    assert threads is None or max(together, default=1) <= threads
    assert max(together, default=1) <= processors()
    if slow and count >= 100 and threads in (2, 3) and processors() > 1:
        assert max(together) > 1


def test_an_error_in_a_thread_comes_through():
    def work(first, last):
        threading.Event().wait(0.001)
        if first >= 500:
            raise ArithmeticError(first)

    with pytest.raises(ArithmeticError):
        run_in_threads(work, 1000, 2)


def test_far_more_threads_than_processors_are_not_started():
    started = set()

    def work(first, last):
        started.add(threading.get_ident())
        threading.Event().wait(0.0005)

    run_in_threads(work, 10000, 4000)
    assert len(started) <= processors()


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("seconds", [1e-6, 2e-4, 5e-3, 0.05])
def test_no_call_is_long(threads, seconds, monkeypatch):
    """However slow the poses are, a call takes about a tenth of a second, from the second one on.

    Each thread has a clock that nothing but its poses moves: the load of the machine is not asked.
    """
    lengths, clock = [], threading.local()

    def now():
        return getattr(clock, "now", 0.0)

    def work(first, last):
        lengths.append(last - first)
        clock.now = now() + seconds * (last - first)
        threading.Event().wait(1e-4)

    monkeypatch.setattr(in_threads, "time", SimpleNamespace(perf_counter=now))
    run_in_threads(work, int(1.0 / seconds) if seconds > 1e-4 else 100_000, threads)
    if seconds > 1e-4:
        longest = max(lengths[1:], default=0)
        assert longest * seconds < 0.2 or longest == 8
        assert lengths[0] <= 128
    else:
        assert len(lengths) < 60


@pytest.mark.parametrize("threads", [1, 2])
def test_a_watcher_hears_how_far_a_batch_is(threads):
    heard = []

    def work(first, last):
        threading.Event().wait(1e-4 * (last - first))

    with watched(lambda begun, count: heard.append((begun, count))):
        run_in_threads(work, 5000, threads)
    assert len(heard) > 2
    assert all(count == 5000 for _, count in heard)
    assert [begun for begun, _ in heard] == sorted(begun for begun, _ in heard)
    assert heard[-1][0] == 5000
    run_in_threads(work, 500, threads)
    assert heard[-1][1] == 5000


INTERRUPTED = """
import os, signal, sys, threading, time
import numpy as np
import srs_ik

# A shell starts what runs in its background with interruptions ignored, and its children inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)
arm = srs_ik.load(sys.argv[1])
q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
pose = arm.forward_kinematics(q).homogeneous
many = np.repeat(pose[None], int(sys.argv[3]), axis=0)
many[:, 0, 3] += np.linspace(0.0, 0.05, len(many))
call = {
    "solve_batch": lambda poses: arm.solve_batch(poses, seed=q, threads=int(sys.argv[4])),
    "intervals_batch": lambda poses: arm.intervals_batch(poses, threads=int(sys.argv[4])),
    "solve_path": lambda poses: arm.solve_path(poses, seed=q),
}[sys.argv[2]]
call(many[:300])
pressed = []

def press():
    pressed.append(time.perf_counter())
    # How much slower the machine is for what else runs on it: time of the clock for time of a processor.
    busy = time.process_time() - worked
    pressed.append(max(1.0, int(sys.argv[4]) * (pressed[0] - begin) / busy))
    os.kill(os.getpid(), signal.SIGINT)

threading.Timer(1.0, press).start()
worked, begin = time.process_time(), time.perf_counter()
try:
    call(many)
    print("done", time.perf_counter() - begin)
except KeyboardInterrupt:
    print("interrupted", (time.perf_counter() - pressed[0]) / pressed[1])
ended = time.perf_counter()
import atexit
atexit.register(lambda: print("left", (time.perf_counter() - ended) / pressed[1]))
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("call", "count", "threads"),
    [
        ("solve_batch", 1_000_000, 1),
        ("solve_batch", 2_000_000, 2),
        ("intervals_batch", 1_000_000, 1),
        ("solve_path", 400_000, 1),
    ],
)
def test_an_interruption_is_heard_within_a_second(call, count, threads):
    """A second of a machine at rest."""
    command = [sys.executable, "-c", INTERRUPTED, "iiwa14", call, str(count), str(threads)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    (how, after), (_, left) = (line.split() for line in done.stdout.splitlines())
    assert how == "interrupted", done.stdout + done.stderr
    assert float(after) < 1.0
    assert float(left) < 1.0


def test_what_is_interruptible_answers_and_fails_as_it_would_alone():
    assert interruptible(lambda stop: int(stop[0]), worth_it=True) == 0
    with pytest.raises(ArithmeticError):
        interruptible(lambda stop: _fail(), worth_it=True)


def _fail():
    raise ArithmeticError


@pytest.mark.parametrize("name", ["gen3", *arms.here("h1_2_left")])
def test_branches_of_one_pose_at_many_arm_angles_equal_single_calls(name):
    """The curves of a pose are kept as long as it stays the same, and no longer."""
    arm = arms.load(name)
    q = arms.configurations(name, 3, 54)
    q[1, 3] = arm.packed.family[LIMITED, STRAIGHT] + 0.02
    q[1, 5] = 1e-3
    poses = np.array([arm.forward_kinematics(q[i]).homogeneous for i in (0, 1, 1, 1, 2, 1, 1)])
    angles = arms.generator(name, 55).uniform(-3.0, 3.0, len(poses))
    batch = arm.solve_batch(poses, angles, all_branches=True)
    for i in range(len(poses)):
        alone = arm.solve_batch(poses[i : i + 1], angles[i : i + 1], all_branches=True)
        assert np.asarray(batch.q)[i].tobytes() == np.asarray(alone.q)[0].tobytes()
        assert np.asarray(batch.status)[i].tobytes() == np.asarray(alone.status)[0].tobytes()
