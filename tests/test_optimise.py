"""`Arm.optimise`: never worse than a dense sweep, on exact and near arms; statuses and input."""

from itertools import pairwise

import arms
import chains
import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from objective_parameters import NAMES, PARAMETERS
from oracles import distance, inside, limbs, random_angles, random_limb, unit
from scipy.optimize import minimize_scalar

import srs_ik
from srs_ik import Interval, InvalidPose, InvalidTask, Objective, Optimum, Solution, Status
from srs_ik.kernels.entries import optimum as entries
from srs_ik.kernels.layout import search as at

JACOBIAN = ("force_velocity_ratio", "twist", "wrench", "manipulability")
COUNT = 720


def sweep(arm, pose, respect_limits=True):
    """(n, 7) postures in every branch all around the circle, those that meet the pose."""
    angles = np.linspace(-np.pi, np.pi, COUNT, endpoint=False)
    poses = np.broadcast_to(pose.homogeneous, (COUNT, 4, 4))
    batch = arm.solve_batch(poses, arm_angle=angles, all_branches=True, respect_limits=respect_limits)
    return batch.q[batch.ok]


def random_parameters(rng, arm, name):
    parameters = {key: rng.normal(size=np.size(value)) for key, value in PARAMETERS[name].items()}
    if name == "reference_posture":
        limited = np.isfinite(arm.upper)
        parameters["reference"] = rng.uniform(np.where(limited, arm.lower, -3), np.where(limited, arm.upper, 3))
    return parameters


def swept_values(arm, objective, Q):
    """(n, 1 or 2) values of postures; continuous joints in the turn that suits the objective."""
    if objective.name == "reference_posture":
        reference = objective.parameters["reference"]
        turn = 2.0 * np.pi * np.round((reference - Q) / (2.0 * np.pi))
        Q = Q + np.where(np.isinf(arm.upper), turn, 0.0)
    return np.array([objective.values(arm, q) for q in Q])


def assert_as_good_as(arm, optimum, values):
    """No posture of a sweep is better, to 1e-9 relative."""
    objective = optimum.objective
    sign = -1.0 if objective.maximise else 1.0
    first = sign * values[:, 0]
    slack = 1e-9 * np.abs(first).min() + 1e-15
    if objective.second < 0:
        assert sign * optimum.value <= first.min() + slack
        return
    best = arm.optimise(
        arm.forward_kinematics(optimum.q), Objective(objective.name, **objective.parameters, tolerance=0)
    )
    lowest = sign * best.value
    assert lowest <= first.min() + slack
    cap = lowest + objective.tolerance * abs(lowest)
    assert sign * optimum.value <= cap + slack
    rivals = -sign * values[first <= cap, 1]
    if len(rivals):
        assert -sign * optimum.second_value <= rivals.min() + 1e-9 * np.abs(rivals).min()


@pytest.mark.slow
@pytest.mark.parametrize("robot", arms.here("iiwa14", "gen3", "human_arm", "sia5d", "romeo_left", "j2s7s300"))
@pytest.mark.parametrize("name", NAMES)
def test_no_posture_of_a_sweep_is_better(robot, name):
    arm, forward, rng = arms.load(robot), arms.forward(robot), arms.generator(robot, 50)
    if name == "gravity_torque" and not any(inertia.mass > 0.0 for inertia in arm.model.inertias):
        pytest.skip("the file has no masses")
    for known in arms.configurations(robot, 6, 51):
        pose = forward(known)
        optimum = arm.optimise(pose, name, **random_parameters(rng, arm, name))
        assert optimum.status is Status.OK
        assert max(distance(pose, forward(optimum.q))) < 1e-9
        assert inside(optimum.q, arm.lower, arm.upper)
        slack = 1e-9
        assert optimum.arm_angle in Interval(0, optimum.interval.lower - slack, optimum.interval.upper + slack)
        Q = np.vstack([sweep(arm, pose), known])
        assert_as_good_as(arm, optimum, swept_values(arm, optimum.objective, Q))


