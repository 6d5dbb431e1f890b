"""Branches, arm angles and ends that intervals tell of singular poses are met."""

from itertools import islice

import arms
import chains
import numpy as np
import pinocchio as pin
import pytest
from known_postures import assert_all_is_met, assert_intervals_are_met, assert_is_whole, subjects
from oracles import distance, phases, random_limb

import srs_ik

CHANGING = [
    [0.26292346483180085, -0.5417770158558199, -0.9407470479179056, -2.213222200467193, -1.5181514180795466, -1e-05,
     -2.5284168545207897],
    [1.7724649286995886, 0.0, -2.994691579487433, -2.0685137056169602, 0.3515064974807074, 0.0, -1.0048114491328635],
]  # fmt: skip
"""Of a gen3, two branches of a wrist that is almost singular, of which one begins 1e-7 rad behind where the other's
curve turns; and one of a curve whose joints 2 and 6 pass zero together, 1e-4 rad beside another curve."""


@pytest.mark.parametrize("q", CHANGING)
def test_branches_that_change_next_to_other_curves_are_met_at_their_ends(q):
    arm, forward = arms.load("gen3"), arms.forward("gen3")
    pose = forward(np.array(q))
    for interval in arm.intervals(pose):
        for psi in (interval.lower, interval.upper):
            solution = arm.solve(pose, arm_angle=psi, branch=interval.branch)
            assert solution, f"branch {interval.branch} at {psi}: {solution.status}"
            assert max(distance(forward(solution.q), pose)) < 1e-9


VAGUE = [
    [3.1, 1.1575796185553155, -3.1, -1e-12, 1.0266969931846712, -1e-12, -6.28],
    [-3.1, -2.069514261920832, -3.1, -1e-9, 0.7770343259540753, -1e-9, -6.28],
]
"""Of an rm75: elbow and wrist singular, and rounding moves postures by 0.01 rad along their curve's surface."""


@pytest.mark.parametrize("q", VAGUE if "rm75" in arms.here("rm75") else [])
def test_arm_angles_that_rounding_blurs_are_met(bench, q):
    arm, q = arms.load("rm75"), np.array(q)
    case = bench["Case"](q, arm.forward_kinematics(q).homogeneous, q, (), 0.0)
    intervals = arm.intervals(case.pose)
    assert len(intervals) > 4
    assert not list(bench["missed"](arm, [case], [intervals]))


@pytest.mark.parametrize(
    "q",
    [
        [-0.5 * np.pi, 0.0, np.pi, 0.5 * np.pi, -np.pi, 0.0, 0.5 * np.pi],
        [np.pi, 0.0, 0.0, -0.5 * np.pi, 0.0, 0.0, -0.5 * np.pi],
    ],
)
def test_every_interval_of_a_near_limb_at_right_angles_has_a_posture(q):
    arm = arms.load("gen3")
    T = arm.forward_kinematics(q)
    answers = arm.solve_all(T)
    assert [answer.branch for answer in answers] == [interval.branch for interval in arm.intervals(T)]
    for answer in answers:
        assert max(distance(T, arm.forward_kinematics(answer.q))) < 1e-9


def written(folder, points, axes, limits, digits):
    """An arm of parallel or right-angled axes (points in mm), whose file gives angles with so many digits."""
    lines = [chains.Line(*line) for line in zip(axes, points, limits, strict=True)]
    tip = pin.SE3(np.eye(3), 1e-3 * np.array(points[-1], float))
    path = folder / "arm.urdf"
    path.write_text(f'<robot name="arm">{chains.arm(lines, tip, digits=digits)}</robot>')
    return srs_ik.load(path, base="link_0", tip="tool")


