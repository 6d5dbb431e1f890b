"""Singular postures and their neighbourhood: no digit lost, no pose missed."""

import arms
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from oracles import Forward, distance, inside, phases, random_limb

import srs_ik
from srs_ik import Status

NAMES = arms.here("iiwa14", "gen3", "human_arm", "openarm_left", "sia5d", "med7", "humanoid_left", "rm75")
OFFSETS = (0.0, 1e-16, 1e-12, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4)
TOGETHER = ((1,), (3,), (5,), (1, 3), (1, 5), (3, 5), (1, 3, 5))


def singular_configurations(name, elbow=True):
    """Middle joints at and near their singular angles, one to three at once, the others random."""
    arm, rng = arms.load(name), arms.generator(name, 31)
    singular = phases(arm.limb)
    for q in arms.configurations(name, 2, 32):
        for joints in TOGETHER:
            if 3 in joints and not elbow:
                continue
            for offset in OFFSETS:
                placed = q.copy()
                for joint in joints:
                    placed[joint] = singular[joint] + offset * rng.choice([-1.0, 1.0])
                yield np.clip(placed, arm.lower, arm.upper)


def closed(arm):
    """Whether all axes meet exactly, so that the closed form is the whole answer."""
    return float(arm.limb.misses.max()) < 1e-12


def assert_met(arm, forward, pose, solution, respect_limits=True):
    assert solution.status is Status.OK, solution
    assert np.isfinite(solution.q).all()
    assert np.isfinite([solution.arm_angle, solution.position_error, solution.orientation_error]).all()
    assert max(distance(pose, forward(solution.q))) < 1e-9
    if respect_limits:
        assert inside(solution.q, arm.lower, arm.upper)


@pytest.mark.parametrize("name", NAMES)
def test_singular_poses_are_met(name):
    arm, forward = arms.load(name), arms.forward(name)
    for q in singular_configurations(name):
        pose = forward(q)
        assert_met(arm, forward, pose, arm.solve(pose))
        assert_met(arm, forward, pose, arm.solve(pose, seed=q))
        assert_met(arm, forward, pose, arm.solve(pose, respect_limits=False), respect_limits=False)


@pytest.mark.parametrize("name", NAMES)
def test_singular_poses_are_met_at_an_arm_angle_without_limits(name):
    arm, forward = arms.load(name), arms.forward(name)
    # An elbow on the line S-W has no arm angle. If all axes meet any one will do; if not, there is hardly a right one.
    for q in singular_configurations(name, elbow=closed(arm)):
        pose = forward(q)
        for arm_angle in (arm.arm_angle(q), 0.0, 2.0)[: 3 if closed(arm) else 1]:
            solution = arm.solve(pose, arm_angle=arm_angle, respect_limits=False)
            assert_met(arm, forward, pose, solution, respect_limits=False)


@pytest.mark.parametrize("name", NAMES)
def test_singular_postures_are_found_again_from_their_seed(name):
    """The seed itself meets the pose to the last digit: an arm that is where it should be does not move."""
    arm, forward = arms.load(name), arms.forward(name)
    for q in singular_configurations(name):
        solution = arm.solve(forward(q), seed=q)
        assert np.abs(solution.q - q).max() < 1e-6


@pytest.mark.parametrize("name", arms.here("iiwa14", "human_arm", "sia5d", "med7"))
def test_a_seed_does_not_turn_the_outer_joints_of_a_singular_wrist_out_of_their_limits(name):
    """Only the sum of joints 5 and 7 is fixed there; half-way to a seed each may be outside where others are inside."""
    arm, rng = arms.load(name), arms.generator(name, 35)
    forward, wrist = arms.forward(name), phases(arm.limb)[5]
    for q in arms.configurations(name, 40, 36):
        q[5] = np.clip(wrist, arm.lower[5], arm.upper[5])
        outer = (arm.lower, arm.upper)[rng.integers(2)]
        q[[4, 6]] = outer[[4, 6]] + rng.uniform(0.0, 0.2, 2) * np.sign(-outer[[4, 6]])
        pose = forward(q)
        solution = arm.solve(pose, arm_angle=arm.arm_angle(q), seed=rng.uniform(arm.lower, arm.upper))
        assert_met(arm, forward, pose, solution)


