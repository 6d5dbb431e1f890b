"""A posture that limits leave alone: a single arm angle, or a point between two or three joints on limits.

What is asked makes no difference: a posture that `solve` finds without a seed is found from any seed and in its branch,
and is in an interval.
"""

import arms
import numpy as np
import pytest
from oracles import Forward, distance, inside, phases, random_limb

import srs_ik

HUMAN = [
    ([-0.6981317007977318, -1.5676306382855565, -3.141592653589793, -0.0031656885093401597, 1.2436996142404062,
      1.2217304763960306, 0.12503829991913834],
     [-0.21230943225746812, 0.9626617727502067, 0.5648780715141783, -0.2342359325328447, -0.7644017877240192,
      -0.33998748356936637, -0.0479329351358983]),
    ([1.5707963267948966, 0.11416472558084823, 1.153768622313052, -0.006317740971984853, -1.3962634015954636,
      -1.1953897716143889, 0.5235987755982988],
     [1.0, 0.0, 1.0, -0.5, -1.0, -1.0, 0.3]),
]  # fmt: skip
"""Postures of the human arm between three joints on limits, and seeds."""

IIWA14 = [
    ([0.3330747544989636, 0.8227885739145857, 2.736790095676626, -1e-09, -2.708352158171393, 1e-09, 2.4737010257824537],
     [-0.4954694618719575, -0.03496919785856201, 2.736790095676626, -0.7233758925157648, -2.708352159171393,
      -0.472365499296135, 2.4737010257824537],
     [1.0931267959595858, 1.3341604019553825, 2.9670597283903604, 0.26752089615579366, -1.783898600869809,
      0.24885596950102126, 2.8554450013358994]),
    ([2.2365327979856895, -0.001, -2.3190231678551134, 0.001, 2.3920373623078595, -0.001, -0.2935307569048091],
     [1.665504131723741, -0.4161564613338324, -2.5548869174040125, -0.6855778593551536, 1.9808154238131181,
      -0.36897161855705635, -0.7030069985379699],
     [2.927817337521271, 0.9017882842164545, -2.3190231678451134, 0.806574378636815, 2.3920373623078595,
      0.39561084875226005, -0.2935307569048091]),
]  # fmt: skip
"""Postures of an iiwa14, elbow and wrist singular, or almost, with limits that leave them alone."""

RM75 = [
    ([1.357632499670589, 1.949422629743086, 1.5707921293967164, -0.7188949932172553, -2.764050797216259,
      0.9080199310668277, 5.9831609438497875],
     [1.357632399670589, 1.8190399147880951, 1.309926164725323, -0.982389590263103, -2.906581198385833,
      0.6994258307096703, 5.706611144211665],
     [1.5038313621754091, 2.142554404790006, 1.7372461979076599, -0.5028313385125427, -2.473705787607011,
      1.0012896160382923, 6.274853422916764]),
    ([0.7577132369997678, -0.8636820755511231, 0.4892059593893037, 2.263437001935698, 3.067492905571666,
      0.9901266116196779, -2.418926813468621],
     [0.3430373259369408, -1.1852858514617652, 0.48920595938830375, 1.5063433498875922, 2.556914895076198,
      -0.0032082323687019354, -2.704526408282182],
     [1.236668435439845, 0.04347469440876861, 1.46367916852754, 3.0976770452805535, 3.4164464566884907,
      1.6432810784876908, -2.1619072358686857]),
    ([-1.2667484539539837, 1.6345208561766542, 2.425631235080878, 0.8627413725127746, 1.5368953741015958,
      -1.3637881612619949, -1.83046762590521],
     [-1.2667484539539837, -0.8278182529282168, -0.41464092557286447, -2.1300640550737335, 0.2270805636141815, -2.233,
      -1.83046772590521],
     [0.44945217396281034, 2.268, 3.1, 1.5084993891974425, 3.1, 0.9065338976390804, 0.7869654103994295]),
    ([1.664690921102157, -1.380895403828393, 1.2927678455381062, 1.1945719997681348, -2.467728175735603,
      0.3125668119757554, 1.1799989401888178],
     [1.4942987146463436, -1.6655223235577858, 1.2927678455381062, 0.9192818677066414, -2.615458630782377,
      0.1701158884902866, 0.8811939771166559],
     [1.8183905975595642, -1.261551603825815, 1.4025317883124393, 1.4215193179322094, -2.255123772185614,
      0.3125668119757554, 1.1799989401888178]),
]  # fmt: skip
"""Ordinary postures of an rm75, whose figures are rounded: a joint turns around on its limit, or two are on theirs."""