SHORT_ANGLES = [
    "0.4674543860880025 0.8582610183761994 -2.095296552521161 -9.880263290563675e-08 1.9062070329446814 "
    "-0.2108383926915578 -0.9536365605046244",
    "-3.14 0.3085621787753734 1.1387290176197342 1.0011973670943632e-06 -3.14 -1e-06 3.14",
    "0.47526153644019775 -1.2891064162146084 2.5848461197672266 1.0973670943632441e-09 -1.687591364649572 "
    "2.4090369220439087 1.8376169426176703",
    "2.953191628215707 1.3107713078583267 -1.7441133742741244 1.1973670943632442e-09 -1.5831944206921804 "
    "0.6612660989037495 -2.9440120452922387",
]
"""Elbows almost straight, where some parameters of a curve have no posture: one off its pose is no change of branch."""


@pytest.mark.parametrize("given", SHORT_ANGLES)
def test_postures_off_their_pose_tell_no_change_of_branch(bench, tmp_path, given):
    """Joint places of the URDF of Kinova's Movo, whose right angles have nine decimals: axes miss by some 1e-10 m."""
    heights = (62.5, 181.25, 386.25, 591.25, 798.55, 902.3, 1006.05)
    points = [(0.0, -11.4 if k > 3 else 0.0, z) for k, z in enumerate(heights)]
    up, across = (0.0, 0.0, -1.0), chains.Y
    axes = (up, across, up, (0.0, -1.0, 0.0), up, across, up)
    limits = [(-x, x) for x in (3.14, 2.24, 3.14, 2.81, 3.14, 2.78, 3.14)]
    assert_is_whole(bench, written(tmp_path, points, axes, limits, 9), np.array(given.split(), float))


TURNED_TWICE = [
    "-2.791197118434844 0.7148180894905051 -0.2704456048006314 -0.14802277164140568 -1.543100929776156 "
    "0.5999354305645681 -0.6060510859664663",
    "-0.29232117108347966 1.8377639250202176 1.5006321897390464 -0.14802387164140568 1.5654944728200528 "
    "0.5761750243371522 -0.6549966623181456",
    "-1.303833917625282 -0.35 -0.4323219153595499 -0.14802378164140567 1.57 0.4592510668949743 0.3199649083371847",
]
"""Arm angles that go forth, back and forth between two samples of a curve: postures that no branch was given."""


@pytest.mark.parametrize("given", TURNED_TWICE)
def test_arm_angles_that_turn_around_twice_between_two_samples_are_noticed(bench, tmp_path, given):
    """Joint places of the URDF of Leju's Kuavo, left arm, to 0.1 mm: axes of the wrist miss by up to 10.5 mm."""
    across = [-17.5, -17.5, -17.5, 2.5, -17.5, -17.3, -17.3]
    heights = [424.5, 424.5, 424.5, 140.8, 13.8, -92.7, -113.7]
    points = [(x, 292.7, z) for x, z in zip(across, heights, strict=True)]
    axes = (chains.Y, chains.X, chains.Z, chains.Y, chains.Z, chains.X, chains.Y)
    limits = [(-3.14, 1.57), (-0.35, 2.09), (-1.57, 1.57), (-2.62, 0.0), (-1.57, 1.57), (-1.31, 0.7), (-0.7, 0.7)]
    arm = written(tmp_path, points, axes, limits, 17)
    assert_is_whole(bench, arm, np.array(given.split(), float))


TURNS_AT_A_WRIST = [
    "-2.189770744802907 0.3628493669517554 2.064840811317306 1.4223168909717425 2.8750828518166625 1e-08 "
    "-1.032650000580929",
    "-1.043476998423674 1e-08 -2.482980007276918 -1.3893622786981619 -0.8930288102865793 -1e-08 -0.4456549610419316",
    "-2.867364662673771 1e-06 1.7016283224065 1.926683407027618 1.3303162467361318 -1e-06 2.230457508285685",
    "2.6522177019952817 1e-12 -2.2591021581811805 -2.5699999999989998 0.6501265266946574 -1e-12 2.371237694350879",
    "1.7226723159481656 1e-05 -3.041713888327156 -2.38643098287384 2.317357335359385 1e-05 1.0916638037034927",
    "1.2897725205847346 -1e-10 -0.8127792361460888 2.5274024591967534 2.230294521065412 1e-10 0.022333631963843636",
]
"""Of a gen3: the arm angle turns around 1e-4 rad beside a singular wrist, where postures in step are 1e-9 rad off."""