@pytest.mark.parametrize("name", NAMES)
def test_singular_poses_have_branches_without_limits(name):
    arm, forward = arms.load(name), arms.forward(name)
    for q in singular_configurations(name, elbow=closed(arm)):
        pose = forward(q)
        every = arm.solve_all(pose, arm_angle=0.4 if closed(arm) else arm.arm_angle(q), respect_limits=False)
        assert len(every) > 0
        for solution in every:
            assert_met(arm, forward, pose, solution, respect_limits=False)


@pytest.mark.parametrize("name", arms.here("iiwa14", "human_arm", "openarm_left", "humanoid_left"))
def test_a_flat_elbow_is_the_limit_of_its_branch(name):
    """At an arm angle, every branch goes continuously to the straight arm, each elbow from its own side."""
    arm = arms.load(name)
    straight = phases(arm.limb)[3]
    for q in arms.configurations(name, 3, 36):
        q[3] = straight
        flat = arm.forward_kinematics(q)
        q[3] += 1e-5
        almost = arm.forward_kinematics(q)
        for branch in range(8):
            there, before = (arm.solve(T, arm_angle=0.7, branch=branch, respect_limits=False) for T in (flat, almost))
            assert np.abs(np.exp(1j * there.q) - np.exp(1j * before.q)).max() < 1e-3
        q[3] = -0.0
        other = q.copy()
        other[3] = 0.0
        assert arm.arm_angle(q) == arm.arm_angle(other)


@pytest.mark.parametrize(
    "name", arms.here("openarm_left", "openarm_right", "human_arm", "human_left", "humanoid_left", "romeo_left")
)
def test_elbow_on_its_limits(name):
    """On many arms the straight elbow is the limit itself."""
    arm, forward = arms.load(name), arms.forward(name)
    for q in arms.configurations(name, 25, 33):
        for limit in (arm.lower[3], arm.upper[3]):
            q[3] = limit
            pose = forward(q)
            assert_met(arm, forward, pose, arm.solve(pose))
            assert_met(arm, forward, pose, arm.solve(pose, seed=q))


@pytest.mark.parametrize("name", NAMES)
def test_all_joints_on_limits(name):
    """The corners of the range are inside it."""
    arm, forward, rng = arms.load(name), arms.forward(name), arms.generator(name, 34)
    for q in arms.configurations(name, 40, 35):
        for joint in rng.permutation(7)[: rng.integers(1, 8)]:
            limit = (arm.lower, arm.upper)[rng.integers(2)][joint]
            q[joint] = limit if np.isfinite(limit) else q[joint]
        pose = forward(q)
        assert_met(arm, forward, pose, arm.solve(pose))


@pytest.mark.parametrize("folded", [False, True], ids=["straight", "folded"])
@pytest.mark.parametrize("seed", range(6))
def test_all_joints_on_limits_with_a_flat_elbow(seed, folded):
    """A pose does not tell small bends apart, and only one of them keeps the limits."""
    limb = random_limb(seed, "oblique", "straight", "usual")
    arm = srs_ik.load(limb.model, base="base", tip="tool", limits={"joint_4": {"lower": -3.5, "upper": 3.5}})
    forward = Forward(limb.model, "base", "tool", arm.joint_names)
    for _ in range(20):
        q = np.where(limb.rng.random(7) < 0.5, arm.lower, arm.upper)
        q[3] = phases(arm.limb)[3] + np.pi * folded
        pose = forward(q)
        assert_met(arm, forward, pose, arm.solve(pose))


