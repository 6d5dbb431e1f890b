"""Tasks and their postures: what the points have to satisfy, by vector algebra and sweeps that know no kernel."""

import arms
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_tasks import COUNT, GOOD, X, Y, Z, dot, grasps, length, tasks_of, unit

import srs_ik
from srs_ik import InvalidTask, SrsIkError, Task

LEVEL = 1e-9
SIDES = {"left": 1.0, "right": -1.0}


@pytest.mark.slow
@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("kind", ["none", "grasp", "grasp and roll"])
@pytest.mark.parametrize("name", arms.BUILT_IN)
def test_random_tasks(name, kind, side):
    arm = arms.load(name)
    limb = arm.limb
    x, v, f, g, phi = tasks_of(name)
    p = arm.posture(Task(x, v, f, **grasps(g, phi)[kind]), side)
    assert np.isfinite(p._rows).all()
    S, E, W, H = p.shoulder, p.elbow, p.wrist, p.hand
    # On its circle, and the hand at the end of it all.
    assert np.abs(length(E - S) - limb.upper_arm).max() < 1e-12
    assert np.abs(length(W - E) - limb.forearm).max() < 1e-12
    near = np.abs(length(x - S)) < 10.0
    assert np.abs(length(H - x) - np.abs(p.miss))[near].max() < 1e-12
    if kind == "none":
        assert np.abs(H - (W + limb.hand * unit(W - E))).max() < 1e-12
        assert np.abs(p.direction - unit(W - E)).max() < 1e-12
    else:
        assert np.abs(p.direction - unit(g)).max() < 1e-12
        # The tip of gen3 lies 0.2 mm beside the line through the wrist along its grasp direction.
        assert np.abs(length(H - W) - limb.hand).max() < (1e-6 if (name, kind) == ("gen3", "grasp") else 1e-12)
    # As parallel to the task's normal as any plane through the line to the target.
    clear = length(np.cross(unit(v), unit(f))) > 1e-6
    n = unit(np.cross(v, f)[clear])
    assert np.abs(np.abs(dot(n, p.task_normal[clear])) - 1.0).max() < 1e-12
    assert np.abs(dot(p.task_normal, unit(v))).max() < 1e-12
    line = H if kind == "none" else W
    t = line - S
    along_line = length(t) > 1e-6
    t = unit(np.where(along_line[:, None], t, X))
    assert np.abs(length(p.normal) - 1.0).max() < 1e-12
    for point in (E, W, line):
        assert np.abs(dot(p.normal, point - S)).max() < 1e-12
    a = unit(np.cross(t, np.where(np.abs(t[:, :1]) < 0.7, X, Y)))
    best = np.zeros(COUNT)
    for angle in np.linspace(0.0, np.pi, 60):
        best = np.maximum(best, np.abs(dot(np.cos(angle) * a + np.sin(angle) * np.cross(t, a), p.task_normal)))
    assert (np.abs(dot(p.normal, p.task_normal)) >= best - 1e-12)[along_line].all()
    # The side of the body, and the lower elbow where neither is to a side.
    h = (E - S) - t * dot(E - S, t)[:, None]
    bent = along_line & (length(h) > 1e-6)
    h = unit(h[bent])
    to_a_side = np.abs(h[:, 1]) > 1e-6
    assert (SIDES[side] * h[to_a_side, 1] > 0.0).all()
    tied = np.abs(h[:, 1]) < 0.1 * LEVEL
    assert tied.any()
    assert (h[tied & (np.abs(h[:, 2]) > 1e-6), 2] < 0.0).all()


@pytest.mark.parametrize("kind", ["none", "grasp", "grasp and roll"])
@pytest.mark.parametrize("name", ["iiwa14", "human_arm"])
def test_reached_means_within_the_length_of_the_arm(name, kind):
    arm = arms.load(name)
    limb = arm.limb
    x, v, f, g, phi = tasks_of(name, 2000)
    p = arm.posture(Task(x, v, f, **grasps(g, phi)[kind]))
    lower = limb.forearm + (limb.hand if kind == "none" else 0.0)
    d = length(x - p.shoulder - (0.0 if kind == "none" else limb.hand * unit(g)))
    inside = (d < limb.upper_arm + lower) & (d > abs(limb.upper_arm - lower))
    assert (p.reached == inside).all()
    assert 0 < inside.sum() < 2000
    assert ((p.miss > 0) == (d > limb.upper_arm + lower)).all()