@pytest.mark.parametrize("given", TURNS_AT_A_WRIST)
def test_no_interval_ends_beyond_where_its_arm_angle_turns_around(given):
    """Such ends lay up to 6e-9 rad beyond it; arm angles are met to 1e-9 rad."""
    assert assert_all_is_met("gen3", arms.forward("gen3")(np.array(given.split(), float)), 3) > 10


TOLD = [
    ("j2s7s300", "-0.34815778847792167 pi 1.6118526914877807 pi -2.058045636543095 pi -3.0259357247741994"),
    (
        "j2s7s300",
        "2.7181557936702214 3.141592653579793 -2.9433369395848747 3.141592653599793 -1.601112355090459 "
        "1.1344640137963142 0.8933070470649085",
    ),
    (
        "j2s7s300",
        "-3.014369942765355 3.1415936535897933 -3.136106258204609 3.1415936535897933 -1.3554346859964341 "
        "3.1415936535897933 -2.340908951565238",
    ),
    (
        "j2s7s300",
        "0.04395375306145688 0.8203147484373349 2.995554580651877 3.141434141488206 -0.056062241294208004 "
        "3.1417511656913804 -0.4849381187195809",
    ),
    (
        "rm75",
        "-1.9845086727543024 2.0228377457287534 -0.20125357871684768 1e-12 -0.22414282516487516 -2.2329999000000003 "
        "-5.076125179119171",
    ),
    (
        "rm75",
        "-2.385217687755319 -0.4322062268339961 0.026613559909296036 1e-08 1.2346039905984676 -0.00726089153539089 "
        "-4.966001938605286",
    ),
    ("rm75", "3.1 2.2006294957665 -3.1 -1e-08 0.6829449921549822 1e-08 3.400456544696307"),
    ("rm75", "-3.1 2.268 -0.049611990700210384 -1e-11 0.058824423863540254 2.233 5.178761609380408"),
    (
        "gen3",
        "2.8363562556204815 -1e-11 -2.8684388322922394 -1e-11 -1.4638641188189088 -1e-11 -1.3893313555606839",
    ),
    (
        "gen3",
        "-0.1358092581349255 -1e-10 -2.5089347846339 1.2733100002660267 -0.39711058444617153 -1e-10 "
        "-0.19881647308128025",
    ),
    (
        "h1_2_left",
        "-2.6685388085771256 -0.033765104852954864 1.7751334824583411 1.5045986785507044 -3.00999999 "
        "-0.06575398324299742 1.0346940548181793",
    ),
    (
        "h1_2_left",
        "-2.906212859690736 3.399999999999 -2.0316024643912893 1.5045987785407045 1.9789389182980477 "
        "0.46249999999900004 -0.7285572213873732",
    ),
    (
        "rm75",
        "1.324362861585532 1e-11 2.573302824988582 0.4067256839047406 -2.4241045442121325 -1e-11 -5.516415725377344",
    ),
    (
        "rm75",
        "-0.2601701512757275 1e-11 2.919934325306851 -1.2152273788585037 1.0787849556981022 1e-11 -5.744178592616479",
    ),
    (
        "rm75",
        "3.09999999 -1.8286027161110532 -1.6133794644901953 1e-10 0.5966407406214671 -2.23299999 3.376583427158603",
    ),
    (
        "rm75",
        "-1.7998569201834305 -0.11808088789605398 2.1688547150196844 1.080227660526937 -3.089322110988282 1e-09 "
        "-5.745489329231564",
    ),
    (
        "rm75",
        "3.1 2.1656487325987612 -0.20098067803034292 0 -0.6135157157592062 -2.233 2.6386806435211065",
    ),
]
"""Branches that change a thousand times; a posture on a limit; arm angles of flat elbows that floats do not tell, or
told by postures that do not meet their pose, or break a limit; far turns, sharp bulges, and elbows elsewhere; a sample
outside its limits between two postures inside; steps that would lead from one curve to another; ends that floats put
outside of them; two postures of a straight elbow with none between."""