@pytest.mark.parametrize("name", arms.here("iiwa14", "gen3", "human_arm", "sia5d", "rm75"))
def test_wrist_on_axis_1(name):
    """Shoulder, wrist and the arm-angle reference in one line: the arm angle's own singular line."""
    arm, forward = arms.load(name), arms.forward(name)
    axes, S, W = arm.limb.axes, arm.limb.shoulder, arm.limb.wrist
    found = 0
    for q in arms.configurations(name, 30, 36):
        pose = forward(q)
        wrist = forward.carried(q, 7, W)
        # Moving the target shifts the wrist centre with it, onto axis 1 at the same distance from the shoulder.
        for side in (1.0, -1.0):
            target = S + side * axes[0] * np.linalg.norm(wrist - S)
            moved = pose.copy()
            moved.translation = pose.translation + target - wrist
            for solution in (
                arm.solve(moved, respect_limits=False),
                arm.solve(moved, arm_angle=0.3, respect_limits=False),
                arm.solve(moved, seed=q, respect_limits=False),
            ):
                assert_met(arm, forward, moved, solution, respect_limits=False)
            limited = arm.solve(moved)
            assert inside(limited.q, arm.lower, arm.upper)
            found += bool(limited)
    assert found > 0


@pytest.mark.parametrize("name", arms.here("iiwa14", "med7"))
def test_ends_of_intervals_next_to_singular_postures_are_met(name):
    """There, the rounding of an arm angle turns joints farther than the limits allow."""
    arm, forward = arms.load(name), arms.forward(name)
    singular, asked = phases(arm.limb), 0
    for q in arms.configurations(name, 3, 37):
        for joints in ((1,), (5,), (1, 5)):
            for offset in (1e-10, 1e-8, 1e-7, 1e-6, 1e-5):
                placed = q.copy()
                for joint in joints:
                    placed[joint] = singular[joint] + offset
                pose = forward(placed)
                for interval in arm.intervals(pose):
                    for psi in (interval.lower, interval.upper):
                        solution = arm.solve(pose, arm_angle=psi, branch=interval.branch)
                        assert_met(arm, forward, pose, solution)
                        asked += 1
    assert asked > 1000


def test_stretched_upright_arm():
    """Everything singular at once: the zero posture of the iiwa."""
    arm, forward = arms.load("iiwa14"), arms.forward("iiwa14")
    pose = forward(np.zeros(7))
    for options in ({}, {"arm_angle": 1.0}, {"seed": np.zeros(7)}, {"respect_limits": False}, {"branch": 3}):
        solution = arm.solve(pose, **options)
        assert_met(arm, forward, pose, solution)
    assert np.abs(arm.solve(pose, seed=np.zeros(7)).q).max() < 1e-6
    seed = np.array([0.4, 0.0, -0.3, 0.0, 0.2, 0.0, 0.1])
    assert np.abs(arm.solve(forward(seed), seed=seed).q - seed).max() < 1e-6


SINGULAR = {
    "seed": st.integers(0, 2**32 - 1),
    "pattern": st.sampled_from(["coordinate", "tilted", "oblique"]),
    "elbow": st.sampled_from(["straight", "offset"]),
    "offset": st.sampled_from(OFFSETS),
    "joints": st.sampled_from(TOGETHER),
    "miss": st.sampled_from([0.0, 1e-9, 0.003]),
}


def singular_case(seed, pattern, elbow, offset, joints, miss):
    """A random limb without limits, and a configuration at or near singular angles, on either side of the axis."""
    limb = random_limb(seed, pattern, elbow, "continuous", miss)
    arm = srs_ik.load(limb.model, base="base", tip="tool")
    singular, q = phases(arm.limb), limb.configuration()
    for joint in joints:
        q[joint] = singular[joint] + offset * limb.rng.choice([-1.0, 1.0]) + np.pi * limb.rng.integers(2)
    return arm, q


@given(**SINGULAR)
def test_singular_postures_of_random_limbs(seed, pattern, elbow, offset, joints, miss):
    arm, q = singular_case(seed, pattern, elbow, offset, joints, miss)
    forward = Forward(arm.model, "base", "tool", arm.joint_names)
    pose = forward(q)
    assert_met(arm, forward, pose, arm.solve(pose))
    assert_met(arm, forward, pose, arm.solve(pose, seed=q))
    # The elbow on the line S-W has no arm angle, and neither oblique axes nor such as miss a centre take just any.
    if 3 not in joints or (pattern != "oblique" and miss == 0.0):
        assert_met(arm, forward, pose, arm.solve(pose, arm_angle=arm.arm_angle(q)))


