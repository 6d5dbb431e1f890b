"""`Arm.solve_task`: measured by Pinocchio on the untouched file, and against sweeps over arm angles and rolls."""

import arms
import numpy as np
import pytest
from test_task import GOOD, X, Z, dot, grasps, length, tasks_of, unit

import srs_ik
from srs_ik import InvalidTask, Status, Task

COUNT = 1500
KINDS = ["none", "grasp", "grasp and roll", "roll"]


def extra_of(kind, g, phi):
    return {"pronosupination": phi} if kind == "roll" else grasps(g, phi)[kind]


def solved(name, kind, limits, count=COUNT, salt=10):
    x, v, f, g, phi = tasks_of(name, count, salt)
    task = Task(x, v, f, **extra_of(kind, g, phi))
    return task, arms.load(name).solve_task(task, "left", limits)


def wrapped(a):
    return (a + np.pi) % (2.0 * np.pi) - np.pi


def margins(arm, q):
    """(..., 7) 1 in the middle of a joint's range, 0 on a limit; 1 for a joint without limits."""
    wide = ~np.isfinite(arm.upper - arm.lower)
    lower, upper = np.where(wide, -1.0, arm.lower), np.where(wide, 1.0, arm.upper)
    return np.where(wide, 1.0, 1.0 - np.abs(2.0 * q - lower - upper) / (upper - lower))


@pytest.mark.parametrize("limits", [True, False])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", arms.BUILT_IN)
def test_answers_are_what_they_say(name, kind, limits):
    arm, forward = arms.load(name), arms.forward(name)
    task, s = solved(name, kind, limits, 300 if name == "gen3" else COUNT)
    p = s.posture
    assert np.isfinite(s._rows).all()
    assert s.solved > 50
    T = s.T_base_tip
    assert (T[:, :3, 3] == task.position).all()
    # The hand lies as the task wants it.
    g, phi = (T[:, :3, :3] @ np.array(axis) for axis in arm.hand)
    assert np.abs(g - p.direction).max() < (2e-3 if (name, kind[:4]) == ("gen3", "none") or name == "gen3" else 1e-12)
    if kind == "grasp and roll":
        across = task.pronosupination - g * dot(task.pronosupination, g)[:, None]
        assert np.abs(phi - unit(across)).max() < 1e-9
    if kind == "roll":
        clear = length(np.cross(p.direction, unit(task.pronosupination))) > 0.1
        assert (dot(phi, task.pronosupination)[clear] > 0.0).all()
        assert np.abs(dot(np.cross(p.direction, unit(task.pronosupination)), phi))[clear].max() < 2e-3
    near = length(task.position - p.shoulder) < 10.0
    for i in np.flatnonzero(near)[::5]:
        T_base_tip = forward(s.q[i])
        assert abs(length(T_base_tip.translation - T[i, :3, 3]) - s.position_error[i]) < 1e-12
        if s.ok[i]:
            assert np.abs(T_base_tip.rotation - T[i, :3, :3]).max() < 1e-10
    if limits:
        assert (s.q >= arm.lower).all()
        assert (s.q <= arm.upper).all()
    else:
        assert (s.angle_lost[s.ok] == 0.0).all()
    # The elbow is where the posture has it, unless the answer says otherwise.
    kept = s.ok & (s.angle_lost == 0.0) & p.reached
    assert kept.sum() > 10
    for i in np.flatnonzero(kept)[::5]:
        elbow = forward.carried(s.q[i], 3, arm.limb.elbow)
        if name == "gen3":  # the posture is that of the nearest exact limb: its plane is kept, not its triangle
            assert abs(dot(p.normal[i], elbow - p.shoulder[i])) < 1e-9
            assert dot(elbow - p.elbow[i], elbow - p.elbow[i]) < dot(elbow - p.shoulder[i], elbow - p.shoulder[i])
        else:
            assert length(elbow - p.elbow[i]) < 1e-11
    # Out of reach: as near as stretched or folded arms get, where limits do not interfere.
    if name != "gen3" and not limits and kind not in ("none", "roll"):
        out = s.status == Status.UNREACHABLE
        assert out.any()
        assert np.abs(s.position_error - np.abs(p.miss))[out & near].max() < 1e-12
        assert s.orientation_error[out].max() < 1e-12
        assert (out == ~p.reached).all()