@pytest.mark.parametrize("robot", ["iiwa14", "gen3"])
@pytest.mark.parametrize("name", NAMES)
def test_without_limits_no_posture_of_a_sweep_is_better(robot, name):
    arm, forward, rng = arms.load(robot), arms.forward(robot), arms.generator(robot, 52)
    for known in rng.uniform(-np.pi, np.pi, (2, 7)):
        pose = forward(known)
        optimum = arm.optimise(pose, name, respect_limits=False, **random_parameters(rng, arm, name))
        assert optimum.status is Status.OK
        assert max(distance(pose, forward(optimum.q))) < 1e-9
        if optimum.objective.second < 0 and name != "reference_posture":
            values = swept_values(arm, optimum.objective, sweep(arm, pose, respect_limits=False))
            assert_as_good_as(arm, optimum, values)


@pytest.mark.slow
@settings(max_examples=15)
@given(limbs())
def test_on_random_limbs_no_posture_of_a_sweep_is_better(limb):
    arm = srs_ik.load(limb.model, base="base", tip="tool")
    for name in JACOBIAN:
        known = limb.configuration()
        pose = arm.forward_kinematics(known)
        optimum = arm.optimise(pose, name, **random_parameters(limb.rng, arm, name))
        assert optimum.status is Status.OK
        Q = np.vstack([sweep(arm, pose), known])
        assert_as_good_as(arm, optimum, swept_values(arm, optimum.objective, Q))


@settings(max_examples=15)
@given(limbs(miss=0.005))
def test_on_random_near_limbs_the_known_posture_is_not_better(limb):
    arm = srs_ik.load(limb.model, base="base", tip="tool")
    for name in JACOBIAN:
        known = limb.configuration()
        optimum = arm.optimise(arm.forward_kinematics(known), name, **random_parameters(limb.rng, arm, name))
        assert optimum.status is Status.OK
        assert_as_good_as(arm, optimum, swept_values(arm, optimum.objective, known[None]))


def test_lexicographic_tolerance_trades_the_first_value_for_the_second():
    arm = arms.load("iiwa14")
    for q in arms.configurations("iiwa14", 10, 53):
        pose = arm.forward_kinematics(q)
        for name, sign in (("force_then_velocity", 1.0), ("velocity_then_force", -1.0)):
            found = [arm.optimise(pose, name, **PARAMETERS[name], tolerance=x) for x in (0.0, 1e-3, 0.1, 0.5)]
            best = found[0].value
            seconds = [sign * optimum.second_value for optimum in found]
            assert all(b >= a - 1e-9 * abs(a) for a, b in pairwise(seconds))
            for optimum in found:
                assert sign * optimum.value <= sign * best + (optimum.objective.tolerance + 1e-9) * abs(best)


RISING = (
    chains.Line((-0.6401, 0.49095, -0.59097), (-380.32, 261.88, 52.22), chains.CONTINUOUS),
    chains.Line((0.71959, 0.11361, -0.68504), (-380.32, 261.88, 52.22), (-2.577, 1.8661)),
    chains.Line((-0.26918, -0.86375, -0.426), (-380.32, 261.88, 52.22), (-2.3202, 2.8082)),
    chains.Line((-0.07219, 0.35189, -0.93325), (-649.48, 427.16, 67.07), (-1.4119, 2.0711)),
    chains.Line((-0.83107, 0.06655, -0.55217), (-429.72, 542.95, 162.02), chains.CONTINUOUS),
    chains.Line((-0.14279, -0.98507, 0.09619), (-429.72, 542.95, 162.02), (-2.469, 1.6776)),
    chains.Line((-0.53752, 0.15878, 0.82816), (-429.72, 542.95, 162.02), chains.CONTINUOUS),
)
"""A limb with a pose whose best postures by a first objective lie in two stretches, parted by a low rise."""


def limited(model, **limits):
    """A copy of a model of seven joints with other limits."""
    model = model.copy()
    model.lowerPositionLimit, model.upperPositionLimit = (np.array(limits[side], float) for side in ("lower", "upper"))
    return model