@pytest.mark.parametrize("name", arms.here("iiwa14", "gen3", "human_arm", "openarm_left", "human_left", "med7", "rm75"))
def test_batch_equals_single_calls(name):
    arm = arms.load(name)
    x, v, f, g, phi = tasks_of(name, 160)
    for extra in grasps(g, phi).values():
        for side in SIDES:
            for tie in ("lower", "upper"):
                batch = arm.posture(Task(x, v, f, **extra), side, tie, threads=1)
                assert (
                    batch._rows.tobytes() == arm.posture(Task(x, v, f, **extra), side, tie, threads=2)._rows.tobytes()
                )
                assert len(batch) == 160
                for i in range(160):
                    one = Task(x[i], v[i], f[i], *(directions[i] for directions in extra.values()))
                    single = arm.posture(one, side, tie)
                    assert single._rows.tobytes() == batch[i]._rows.tobytes()
                    assert single.elbow.shape == single.shoulder.shape == (3,)
                    assert type(single.reached) is bool


def test_fields_of_one_task_go_with_many():
    arm = arms.load("iiwa14")
    x, v, f, g, _ = tasks_of("iiwa14", 50)
    one = arm.posture(Task(x, v[0], f[0], g[0]))
    many = arm.posture(Task(x, np.tile(v[0], (50, 1)), np.tile(f[0], (50, 1)), np.tile(g[0], (50, 1))))
    assert one._rows.tobytes() == many._rows.tobytes()
    assert arm.posture(Task(x[:1], v[0], f[0])).elbow.shape == (1, 3)
    assert arm.posture(Task(x[:0], v[0], f[0])).elbow.shape == (0, 3)


def test_known_postures_of_the_human_arm():
    arm = arms.load("human_arm")
    # Forearm and upper arm in the plane of a vertical task: the elbow hangs below the line to the hand.
    p = arm.posture(Task([0.5, 0, 0], X, Z, grasp=X))
    assert p.normal @ Y == pytest.approx(p.task_normal @ Y)
    a = (0.4**2 + 0.37**2 - 0.32**2) / 0.8
    assert p.elbow == pytest.approx([a, 0.0, -np.sqrt(0.37**2 - a**2)])
    assert p.wrist == pytest.approx([0.4, 0, 0])
    assert p.arm_angle == pytest.approx(0.0)  # the reference of the limb is down
    assert arm.posture(Task([0.5, 0, 0], X, Z, grasp=X), tie="upper").elbow[2] == pytest.approx(-p.elbow[2])
    # In a level plane the side of the body decides.
    left, right = (arm.posture(Task([0.5, 0, 0], X, Y, grasp=X), side) for side in SIDES)
    assert left.elbow[1] == pytest.approx(-right.elbow[1]) == pytest.approx(np.sqrt(0.37**2 - a**2))
    # Out of reach with a grasp: stretched towards the wrist point, which is nearer than towards the hand (erratum 9).
    p = arm.posture(Task([1.0, 0, 0], X, Z, grasp=Z))
    towards = unit(np.array([1.0, 0.0, -0.1]))
    assert p.wrist == pytest.approx(0.69 * towards)
    assert p.elbow == pytest.approx(0.37 * towards)
    assert p.hand == pytest.approx(p.wrist + 0.1 * Z)
    assert not p.reached
    assert p.miss == pytest.approx(length(np.array([1.0, 0.0, -0.1])) - 0.69)
    assert length(p.hand - [1, 0, 0]) < length(0.69 * X + 0.1 * Z - X)
    # Too near without a grasp: folded, the elbow behind.
    p = arm.posture(Task([0.02, 0, 0], X, Z))
    assert p.elbow == pytest.approx([-0.37, 0, 0])
    assert p.hand == pytest.approx([0.05, 0, 0])
    assert p.miss == pytest.approx(-0.03)
    assert "folded" in p.message


def test_parallel_directions_have_a_vertical_plane():
    arm = arms.load("iiwa14")
    x = arm.limb.shoulder + np.array([0.4, 0.3, 0.1])
    for sign in (1.0, -1.0):
        p = arm.posture(Task(x, [1, 1, 1], [sign, sign, sign]))
        assert abs(p.task_normal @ unit(np.array([1.0, -1.0, 0.0]))) == pytest.approx(1.0)
    assert np.abs(arm.posture(Task(x, Z, -Z)).task_normal) == pytest.approx(Y)


def test_target_along_the_normal_puts_the_elbow_to_its_side():
    arm = arms.load("human_arm")
    for side, sign in SIDES.items():
        p = arm.posture(Task([0.5, 0, 0], Y, Z), side)
        assert unit(np.cross(X, np.cross(p.elbow, X))) == pytest.approx(sign * Y)
        assert arm.posture(Task([0.0, 0.5, 0], X, Z), side).elbow[2] < 0.0