@pytest.mark.parametrize("name", arms.BUILT_IN)
def test_the_angle_lost_is_the_least(name):
    """No arm angle nearer to the task's is feasible: not by `intervals`, and not by a sweep of single solutions."""
    arm = arms.load(name)
    _, s = solved(name, "grasp and roll", True, 200 if name == "gen3" else 600)
    lost = 0
    for i in range(len(s)):
        T, wanted = s.T_base_tip[i], s.posture.arm_angle[i]
        if s.status[i] == Status.UNREACHABLE:
            continue
        ends = [(i.lower, i.upper) for i in arm.intervals(T)]
        inside = [((wanted - a) % (2 * np.pi)) <= b - a + 1e-9 for a, b in ends]
        nearest = min((min(abs(wrapped(wanted - a)), abs(wrapped(wanted - b))) for a, b in ends), default=np.inf)
        nearest = 0.0 if any(inside) else nearest
        if not s.ok[i]:
            assert not ends or name == "gen3"
            assert not arm.solve(T)
            continue
        assert s.angle_lost[i] == pytest.approx(nearest, abs=1e-8)
        assert s.angle_lost[i] == pytest.approx(abs(wrapped(s.arm_angle[i] - wanted)), abs=1e-9)
        if s.angle_lost[i] > 0.01:
            lost += 1
            for share in np.linspace(0.05, 0.99, 12):
                for sign in (1.0, -1.0):
                    assert not arm.solve_all(T, arm_angle=wanted + sign * share * s.angle_lost[i])
    assert lost >= 10


@pytest.mark.parametrize("kind", ["grasp", "none"])
@pytest.mark.parametrize("name", ["iiwa14", "human_arm"])
def test_a_free_roll_is_the_most_comfortable(name, kind):
    arm = arms.load(name)
    x, v, f, g, _ = tasks_of(name, 320, 12)
    extra = extra_of(kind, g, None)
    s = arm.solve_task(Task(x, v, f, **extra))
    turns = np.linspace(0.0, 2.0 * np.pi, 240, endpoint=False)
    compared = 0
    for i in np.flatnonzero(s.ok & s.posture.reached):
        axis = s.posture.direction[i]
        a = unit(np.cross(axis, X if abs(axis[0]) < 0.7 else Z))
        phi = np.cos(turns)[:, None] * a + np.sin(turns)[:, None] * np.cross(axis, a)
        given = {**{key: values[i] for key, values in extra.items()}, "pronosupination": phi}
        swept = arm.solve_task(Task(x[i], v[i], f[i], **given))
        # Rolls that leave the elbow where it belongs, or else as near as any of the sweep.
        assert s.angle_lost[i] <= swept.angle_lost[swept.ok].min(initial=np.inf) + 1e-9
        if s.angle_lost[i] == 0.0:
            best = margins(arm, swept.q[swept.ok & (swept.angle_lost == 0.0)]).min(axis=1).max(initial=0.0)
            assert margins(arm, s.q[i]).min() >= best - 5e-4
            compared += 1
    assert compared >= 10


def test_a_free_roll_puts_a_continuous_joint_at_zero():
    arm = arms.load("gen3")
    x, v, f, g, _ = tasks_of("gen3", 300, 15)
    s = arm.solve_task(Task(x, v, f, grasp=g))
    # Exactly zero on the nearest exact limb, whose wrist is up to 6 mm away from the axes of the true one: about 6 mm
    # over a lever that shrinks with the sines of joints 4 and 6.
    kept = s.ok & (s.angle_lost == 0.0) & (np.abs(np.sin(s.q[:, [3, 5]])).min(axis=1) > 0.2)
    assert kept.sum() > 40
    assert np.abs(s.q[kept, 6]).max() < 0.1


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", arms.BUILT_IN)
def test_batch_equals_single_calls(name, kind):
    arm = arms.load(name)
    x, v, f, g, phi = tasks_of(name, 70, 13)
    extra = extra_of(kind, g, phi)
    for side, limits, tie in (("left", True, "lower"), ("right", False, "upper")):
        one = arm.solve_task(Task(x, v, f, **extra), side, limits, tie, threads=1)
        two = arm.solve_task(Task(x, v, f, **extra), side, limits, tie, threads=2)
        assert one._rows.tobytes() == two._rows.tobytes()
        for i in range(0, 70, 3):
            task = Task(x[i], v[i], f[i], **{key: values[i] for key, values in extra.items()})
            single = arm.solve_task(task, side, limits, tie)
            assert single._row.tobytes() == one[i]._row.tobytes()
            assert single.message == one[i].message == one.message(i)
            assert single.posture._rows.tobytes() == arm_posture(arm, task, single, side, tie)