@given(**SINGULAR)
def test_singular_postures_of_random_limbs_are_found_again_from_their_seed(seed, pattern, elbow, offset, joints, miss):
    arm, q = singular_case(seed, pattern, elbow, offset, joints, miss)
    assert np.abs(arm.solve(arm.forward_kinematics(q), seed=q).q - q).max() < 1e-6


def nearest_split(arm, q, seed):
    """The posture of a singular wrist, joints 5 and 7 with the same sum, inside the limits and nearest to a seed."""
    best = q
    for turns in np.ndindex(5, 5):
        a, b = q[[4, 6]] + 2.0 * np.pi * (np.array(turns) - 2)
        low, high = max(arm.lower[4] - a, b - arm.upper[6]), min(arm.upper[4] - a, b - arm.lower[6])
        if low <= high:
            t = np.clip(0.5 * (seed[4] - a - (seed[6] - b)), low, high)
            best = min(best, np.array([*q[:4], a + t, q[5], b - t]), key=lambda x: np.linalg.norm(x - seed))
    return best


@pytest.mark.slow
@pytest.mark.parametrize("first", [41, 45, 47])
@pytest.mark.parametrize("name", arms.here("iiwa14_experimental", "j2s7s300"))
def test_splits_of_a_singular_wrist_are_found_from_any_seed_and_in_their_branch(name, first):
    """Axes 5 and 7 of these near arms are one line there, and rounding decides which curve is followed on."""
    arm, forward = arms.load(name), arms.forward(name)
    singular = phases(arm.limb)[5] + (0.0 if arm.lower[5] <= phases(arm.limb)[5] else 2.0 * np.pi)
    for q, seed in zip(arms.configurations(name, 250, first), arms.configurations(name, 250, first + 1), strict=True):
        q[5] = singular
        known, pose = nearest_split(arm, q, seed), forward(q)
        assert max(distance(pose, forward(known))) < 1e-12
        for branch in (None, arm.branch(known)):
            solution = arm.solve(pose, seed=seed, branch=branch)
            assert_met(arm, forward, pose, solution)
            farther = np.linalg.norm(solution.q - seed) - np.linalg.norm(known - seed)
            assert farther < 1e-6, (farther, branch, known.tolist(), seed.tolist())


@pytest.mark.skipif(not arms.here("j2s7s300"), reason="robot_descriptions has no j2s7s300 here")
def test_a_stretch_that_leaves_the_border_of_a_branch_is_followed_no_farther():
    arm = arms.load("j2s7s300")
    first = [1.376426129722046, np.pi, 2.8968404481064987, 0.5235987765982988]
    q = [*first, -2.97131796074464, np.pi, 0.6003611774875495]
    first = [1.7093883319442362, 3.386397716338933, -1.358709739880667, np.pi]
    seed = [*first, -0.764972823421759, 1.2397473572586561, 2.3579648040164676]
    for respect in (True, False):
        solution = arm.solve(arm.forward_kinematics(q), seed=seed, branch=5, respect_limits=respect)
        assert (solution.status, solution.branch) == ("OK", 5)


@pytest.mark.skipif(not arms.here("iiwa14_experimental"), reason="its file is not here")
def test_branches_that_rounding_changes_along_a_split_leave_room_for_intervals():
    """There were more changes than room, and what came behind them was taken for a part of the last interval."""
    arm = arms.load("iiwa14_experimental")
    q = [
        -1.4896685615791747,
        0.0,
        -0.645357176481407,
        0.41050553226362085,
        -0.07331769680660871,
        0.0,
        1.5523250938825166,
    ]
    pose = arm.forward_kinematics(q)
    found = [each for each in arm.intervals(pose) if each.branch == 2]
    for psi in np.linspace(-3.1, 3.1, 63):
        inside = any(each.lower <= psi <= each.upper for each in found)
        assert inside == (arm.solve(pose, arm_angle=psi, branch=2).status == "OK"), psi