@pytest.mark.parametrize("joint", [1, 3, 5, 7])
def test_of_a_joint_that_cannot_move_the_best_of_all_postures_is_taken(joint):
    # Each interval is one arm angle.
    iiwa14, rng = arms.load("iiwa14"), np.random.default_rng(joint)
    lower, upper = iiwa14.lower.copy(), iiwa14.upper.copy()
    lower[joint - 1] = upper[joint - 1] = 0.3
    arm = srs_ik.load(limited(iiwa14.model, lower=lower, upper=upper), base=iiwa14.base, tip=iiwa14.tip)
    for known in rng.uniform(arm.lower, arm.upper, (20, 7)):
        pose = arm.forward_kinematics(known)
        postures = np.array([solution.q for solution in arm.solve_all(pose)])
        best = arm.optimise(pose, "manipulability")
        assert best.status is Status.OK
        assert inside(best.q, arm.lower, arm.upper)
        assert max(distance(pose, arm.forward_kinematics(best.q))) < 1e-9
        assert best.value >= max(srs_ik.manipulability(arm.jacobian(q)) for q in postures) - 1e-12
        nearest = arm.optimise(pose, lambda q: (q[1] - 0.2) ** 2)
        assert nearest.value <= ((postures[:, 1] - 0.2) ** 2).min() + 1e-12
        task = {"force": unit(rng), "velocity": unit(rng)}
        least = min(float(((task["force"] @ arm.jacobian(q)[:3]) ** 2).sum()) for q in postures)
        assert arm.optimise(pose, "force_then_velocity", **task).value <= 1.01 * least + 1e-12


def test_where_two_sums_are_free_a_tolerance_is_kept():
    # Shoulder and wrist singular at once: between two samples a posture is on their line, not elsewhere on the surface.
    axes = "0 -1 0", "-1 0 0", "0 0 1", "0 1 0", "0 0 -1", "-1 0 0", "0 -1 0"
    limits = (0.5, 4.0), (0.2, 2.5), (-3.5, -0.4), (0.3, 2.5), (1.0, 5.5), (-2.4, -0.3), (2.0, 9.0)
    joints = "".join(
        f'<link name="l{j + 1}"/><joint name="j{j + 1}" type="revolute"><parent link="l{j}"/><child link="l{j + 1}"/>'
        f'<origin xyz="0 0 {(0.0, 0.2263, 0.2802)[max(j - 2, 0) if j < 5 else 0]}"/><axis xyz="{axes[j]}"/>'
        f'<limit lower="{limits[j][0]}" upper="{limits[j][1]}" velocity="2" effort="9"/></joint>'
        for j in range(7)
    )
    tool = '<link name="tool"/><joint name="hand" type="fixed"><parent link="l7"/><child link="tool"/>'
    arm = srs_ik.load(f'<robot name="r"><link name="l0"/>{joints}{tool}<origin xyz="0 0 0.155"/></joint></robot>')
    right = np.pi / 2.0
    pose = arm.forward_kinematics([np.pi, right, -right, right, 3.0 * right, -right, 9.0])
    force, velocity = np.array([-1.025, -0.949, -0.543]), np.array([0.723, -1.067, 0.71])
    best = arm.optimise(pose, "force_then_velocity", force=force, velocity=velocity, tolerance=0.0)
    for tolerance in (1e-3, 0.01, 0.02, 0.03, 0.05, 0.1):
        found = arm.optimise(pose, "force_then_velocity", force=force, velocity=velocity, tolerance=tolerance)
        first, second = (
            ((direction / np.linalg.norm(direction) @ arm.jacobian(found.q)[:3]) ** 2).sum()
            for direction in (force, velocity)
        )
        assert found.value == pytest.approx(first, rel=1e-12)
        assert found.second_value == pytest.approx(second, rel=1e-12)
        assert found.value <= best.value * (1.0 + tolerance) * (1.0 + 1e-9)
        assert found.second_value >= best.second_value - 1e-9


@pytest.mark.parametrize("name", ["wrench", "twist", "gravity_torque"])
def test_where_sums_are_free_at_once_no_posture_of_the_self_motion_is_better(name):
    arm, rng = arms.load("iiwa14"), np.random.default_rng(45)
    for straight in [(3, 5), (1, 5), (1, 3), (1, 3, 5)] * 3:
        known = random_angles(rng, arm.lower, arm.upper)
        known[list(straight)] = 0.0
        pose = arm.forward_kinematics(known)
        best = arm.optimise(pose, name, **random_parameters(rng, arm, name))
        assert max(distance(pose, arm.forward_kinematics(best.q))) < 1e-9
        assert inside(best.q, arm.lower, arm.upper)
        Q = np.vstack([known, *(motion.q for motion in arm.self_motion(pose, count=91))])
        assert_as_good_as(arm, best, swept_values(arm, best.objective, Q))