@pytest.mark.parametrize(("name", "given"), [at for at in TOLD if at[0] in arms.here(at[0])])
def test_what_intervals_tell_of_singular_poses_is_met(bench, name, given):
    assert_intervals_are_met(bench, arms.load(name), np.array(given.replace("pi", repr(np.pi)).split(), float))


TOLD_OF_ROUNDED = [
    (
        9800001,
        1,
        "4.922304501818642 -2.907909619601477 2.379452007482026 3.141592559985721 -1.6650737225224714 -1e-08 "
        "3.0619130327872677",
    ),
    (
        9800001,
        5,
        "-5.3729537940802015 -2.012002378205056 -1.1224491949915114 -5.2270053085751694e-08 -5.818256276382846 "
        "3.676568641279833 -5.6253597342523936",
    ),
    (
        9800000,
        15,
        "-1.1300807844442224 -2.4848474976736563 -6.341517258832912 -1.4740938522553416e-07 0.28604130607485834 "
        "3.0522766952644105 -2.7764065947771286",
    ),
    (
        17000000,
        7,
        "-3.9016706460184163 1.888814703912641 -3.72776334588036 -1.044611186744703e-06 0.18925100690881957 "
        "-4.708408647167117 3.7151821191179133",
    ),
    (
        9800000,
        33,
        "1.69514176303691 -0.0001 0.3587506294152263 1.9656787014923798 1.8688951710653159 1.641665343878124 "
        "-1.560645606411029",
    ),
    (
        78000001,
        1,
        "5.384474857167537 0.8284104320846621 3.8508026272840112 0.9211680777290012 -1.5932884475473243 "
        "-3.1315782696022523 -0.5809397173401498",
    ),
]
"""Seed and number of an arm whose axes miss by 1e-8 m: flat elbows, one alone between two limits, an end where another
joint is outside, and ends next to a singular wrist."""


@pytest.mark.parametrize(("seed", "number", "given"), TOLD_OF_ROUNDED)
def test_what_intervals_of_rounded_arms_tell_is_met(bench, seed, number, given):
    made = subjects()["arms_of"]("random_rounded", 10000, seed)
    arm, _ = next(islice(made, number, None))
    assert_intervals_are_met(bench, arm, np.array(given.split(), float))


def test_an_answer_that_free_steps_find_is_told_to_be_of_its_branch():
    """It was told to be of the branch from which the steps had begun."""
    arm, _ = next(islice(subjects()["arms_of"]("random_rounded", 10000, 16000000), 89, None))
    q = "-3.0353634668310456 1e-11 4.811882431122668 -3.682754546591459e-09 0.7115345120125012 -1.7262786612810257 "
    solution = arm.solve(arm.forward_kinematics(np.array(f"{q} 2.269636611462001".split(), float)))
    assert solution
    sides = [np.sin(solution.q[joint] - angle) < 0.0 for joint, angle in phases(arm.limb).items()]
    assert solution.branch == 2 * sides[0] + 4 * sides[1] + sides[2]


def asked_of(arm, q, rng):
    """Arm angles: that of a posture, any, and some in intervals, at their ends and beside them."""
    yield arm.arm_angle(q)
    yield rng.uniform(-np.pi, np.pi)
    intervals = arm.intervals(arm.forward_kinematics(q))
    for i in rng.permutation(len(intervals))[:3]:
        interval = intervals[i]
        yield from (interval.lower + interval.width * rng.random(), interval.upper)
        yield interval.upper + 10.0 ** rng.uniform(-4.0, -2.0)


def told_of(bench, arm, pose, psi, intervals):
    """Each branch: how far an arm angle is outside its intervals (negative inside), met alone, and among all."""
    every = {solution.branch for solution in arm.solve_all(pose, arm_angle=psi)}
    for branch in range(8):
        own = [i for i in intervals if i.branch == branch]
        away = (abs(bench["wrapped"](psi - 0.5 * (i.lower + i.upper))) - 0.5 * i.width for i in own)
        alone = bool(arm.solve(pose, arm_angle=psi, branch=branch))
        yield min(away, default=np.inf), alone, branch in every, (psi, branch)