def arm_posture(arm, task, single, side, tie):
    """What `Arm.posture` says, with the roll that was chosen where that moves the wrist."""
    if task.grasp is not None and task.pronosupination is None and arm.name == "gen3":
        return single.posture._rows.tobytes()
    return arm.posture(task, side, tie)._rows.tobytes()


def test_both_sides_and_statuses_of_the_human_arm():
    arm = arms.load("human_arm")
    down = arm.solve_task(Task([0.4, 0.1, -0.2], X, Z, grasp=X))
    assert down
    assert down.angle_lost == 0.0
    assert "Solved in branch" in down.message
    inward = arm.solve_task(Task([0.4, 0.1, -0.2], X, [0, 1, 1], grasp=X, pronosupination=Z), "right")
    assert inward
    assert inward.angle_lost > 0.0
    assert "deg from where the task wants it" in inward.message
    assert arm.solve_task(Task([0.9, 0.1, -0.2], X, Z, grasp=X)).status == Status.UNREACHABLE
    behind = arm.solve_task(Task([-0.4, 0.0, 0.3], X, Z, grasp=-X, pronosupination=Z))
    assert behind.status == Status.OUT_OF_LIMITS
    assert behind.message.startswith("The pose is within reach")


def test_joints_move_continuously_as_the_arm_comes_to_be_stretched():
    """Also where the elbow bends to one side alone: the straight arm keeps the roll with which it gets there."""
    arm = arms.load("human_arm")
    towards = unit(np.array([0.8, 0.1, -0.2]))
    lengths = 0.79 + np.concatenate([-np.geomspace(1e-6, 1e-13, 30), [0.0], np.geomspace(1e-13, 0.1, 30)])
    s = arm.solve_task(Task(lengths[:, None] * towards, X, [0, 1, 2], pronosupination=Z))
    assert (s.angle_lost == 0.0).all()
    assert (s.ok == (lengths < 0.79 + 1e-9)).all()
    # The bend goes with the root of what the arm lacks: 1e-6 m are 0.003 rad.
    assert np.abs(s.q - s.q[-1]).max() < 5e-3


def test_a_tool_beside_the_grasp_line():
    """The tip of OpenArm lies 4.5 mm beside the line through its wrist: the roll moves the wrist."""
    arm = srs_ik.load(
        arms.file_of("openarm_left"), base="openarm_left_link0", tip="openarm_left_hand", hand=[[0, 0, 1], [1, 0, 0]]
    )
    rng = arms.generator("openarm_left", 14)
    x = arm.limb.shoulder + 0.3 * unit(rng.normal(size=(200, 3)))
    v, f, g, phi = rng.normal(size=(4, 200, 3))
    for extra in grasps(g, phi).values():
        s = arm.solve_task(Task(x, v, f, **extra), respect_limits=False)
        p = s.posture
        assert s.solved > 100
        for i in np.flatnonzero(s.ok & p.reached):
            T = arm.forward_kinematics(s.q[i])
            assert length(T.translation - x[i]) < 1e-11
            assert length(arms.forward("openarm_left").carried(s.q[i], 3, arm.limb.elbow) - p.elbow[i]) < 1e-11
            if extra:
                assert T.rotation[:, 2] == pytest.approx(unit(g[i]), abs=1e-11)
                wrist = T.act(np.linalg.inv(arm.limb.T_base_tip_zero)[:3] @ [*arm.limb.wrist, 1.0])
                assert length(wrist - p.wrist[i]) < 1e-11
            else:
                assert length(np.cross(x[i] - p.wrist[i], p.wrist[i] - p.elbow[i])) < 1e-12


def test_an_arm_whose_hand_is_not_known():
    arm = arms.load("med7")
    assert arm.posture(Task(**GOOD)).elbow.shape == (3,)
    with pytest.raises(InvalidTask, match=r"load it with hand=\(grasp, pronosupination\)"):
        arm.solve_task(Task(**GOOD))
    with pytest.raises(InvalidTask, match="side"):
        arms.load("iiwa14").solve_task(Task(**GOOD), "up")
    with pytest.raises(InvalidTask, match="Task"):
        arms.load("iiwa14").solve_task(np.eye(4))
