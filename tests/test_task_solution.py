"""`Arm.solve_task`: measured by Pinocchio on the untouched file, and against sweeps over arm angles and rolls."""

import arms
import numpy as np
import pytest
from random_tasks import GOOD, X, Z, dot, grasps, length, tasks_of, unit

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


def wrist_at(arm, T_base_tip):
    """The wrist centre, which moves with the tip."""
    return T_base_tip.act(np.linalg.inv(arm.limb.T_base_tip_zero)[:3] @ [*arm.limb.wrist, 1.0])


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
    # Without a grasp it is the line from wrist to tip that follows the forearm: on gen3, 2 mrad beside the grasp axis.
    assert np.abs(g - p.direction).max() < (2e-3 if name == "gen3" and task.grasp is None else 1e-12)
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
        assert length(elbow - p.elbow[i]) < 1e-11
        assert np.abs(T[i, :3, 3] - p.hand[i]).max() < 1e-11
        assert length(wrist_at(arm, forward(s.q[i])) - p.wrist[i]) < 1e-11
        if task.grasp is None:
            assert length(np.cross(unit(p.wrist[i] - elbow), p.direction[i])) < 1e-11
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


@pytest.mark.slow
@pytest.mark.parametrize("name", arms.here("gen3", "gen3_upstream", "j2s7s300"))
def test_on_the_true_chain_no_elbow_is_aligned_better(name):
    """The elbow axis, against a sweep of the true self-motion by Pinocchio: all branches and arm angles."""
    arm = arms.load("gen3") if name == "gen3" else with_hand(name, [[0, 0, 1], [1, 0, 0]])
    forward, S = arms.forward(name), arm.limb.shoulder
    x, v, f, g, phi = tasks_of(name, 40, 16)
    s = arm.solve_task(Task(x, v, f, g, phi), respect_limits=False)
    compared = 0

    def alignment(q, n):
        across = np.cross(wrist_at(arm, forward(q)) - S, forward.carried(q, 3, arm.limb.elbow) - S)
        return abs(dot(unit(across), n))

    for i in np.flatnonzero(s.ok & s.posture.reached)[:8]:
        n = s.posture.task_normal[i]
        here = alignment(s.q[i], n)
        swept = [
            alignment(q, n)
            for psi in s.arm_angle[i] + np.linspace(-np.pi, np.pi, 61)
            for q in arm.solve_all(s.T_base_tip[i], arm_angle=psi, respect_limits=False).q
        ]
        assert len(swept) > 200
        assert min(swept) < 0.9 * max(swept)
        assert here > max(swept) - 1e-12
        compared += 1
    assert compared == 8


def with_hand(name, hand):
    _, base, tip = arms.PLACES[name]
    return srs_ik.load(arms.file_of(name), base=base, tip=tip, hand=hand)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["grasp", "none"])
@pytest.mark.parametrize("name", ["iiwa14", "human_arm", "humanoid_left", "romeo_left"])
def test_a_free_roll_is_the_most_comfortable(name, kind):
    # Of the last two, the hand lies askew to every wrist axis.
    arm = arms.load(name) if name in arms.BUILT_IN else with_hand(name, unit(np.array([[1, 2, -1], [0.5, -1, 2]])))
    x, v, f, g, _ = tasks_of(name, 320, 12)
    extra = extra_of(kind, g, None)
    s = arm.solve_task(Task(x, v, f, **extra))
    turns = np.linspace(0.0, 2.0 * np.pi, 240, endpoint=False)
    compared = lost = 0
    for i in np.flatnonzero(s.ok & s.posture.reached):
        axis = s.posture.direction[i]
        a = unit(np.cross(axis, X if abs(axis[0]) < 0.7 else Z))
        phi = np.cos(turns)[:, None] * a + np.sin(turns)[:, None] * np.cross(axis, a)
        given = {**{key: values[i] for key, values in extra.items()}, "pronosupination": phi}
        swept = arm.solve_task(Task(x[i], v[i], f[i], **given))
        # Rolls that leave the elbow where it belongs, or else nearer to it than any of the sweep.
        assert s.angle_lost[i] <= swept.angle_lost[swept.ok].min(initial=np.inf) + 1e-12
        if s.angle_lost[i] == 0.0:
            best = margins(arm, swept.q[swept.ok & (swept.angle_lost == 0.0)]).min(axis=1).max(initial=0.0)
            assert margins(arm, s.q[i]).min() >= best - 5e-4
            compared += 1
        lost += s.angle_lost[i] > 0.0
    assert compared >= 10 or name not in arms.BUILT_IN
    assert lost >= 5
    # Nothing is missed where the sweep finds a roll.
    for i in np.flatnonzero(~s.ok & s.posture.reached)[:20]:
        axis = s.posture.direction[i]
        a = unit(np.cross(axis, X if abs(axis[0]) < 0.7 else Z))
        phi = np.cos(turns)[:, None] * a + np.sin(turns)[:, None] * np.cross(axis, a)
        given = {**{key: values[i] for key, values in extra.items()}, "pronosupination": phi}
        assert not arm.solve_task(Task(x[i], v[i], f[i], **given)).ok.any()


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
    if arm.name == "gen3":  # that of the true chain
        return single.posture._rows.tobytes()
    return arm.posture(task, side, tie)._rows.tobytes()