@pytest.mark.slow
@pytest.mark.parametrize("name", [n for n in ("iiwa14", "j2s7s300", "made_rounded") if n in arms.here(n)])
def test_one_branch_and_all_branches_tell_the_same_of_an_arm_angle(bench, name):
    """Rounding decides within 1e-4 rad of the ends of intervals; inside of them both have a posture."""
    arm, rng, met = arms.load(name), np.random.default_rng(77), 0
    for case in islice(bench["cases"](arm, 12, rng, limits=0.3), 12):
        intervals = arm.intervals(case.pose)
        for psi in asked_of(arm, case.q, rng):
            for off, alone, among, what in told_of(bench, arm, case.pose, psi, intervals):
                assert off > -1e-6 or (alone and among), (case.q.tolist(), *what, off)
                assert off < 1e-4 or alone == among, (case.q.tolist(), *what, off)
                met += alone and among
    assert met > 200


@pytest.mark.skipif("rm75" not in arms.here("rm75"), reason="its file is not here")
def test_all_branches_are_looked_for_on_curves_as_limits_cut_them(bench):
    arm = arms.load("rm75")
    q = [-0.4393116295395152, -0.32173026967329954, -0.10958696455916073, -1e-12, -2.9427393973244245]
    pose = arms.forward("rm75")(np.array([*q, 2.159199925009793, -1.2400329971430715]))
    intervals, inside_of = arm.intervals(pose), 0
    for psi in (-0.7483253082831713, -0.7416817105059118, -0.7400025940146062):
        for off, alone, among, what in told_of(bench, arm, pose, psi, intervals):
            if off < -1e-6:
                assert alone, what
                assert among, what
                inside_of += 1
    assert inside_of > 3


@pytest.mark.parametrize("robot", ["random limb"] + ["j2s7s300"] * ("j2s7s300" in arms.here("j2s7s300")))
def test_no_interval_goes_on_as_that_of_another_curve(bench, robot):
    """With almost straight elbow two curves pass within 0.02 rad: one's limit was taken for the other's."""
    if robot == "j2s7s300":
        arm = arms.load(robot)
        q = "1.641662899580692 4.316536560302829 2.9046307905275217 3.141592653589793 1.3650318563322656 "
        q = np.array(f"{q} 3.141592653589793 -0.44597528959482613".split(), float)
    else:
        limb = random_limb(120025, "tilted", "offset", "usual", 0.0001)
        arm = srs_ik.load(limb.model, base="base", tip="tool")
        q = [limb.configuration() for _ in range(30)][-1]
    assert_intervals_are_met(bench, arm, q)


@pytest.mark.parametrize("name", arms.here("rm75"))
def test_no_interval_spans_what_a_shoulder_and_a_wrist_forbid_together(bench, name):
    """Next to where both are singular, each is outside its limits for less than 1e-3 rad, and these overlap."""
    arm, rng = arms.load(name), np.random.default_rng(31)
    for _ in range(60):
        q = rng.uniform(arm.lower, arm.upper)
        q[[1, 5]] = 10.0 ** rng.uniform(-3.3, -2.3) * rng.choice([-1.0, 1.0], 2)
        assert_intervals_are_met(bench, arm, q)


@pytest.mark.slow
def test_steps_that_end_exactly_in_a_singular_wrist_are_numbers():
    arm, _ = next(islice(subjects()["arms_of"]("random_rounded", 1000, 12100001), 95, None))
    q = "-1.3101330738123536 3.2192707721250695 -0.3966754333300466 -1.380098003418523 2.2004001470347623 -1e-07 "
    q = np.array(f"{q} 2.9912556887524215".split(), float)
    solution = arm.solve(arm.forward_kinematics(q), arm_angle=-3.063102321959748, branch=0)
    assert solution
    assert np.isfinite(solution.q).all()