@settings(deadline=None, max_examples=60)
@given(st.integers(0, 2**32 - 1))
def test_small_changes_of_a_task_change_its_posture_little(seed):
    """Away from the ties, the posture is continuous, also from reached to stretched."""
    rng = np.random.default_rng(seed)
    arm = arms.load("human_arm")
    t = unit(rng.normal(size=3))
    v, f = rng.normal(size=(2, 3))
    n = unit(np.cross(v, f))
    h = np.cross(t, n)
    if abs(h[1]) < 0.2 or length(np.cross(unit(v), unit(f))) < 0.2:
        return
    d = 0.79 + rng.uniform(-1e-10, 1e-10, (40, 1))
    p = arm.posture(Task(d * t, v, f))
    # The height of a flat triangle goes with the root of what it lacks: 1e-10 m are 1e-5 m of the elbow.
    assert length(p.elbow - p.elbow[0]).max() < 3e-5
    p = arm.posture(Task(0.6 * t + rng.uniform(-1e-9, 1e-9, (40, 3)), v, f))
    assert length(p.elbow - p.elbow[0]).max() < 1e-6


def test_the_elbow_angle_agrees_with_the_arm():
    """A posture's points are those of a configuration: Pinocchio's elbow at the posture's arm angle."""
    arm = arms.load("human_arm")
    T = arm.forward_kinematics([0.2, 0.3, -1.0, -1.2, 0.1, 0.2, 0.1])
    p = arm.posture(Task(T.translation, X, Z, grasp=T.rotation[:, 0]))
    solution = arm.solve(T, arm_angle=p.arm_angle, respect_limits=False)
    forward = arms.forward("human_arm")
    assert forward.carried(solution.q, 3, arm.limb.elbow) == pytest.approx(p.elbow, abs=1e-12)


@pytest.mark.parametrize(
    ("wrong", "named"),
    [
        ({"position": [0.4, 0]}, "position"),
        ({"position": "here"}, "position"),
        ({"position": [0.4, np.nan, 0]}, "position"),
        ({"position": np.zeros((2, 2, 3))}, "position"),
        ({"position": [1j, 0, 0]}, "position"),
        ({"velocity": [0, 0, 0]}, "velocity"),
        ({"velocity": None}, "velocity"),
        ({"force": [0, np.inf, 0]}, "force"),
        ({"grasp": [0, 0, 0]}, "grasp"),
        ({"pronosupination": [0, 0, 0]}, "pronosupination"),
        ({"grasp": X, "pronosupination": -2 * X}, "parallel"),
        ({"velocity": np.ones((2, 3)), "force": np.ones((3, 3))}, "velocity 2, force 3"),
        ({"velocity": [[1, 0, 0], [0, 0, 0]]}, "velocity of task 1"),
        ({"force": [[1, 0, 0], [0, 0, np.nan]]}, "force of task 1"),
    ],
)
def test_wrong_tasks(wrong, named):
    with pytest.raises(InvalidTask, match=named) as error:
        Task(**{**GOOD, **wrong})
    assert isinstance(error.value, ValueError)
    assert "\n" not in str(error.value)


def test_wrong_arguments():
    arm = arms.load("iiwa14")
    with pytest.raises(InvalidTask, match="Task"):
        arm.posture([0.4, 0, 0])
    with pytest.raises(InvalidTask, match="left"):
        arm.posture(Task(**GOOD), "port")
    with pytest.raises(InvalidTask, match="lower"):
        arm.posture(Task(**GOOD), tie="middle")
    with pytest.raises(SrsIkError, match="threads"):
        arm.posture(Task(**GOOD | {"position": np.ones((3, 3))}), threads=0)


def test_a_posture_is_true_where_the_hand_reaches_the_task():
    arm = arms.load("iiwa14")
    near, far = (Task(**GOOD | {"position": p}) for p in ([0.4, 0.1, 0.6], [4.0, 0.0, 0.0]))
    assert arm.posture(near)
    assert not arm.posture(far)
    many = arm.posture(Task(**GOOD | {"position": [[0.4, 0.1, 0.6], [4.0, 0.0, 0.0]]}))
    assert many.reached.tolist() == [True, False]
    with pytest.raises(TypeError, match="many postures have no truth value: their reached"):
        bool(many)


def test_fields_are_kept_as_they_were_given():
    task = Task([0.4, 0, 0], 5 * X, [0, 0, 1e-200], grasp=[[1, 2, 3]])
    assert task.count == 1
    assert task.velocity.tolist() == [[5.0, 0.0, 0.0]]
    assert task.force[0, 2] == 1e-200
    assert task.pronosupination is None
    with pytest.raises(ValueError, match="read-only"):
        task.position[0] = 0.0
    assert Task(**GOOD).position.shape == (3,)
    assert "1 tasks" not in repr(Task(**GOOD))
    assert srs_ik.load("human_arm").posture(task).task_normal[0] == pytest.approx(-Y)