def within(name, lower, upper):
    """An arm with other limits."""
    arm = arms.load(name)
    limits = {
        joint: {"lower": low, "upper": high} for joint, low, high in zip(arm.joint_names, lower, upper, strict=True)
    }
    if name in arms.REAL:
        file, base, tip = arms.REAL[name]
        return srs_ik.load(arms.robot_file(file), base=base, tip=tip, limits=limits)
    return srs_ik.load(name, limits=limits)


def assert_is_found(arm, q, seeds):
    """Whatever is asked, a posture that is alone is the answer, and its arm angle in an interval of its branch."""
    pose, branch, psi = arm.forward_kinematics(q), arm.branch(q), arm.arm_angle(q)
    for seed in (None, *seeds):
        for wanted in (None, branch):
            s = arm.solve(pose, seed=seed, branch=wanted)
            assert s, (seed, wanted)
            assert max(arm.verify(pose, s.q)) < 1e-9
            assert ((arm.lower <= s.q) & (s.q <= arm.upper)).all()
    assert len(arm.solve_all(pose)) > 0
    assert arm.solve_batch([pose], seed=seeds[0]).ok.all()
    away = [
        abs((psi - 0.5 * (i.lower + i.upper) + np.pi) % (2.0 * np.pi) - np.pi) - 0.5 * i.width
        for i in arm.intervals(pose)
        if i.branch == branch
    ]
    assert min(away, default=np.inf) < 1e-6


@pytest.mark.parametrize("case", HUMAN)
def test_a_point_between_three_joints_on_limits_is_found_and_an_interval(case):
    q, seed = map(np.array, case)
    assert_is_found(arms.load("human_arm"), q, (q, seed))


@pytest.mark.parametrize("case", IIWA14)
def test_a_point_next_to_singular_joints_is_found_and_an_interval(case):
    q, lower, upper = map(np.array, case)
    assert_is_found(within("iiwa14", lower, upper), q, (q, lower, upper))


@pytest.mark.skipif("rm75" not in arms.here("rm75"), reason="its file is not here")
@pytest.mark.parametrize("case", RM75)
def test_a_point_of_an_arm_with_rounded_figures_is_found_and_an_interval(case):
    q, lower, upper = map(np.array, case)
    assert_is_found(within("rm75", lower, upper), q, (q, lower, upper))


OFFSETS = (0.0, 1e-11, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6)


def singular_on_limits(seed, locked):
    """A random exact limb with a singular shoulder or wrist, or both: a joint or none locked, up to three on limits."""
    rng = np.random.default_rng(seed)
    limb = random_limb(seed, ("coordinate", "tilted")[seed % 2], "offset", "usual")
    free = srs_ik.load(limb.model, base="base", tip="tool")
    q, singular = rng.uniform(-2.5, 2.5, 7), phases(free.limb)
    for joint in ((1, 5), (1,), (5,))[rng.integers(3)]:
        q[joint] = singular[joint] + rng.choice(OFFSETS) * rng.choice([-1.0, 1.0]) + np.pi * rng.integers(2)
    lower, upper = q - rng.uniform(0.01, 3.0, 7), q + rng.uniform(0.01, 3.0, 7)
    first, *others = rng.permutation(7)
    if locked:
        lower[first] = upper[first] = q[first]
    for joint in others[: rng.integers(4)]:
        end = (lower, upper)[rng.integers(2)]
        end[joint] = q[joint]
    limits = {
        name: {"lower": low, "upper": high} for name, low, high in zip(free.joint_names, lower, upper, strict=True)
    }
    return srs_ik.load(limb.model, base="base", tip="tool", limits=limits), np.clip(q, lower, upper)


@pytest.mark.slow
@pytest.mark.parametrize("locked", [True, False])
def test_single_arm_angles_of_intervals_are_met_next_to_singular_joints(locked):
    """Of 100 such poses one or two had an interval of one arm angle, or of next to nothing, that was refused."""
    single = 0
    for seed in range(400):
        arm, q = singular_on_limits(seed, locked)
        forward, pose = Forward(arm.model, "base", "tool", arm.joint_names), arm.forward_kinematics(q)
        for found in arm.intervals(pose):
            if found.width < 1e-6:
                for psi in np.linspace(found.lower, found.upper, 5):
                    solution = arm.solve(pose, arm_angle=psi, branch=found.branch)
                    assert solution, (seed, found, psi)
                    assert max(distance(pose, forward(solution.q))) < 1e-9
                    assert inside(solution.q, arm.lower, arm.upper)
                single += 1
    assert single > 20