HIDDEN = [
    ("iiwa14", [-2.9670597273903603, 1e-11, 1.5061014553562915, 1e-11, -0.2836358516811335, -2.094395101393195,
                -0.9625342674937389],
               [-2.9670597283903604, 6.816643320655542e-4, 1.5054736801666038, 5.779644021504125e-4, -0.28337072862,
                -2.0943951023931953, -0.9630121579092455]),
]  # fmt: skip
"""Postures with an almost straight elbow and joints on limits, or next to them, and seeds beside them."""


@pytest.mark.parametrize("case", HIDDEN)
def test_a_posture_on_limits_that_rounding_hides_at_an_arm_angle_is_near_a_seed(case):
    """Others at the same arm angle, half a radian to six away, keep the limits to the last bit."""
    name, q, seed = case
    arm, forward = arms.load(name), arms.forward(name)
    pose, psi = forward(np.array(q)), arm.arm_angle(q)
    for branch in (None, arm.branch(q)):
        solution = arm.solve(pose, arm_angle=psi, seed=seed, branch=branch)
        assert_met(arm, forward, pose, solution)
        assert np.linalg.norm(solution.q - seed) < np.linalg.norm(np.subtract(q, seed)) + 1e-6


VAGUE = [
    ("human_arm", [1.3639955376134036, -1.5707963266948965, -3.141492653589793, -1.9494358016810143, 1.1977635977257297,
                   0.4154421142959146, -0.08648048558163712], -3.142592653458772, None),
    ("human_arm", [0.9549246109245279, 1.5707963267948966, 0.21102497871464498, -0.03723045045542284,
                   -1.3962634015954636, -1.3962634015954636, 0.15980606222045884], 0.000999999999994449, None),
    ("iiwa14", [-2.430205671966044, 2.0943950923931953, -0.325625073541405, -0.001, 1.6427725533253934, 1e-11,
                0.18829912385338954], 1.6398371813552926, 4),
    ("human_arm", [1.5697963267948967, 1.5707963268048966, 0.8643518057896147, -0.0001, -1.3962634015954636,
                   -1.3962634015954636, 0.5235987755982988], -0.4637446710244868, 6),
]  # fmt: skip
"""Poses with a singular shoulder or wrist, which leave postures vague; arm angles that limits allow nowhere near."""


@pytest.mark.parametrize(("name", "q", "psi", "branch"), VAGUE)
def test_an_elbow_is_where_the_arm_angle_has_it_though_other_joints_are_vague(name, q, psi, branch):
    """Postures 1e-3 to 2 rad away from the arm angle, their elbows off by 1e-5 to 4e-4 m, were OK."""
    arm = arms.load(name)
    pose = arm.forward_kinematics(q)
    assert arm.solve(pose, arm_angle=psi, branch=branch).status == "OUT_OF_LIMITS"
    in_turn = psi + 2.0 * np.pi * np.arange(-1, 2)
    for each in arm.intervals(pose):
        if branch in (None, each.branch):
            assert not ((each.lower - 1e-4 < in_turn) & (in_turn < each.upper + 1e-4)).any()


def test_a_straight_elbow_is_found_in_each_turn_of_a_joint_that_is_on_a_limit_there():
    """Joint 1 goes on a turn away beyond its limit, and rounding decides at which arm angles it is on that limit."""
    names = arms.load("iiwa14").joint_names
    lower, upper = (-3.3, -2.1) * 3 + (-3.3,), (4.5, 2.1) * 3 + (4.5,)
    limits = {name: {"lower": lower[j], "upper": upper[j]} for j, name in enumerate(names)}
    arm, rng = srs_ik.load("iiwa14", limits=limits), np.random.default_rng(4)
    for _ in range(400):
        q = rng.uniform(lower, upper)
        q[0], q[3] = lower[0], 10.0 ** rng.uniform(-9.0, -5.0) * rng.choice([-1.0, 1.0])
        q[6] = rng.choice([lower[6], q[6], upper[6]])
        seed = np.clip(q + 10.0 ** rng.uniform(-2.0, 0.2) * rng.normal(size=7), lower, upper)
        solution = arm.solve(arm.forward_kinematics(q), seed=seed)
        assert solution.status is Status.OK
        assert np.linalg.norm(solution.q - seed) < np.linalg.norm(q - seed) + 1e-6, (q.tolist(), seed.tolist())