def test_the_ratio_of_the_stretched_arm_is_the_least_of_its_surface():
    # The best posture lies at an arm angle of an interval; from it, joints go against each other on the surface.
    arm = arms.load("iiwa14")
    pose = arm.forward_kinematics(np.zeros(7))
    best = arm.optimise(pose, "force_velocity_ratio", force=[0.124, 0.862, 0.116], velocity=[0.804, -0.504, 0.358])
    assert max(distance(pose, arm.forward_kinematics(best.q))) < 1e-9
    assert best.value < 1e-12


@pytest.mark.parametrize("tolerance", [0.0102, 0.0106, 0.011, 0.0116])
def test_the_second_objective_is_looked_for_in_every_stretch_that_the_first_leaves(tolerance):
    tip = pin.SE3(np.eye(3), np.array([-0.43722, 0.70572, 0.40594]))
    arm = srs_ik.load(f'<robot name="rising">{chains.arm(RISING, tip)}</robot>', tip="tool")
    pose = arm.forward_kinematics([0.38259, -1.59427, 1.57307, 1.18024, -0.27816, 0.84577, 0.07415])
    parameters = {"force": [-0.6477, 1.5199, 1.0315], "velocity": [0.3191, -0.5022, 0.8599]}
    optimum = arm.optimise(pose, "force_then_velocity", **parameters, tolerance=tolerance)
    values = swept_values(arm, optimum.objective, sweep(arm, pose))
    kept = values[:, 0] <= (1.0 + tolerance) * values[:, 0].min()
    assert values[kept, 1].max() > 1.1 * values[values[:, 0] <= 1.001 * values[:, 0].min(), 1].max()
    assert_as_good_as(arm, optimum, values)


def test_a_dip_beside_samples_that_lie_close_is_bracketed():
    """Next to a singularity values may go on falling over a hair's breadth, and hide that they have risen before."""
    width = 1e-8

    def value(x):
        return 0.52 * (x + 0.0095) ** 2 + 1e-9 * (0.5 * np.pi - np.arctan(x / width))

    close = width * np.tan(np.arange(-4, 5) * np.pi / 10.0)
    for sign in (1.0, -1.0):
        x = np.sort(sign * np.concatenate([np.linspace(-0.6, -0.1, 5), close, np.linspace(0.03, 0.6, 5)]))
        rows = np.zeros((len(x), entries.SAMPLE))
        rows[:, 0] = x
        runs, found = np.empty((at.MOST_RUNS, at.RUN)), np.empty((at.MAX_BRACKETS, at.BRACKET))
        runs[0] = 0.0, x[0], x[-1], 0.0, len(x)
        count = entries.brackets(rows, value(sign * x), runs, 1, found)
        best = minimize_scalar(value, bounds=(-0.1, -1e-5), method="bounded", options={"xatol": 1e-10})
        assert best.fun < value(x).min()
        wide = [b for b in found[:count] if b[2] < sign * best.x < b[4]]
        assert wide
        assert all(b[7] <= best.fun for b in wide)