def task_line(name, salt, kind):
    """1,000 tasks along a line, in reach, their directions turning with it."""
    arm, rng = arms.load(name), arms.generator(name, salt)
    reach = arm.limb.upper_arm + arm.limb.forearm + arm.limb.hand
    share = np.linspace(0.0, 1.0, 1000)[:, None]
    ends = np.stack([np.zeros(3), 0.4 * rng.normal(size=3)]) + unit(rng.normal(size=3))
    x = arm.limb.shoulder + 0.6 * reach * unit((1.0 - share) * ends[0] + share * ends[1])
    turning = [unit(a + share * 0.6 * b) for a, b in rng.normal(size=(4, 2, 3))]
    v, f, g, phi = turning
    return {"position": x, "velocity": v, "force": f, **extra_of(kind, g, phi)}


@pytest.mark.parametrize("kind", ["none", "grasp", "grasp and roll"])
@pytest.mark.parametrize("name", arms.BUILT_IN)
def test_joints_follow_a_line_of_tasks_from_seed_to_seed(name, kind):
    """They jump only where the posture's own elbow does, at its rules of side and tie."""
    arm = arms.load(name)
    followed = 0
    for salt in (77, 78, 82, 86):
        fields = task_line(name, salt, kind)
        q, elbow = None, None
        for i in range(1000):
            task = Task(**{key: values[i] for key, values in fields.items()})
            s = arm.solve_task(task, respect_limits=False, seed=q)
            if q is not None and s and np.abs(elbow - s.posture.elbow).max() < 0.02:
                assert np.abs(s.q - q).max() < 0.1
                followed += 1
            q, elbow = s.q, s.posture.elbow
    assert followed > 3500


@pytest.mark.parametrize("name", ["iiwa14", "human_arm"])
def test_without_a_seed_the_branch_follows_the_margins_and_their_order(name):
    """Of two solutions of a joint the one with more room; of equal ones, to 1e-9, that of the lower branch."""
    arm = arms.load(name)
    tied = 0
    for salt in (77, 78):
        s = arm.solve_task(Task(**task_line(name, salt, "grasp and roll")), respect_limits=False)
        assert s.ok.all()
        every = arm.solve_batch(s.T_base_tip, arm_angle=s.arm_angle, all_branches=True, respect_limits=False)
        room = margins(arm, every.q)
        part = np.stack([room[..., :3].min(-1), room[..., 3], room[..., 4:].min(-1)], axis=-1)
        for i in range(1000):
            best = []
            for elbow in (0, 4):
                mine = part[i, elbow : elbow + 4]
                shoulder = 2 if mine[2, 0] > mine[0, 0] + 1e-9 else 0
                wrist = 1 if mine[1, 2] > mine[0, 2] + 1e-9 else 0
                best.append((mine[shoulder + wrist].min(), elbow + shoulder + wrist))
                tied += abs(mine[2, 0] - mine[0, 0]) < 1e-12
            assert s.branch[i] == best[1 if best[1][0] > best[0][0] + 1e-9 else 0][1]
    assert tied > 0 or name != "iiwa14"