@pytest.mark.parametrize(("seed", "which"), [(34, 7), (121, 5), (245, 2), (372, 7), (385, 3)])
def test_a_near_limb_has_the_margin_that_solve_finds(seed, which):
    style = ("usual", "narrow")[seed // 2 % 2]
    limb = random_limb(seed, "tilted", ("straight", "offset")[seed % 2], style, miss=1e-3)
    arm = srs_ik.load(limb.model, base="base", tip="tool")
    rng = np.random.default_rng(seed)
    for _ in range(which + 1):
        known = rng.uniform(arm.lower, arm.upper)
        joint = rng.integers(7)
        known[joint] = (arm.lower, arm.upper)[rng.integers(2)][joint]
    pose = arm.forward_kinematics(known)
    optimum = arm.optimise(pose, "limit_margin")
    Q = np.vstack([sweep(arm, pose), arm.solve(pose).q, known])
    half = 0.5 * (arm.upper - arm.lower)
    margins = np.min(1.0 - np.abs(Q - 0.5 * (arm.lower + arm.upper)) / half, axis=1)
    assert arm.limb.kind == "near"
    assert optimum.value >= margins.max() - 1e-12
    # Not by that posture alone: runs of two ends on limits are searched too.
    own = arm.optimise(pose, lambda q: float(np.min(np.minimum(q - arm.lower, arm.upper - q) / half)), maximise=True)
    assert own.value >= margins.max() - 1e-7


def test_a_function_is_optimised_like_the_built_in_objective_of_the_same_formula():
    for robot in ("iiwa14", "gen3"):
        arm = arms.load(robot)
        for q in arms.configurations(robot, 4, 54):
            pose = arm.forward_kinematics(q)
            by_name = arm.optimise(pose, "twist", **PARAMETERS["twist"])
            own = arm.optimise(pose, lambda x, arm=arm, o=by_name.objective: o.value(arm, x), maximise=True)
            assert own
            assert own.value == pytest.approx(by_name.value, rel=1e-9)


def test_a_function_with_a_corner_is_optimised():
    arm = arms.load("iiwa14")
    target = 0.3
    for q in arms.configurations("iiwa14", 5, 55):
        pose = arm.forward_kinematics(q)
        optimum = arm.optimise(pose, lambda x: abs(x[0] - target))
        swept = np.abs(sweep(arm, pose)[:, 0] - target).min()
        assert optimum.value <= swept + 1e-9


def test_the_optimum_is_a_solution():
    arm = arms.load("iiwa14")
    pose = arm.forward_kinematics(arms.configurations("iiwa14", 1, 56)[0])
    optimum = arm.optimise(pose.homogeneous, "manipulability")
    assert isinstance(optimum, Solution)
    assert isinstance(optimum, Optimum)
    assert optimum
    assert repr(optimum).startswith("Optimum(manipulability=")
    assert optimum.interval.branch == optimum.branch == arm.branch(optimum.q)
    assert optimum.interval in arm.intervals(pose)


def test_ties_between_mirrored_branches_go_to_the_posture_farthest_from_the_limits():
    arm = arms.load("iiwa14")
    margin = Objective("limit_margin")
    for q in arms.configurations("iiwa14", 10, 57):
        pose = arm.forward_kinematics(q)
        optimum = arm.optimise(pose, "manipulability")
        rivals = arm.solve_all(pose, arm_angle=optimum.arm_angle)
        for rival in rivals:
            if optimum.objective.value(arm, rival.q) >= optimum.value * (1.0 - 1e-13):
                assert margin.value(arm, optimum.q) >= margin.value(arm, rival.q) - 1e-6


@pytest.mark.parametrize("name", NAMES)
def test_what_is_out_of_reach_or_limits_is_answered_as_by_solve(name):
    arm = arms.load("human_arm")
    far = np.eye(4)
    far[:3, 3] = 0.0, 2.0, 0.0
    behind = arm.forward_kinematics(np.array([3.0, 0.5, 1.5, 1.0, 1.5, 1.0, 0.5])).homogeneous
    for pose, status in ((far, Status.UNREACHABLE), (behind, Status.OUT_OF_LIMITS)):
        optimum = arm.optimise(pose, name, **PARAMETERS[name])
        solution = arm.solve(pose, seed=REFERENCE if name == "reference_posture" else None)
        assert optimum.status is solution.status is status
        assert not optimum
        assert np.array_equal(optimum.q, solution.q)
        assert optimum.interval is None
        assert optimum.value == pytest.approx(optimum.objective.value(arm, optimum.q), rel=1e-12)


REFERENCE = PARAMETERS["reference_posture"]["reference"]


def test_wrong_input_is_refused():
    arm = arms.load("iiwa14")
    with pytest.raises(InvalidTask, match="there is no objective 'twists'"):
        arm.optimise(np.eye(4), "twists")
    for objective in ("manipulability", "gravity_torque", "limit_margin", lambda q: 0.0):
        with pytest.raises(InvalidPose):
            arm.optimise(np.zeros((4, 4)), objective)
        with pytest.raises(InvalidPose):
            arm.optimise(np.eye(3), objective)
    with pytest.raises(InvalidTask, match="finite number"):
        arm.optimise(arm.forward_kinematics(np.full(7, 0.3)), lambda q: np.inf)