def test_a_seed_chooses_turn_and_roll():
    arm = arms.load("gen3")
    q = np.array([0.3, 0.6, -0.2, 1.2, 0.4, 0.7, 5.0])
    T = arm.forward_kinematics(q)
    task = Task(T.translation, T.rotation @ np.array(arm.hand.grasp), Z, grasp=T.rotation @ np.array(arm.hand.grasp))
    for turns in (0.0, 2.0 * np.pi):
        seed = q + np.array([0.0, 0.0, 0.0, 0.0, turns, 0.0, 0.0])
        s = arm.solve_task(task, seed=seed)
        assert s
        assert np.abs(s.q - seed)[[0, 2, 4, 6]].max() < np.pi
        assert s.T_base_tip[:3, :3] == pytest.approx(T.rotation, abs=1e-12)
    with pytest.raises(srs_ik.InvalidConfiguration, match="seed"):
        arm.solve_task(task, seed=[0.0, 1.0])


@pytest.mark.parametrize("name", ["iiwa14", "human_arm"])
def test_no_roll_nearer_to_that_of_the_seed_keeps_the_limits(name):
    arm = arms.load(name)
    x, v, f, g, _ = tasks_of(name, 250, 18)
    seeds = arms.configurations(name, 250, 19)
    s = arm.solve_task(Task(x, v, f, g), seed=seeds)
    across = np.array(arm.hand.pronosupination)
    same = moved = 0
    for i in np.flatnonzero(s.ok & (s.angle_lost == 0.0)):
        axis, T = unit(g[i]), s.T_base_tip[i]
        phi = arms.forward(name)(seeds[i]).rotation @ across
        if length(np.cross(phi, axis)) < 0.1:
            continue
        phi = unit(phi - axis * dot(axis, phi))
        here = T[:3, :3] @ across
        away = np.arctan2(dot(axis, np.cross(phi, here)), dot(phi, here))
        same += abs(away) < 1e-9
        moved += abs(away) > 1e-2
        for share in (0.0, 0.3, 0.6, 0.95) if abs(away) > 1e-2 else ():
            turn = share * away
            nearer = np.cos(turn) * phi + np.sin(turn) * np.cross(axis, phi)
            pose = arm.solve_task(Task(x[i], v[i], f[i], g[i], nearer)).T_base_tip
            assert not arm.solve(pose, arm_angle=s.posture.arm_angle[i], branch=int(s.branch[i]))
    assert same > 0
    assert moved > 1


def test_seeds_of_a_batch_are_those_of_its_tasks():
    for name in ("iiwa14", "gen3"):
        arm = arms.load(name)
        x, v, f, g, _ = tasks_of(name, 40, 17)
        seeds = arms.configurations(name, 40, 18)
        every = arm.solve_task(Task(x, v, f, g), seed=seeds)
        for i in range(0, 40, 3):
            one = arm.solve_task(Task(x[i], v[i], f[i], g[i]), seed=seeds[i])
            assert one._row.tobytes() == every[i]._row.tobytes()


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


@pytest.mark.parametrize("name", arms.here("openarm_left"))
def test_a_tool_beside_the_grasp_line(name):
    """The tip of OpenArm lies 4.5 mm beside the line through its wrist: the roll moves the wrist."""
    arm = with_hand(name, [[0, 0, 1], [1, 0, 0]])
    rng = arms.generator(name, 14)
    x = arm.limb.shoulder + 0.3 * unit(rng.normal(size=(200, 3)))
    v, f, g, phi = rng.normal(size=(4, 200, 3))
    for extra in grasps(g, phi).values():
        s = arm.solve_task(Task(x, v, f, **extra), respect_limits=False)
        p = s.posture
        assert s.solved > 100
        for i in np.flatnonzero(s.ok & p.reached):
            T = arm.forward_kinematics(s.q[i])
            assert length(T.translation - x[i]) < 1e-11
            assert length(arms.forward(name).carried(s.q[i], 3, arm.limb.elbow) - p.elbow[i]) < 1e-11
            if extra:
                assert T.rotation[:, 2] == pytest.approx(unit(g[i]), abs=1e-11)
                assert length(wrist_at(arm, T) - p.wrist[i]) < 1e-11
            else:
                assert length(np.cross(x[i] - p.wrist[i], p.wrist[i] - p.elbow[i])) < 1e-12


def test_an_arm_whose_hand_is_not_known():
    arm = arms.load("made_offsets")
    assert arm.posture(Task(**GOOD)).elbow.shape == (3,)
    with pytest.raises(InvalidTask, match=r"load it with hand=\(grasp, pronosupination\)"):
        arm.solve_task(Task(**GOOD))
    with pytest.raises(InvalidTask, match="side"):
        arms.load("iiwa14").solve_task(Task(**GOOD), "up")
    with pytest.raises(InvalidTask, match="Task"):
        arms.load("iiwa14").solve_task(np.eye(4))
