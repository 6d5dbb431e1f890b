"""Postures that are known by construction lie in an interval of their pose, and all of an interval is met.

`benchmarks/known.py` tries many more.
"""

import runpy
from itertools import islice, product

import arms
import numpy as np
import pinocchio as pin
import pytest
from known_postures import BENCHMARKS, assert_all_is_met, assert_is_inside, assert_is_whole, postures, subjects
from oracles import distance, inside


@pytest.mark.parametrize("name", arms.here("iiwa14", "human_arm", "med7", "sia5d"))
def test_every_arm_angle_of_an_interval_is_met_next_to_singular_postures(name):
    """At its ends rounding turns joints by up to 1e-3 rad there; the other joint of a sum takes that over."""
    forward = arms.forward(name)
    together = ((1,), (5,), (1, 3), (3, 5), (1, 5), (1, 3, 5))
    asked = 0
    for q in postures(name, 16, 71, together, (0.0, 1e-12, 1e-10, 1e-8, 1e-7, 1e-6)):
        asked += assert_all_is_met(name, forward(q), 3)
    assert asked > 90


def test_all_branches_at_the_end_of_an_interval_are_those_of_the_single_call():
    arm, forward, seen = arms.load("iiwa14"), arms.forward("iiwa14"), 0
    for q in postures("iiwa14", 12, 72, ((1, 3), (1, 3, 5)), (1e-11, 1e-9)):
        pose = forward(q)
        for interval in arm.intervals(pose):
            found = {solution.branch: solution for solution in arm.solve_all(pose, arm_angle=interval.upper)}
            assert interval.branch in found, (q.tolist(), interval)
            assert inside(found[interval.branch].q, arm.lower, arm.upper)
            assert max(distance(pose, forward(found[interval.branch].q))) < 1e-9
            seen += 1
    assert seen > 100


@pytest.mark.parametrize("name", arms.here("iiwa14_experimental"))
def test_curves_that_pass_two_singularities_at_once_are_not_left_for_others(bench, name):
    """There a jump to the curve beside turns the orientation around twice, and is not noticed by it."""
    q = [-0.06701729400825007, -0.0001, -2.429632585369881, 0.2983243203429651, 1.9475864157432952, 0.0001]
    assert_is_inside(bench, name, np.array([*q, 1.3160759865457488]))
    for other in postures(name, 20, 75, ((1, 5),), (1e-4, 1e-5, 1e-6, 3e-4)):
        assert_is_inside(bench, name, other)


@pytest.mark.skipif("j2s7s300" not in arms.here("j2s7s300"), reason="its file is not here")
def test_branches_with_elbow_and_wrist_singular_at_once_are_found():
    """Small circles of postures, to which no curve from the closed form leads."""
    arm, forward = arms.load("j2s7s300"), arms.forward("j2s7s300")
    q = [2.985937919728815, 1.534871076382589, 0.3947498612416399, 3.141592653589761]
    q = np.array([*q, 3.0665552585174938, 3.1415926535899277, 3.0572950476729077])
    every = arm.solve_all(forward(q), arm_angle=arm.arm_angle(q), respect_limits=False)
    assert set(every.branch) == set(range(8))
    assert all(max(distance(forward(row), forward(q))) < 1e-9 for row in every.q)


CLOSE_BY = {
    ("gen3", 0): [
        "0.5984155073749924 -1e-09 1.0558592894443484 1.0682243919726542 1.4738365173376193 "
        "-0.03458205774042922 2.9557103813982746",
        # Joints that turn around by parts of a micrometre next to a straight elbow: on a limit, or just beyond it.
        "-2.598120688336936 2.24 1.8749718191262694 -1e-06 1.58993253260663 2.09 -0.048783035227106364",
        "2.9696909492466697 -2.24 -0.09508061066057838 1e-07 -3.1352929057160126 "
        "-1.7880309357999353 -0.7684797621927713",
        "-2.7914221406867425 -2.24 1.7134028517349718 0.0001 1.176483091279187 1.4828913444474545 0.19676563732605867",
    ],
    ("j2s7s300", 0): [
        # Where an elbow is straight its arm angle is told to 1e-8 rad, and so is that of the change of branch there.
        "2.130995984019207 3.141592753589793 2.991763013114899 3.141592753589793 2.2258989958073725 "
        "5.148721293383272 1.0117910136232453",
        "2.5304756717241936 0.8203047484383349 3.0014638961368485 3.141592643589793 2.9105184002872706 "
        "5.1487212933822715 -1.7351726641859466",
        # Curves that tell an arm angle only as they are cut by limits.
        "1.6063872127742451 3.141592653599793 0.2709376523238758 3.141592653599793 0.8220862257798358 "
        "1.1344640237963142 -2.3917267436155405",
        "1.0450881073363352 3.141592753589793 -1.5635617605249936 0.8579251355384148 2.3873548256653363 "
        "3.1415925535897933 0.9016508196793804",
    ],
    ("rm75", 0): [
        "2.9682368833495745 0.40820231949612795 0.6513487737450778 -1e-09 1.0939915116392878 1e-09 -0.7496628521163649",
        "2.110092102903869 1e-10 3.027496196872853 1.864686943095451 0.9865729218642731 -1e-10 0.5531856599955551",
        "2.677896433128184 -1e-09 -0.04033112868530386 1e-09 -1.024909238279215 1.5400094450368562 2.734962829322787",
        "-1.5912577351362547 0.0001 1.0575820629139305 -0.0001 1.3318739326404896 0.0001 2.6378742708935645",
        # The end of an interval on a limit, where a bend of 1e-4 rad tells arm angles to some 1e-9 rad.
        "-1.2222047747577167 -0.7418318199171408 0.5070213725527615 0.0001 -2.532735179841688 "
        "-0.16379695475083977 -1.134034149092435",
    ],
    ("random_near", 2): [
        "-0.7213337438396126 1e-08 -0.7240650453358386 0.0011407598631242803 1.0211663508107796 "
        "1e-08 1.8173237663600927",
    ],
    ("random_near", 7): [
        "-0.4747404334075611 1e-10 -5.116144803812902 -3.0859582214117984 -3.453464717923614 1e-10 -2.8955044332496307",
    ],
}
"""Postures next to several singularities at once, of arms and of those that `benchmarks/subjects.py` makes (seed 7).

Small closed curves pass them (gen3, the last one), curves that come so close to others that a step may lead to these,
arm angles that turn around, and limits that floats tell no better than to 1e-8 rad.
"""


@pytest.mark.parametrize(
    ("robot", "number"), [at for at in CLOSE_BY if at[0] == "random_near" or at[0] in arms.here(at[0])]
)
def test_curves_that_almost_meet_are_told_apart(bench, robot, number):
    """Each posture is in an interval of its pose, and every arm angle of every interval is met."""
    made = subjects()["arms_of"](robot, 120, 7)
    arm, _ = next(islice(made, number, None))
    for given in CLOSE_BY[robot, number]:
        q = np.array(given.split(), float)
        case = bench["Case"](q, arm.forward_kinematics(q).homogeneous, q, (), 0.0)
        intervals = arm.intervals(case.pose)
        # Where a bend of 1e-9 rad tells the arm angle, the posture closed with more bits decides.
        told = bench["beside"](arm, case, intervals) < 1e-6
        assert told or bench["is_found"](bench["Known"](arm), case, intervals)
        assert not list(bench["missed"](arm, [case], [intervals]))


BETWEEN = [
    "-1.7871225237392168 -0.08601570662656677 -1.857695883456233 -1.520620603427328 1.8945262529017572 1e-06 "
    "-0.7152140719500606",
    "2.3390830163487335 0.07826994082306565 -1.1066889079325866 -0.8892229174351649 1.0566799195304837 "
    "-0.0005441520322508546 -1.3618452937166914",
    "0.4564281541353754 -0.10078870046539105 -1.8524682658578584 2.0534140388412596 2.1750268634584016 "
    "-0.0003460479104536603 0.3894752740907519",
    "-1.989141867671505 0.0 1.515894513721963 2.036837463754163 3.10110207639255 0.0 0.6599879216960378",
]
"""Postures of a gen3 on closed curves of a tenth of a radian of arm angles, from a singular shoulder to a singular
wrist; the last is on one of 7e-6 rad where both are singular, between postures at which other curves almost cross."""


@pytest.mark.parametrize("given", BETWEEN)
def test_closed_curves_between_a_singular_shoulder_and_a_singular_wrist_are_found(bench, given):
    assert_is_whole(bench, arms.load("gen3"), np.array(given.split(), float))


STRETCHED_ALONE = [
    -3.4584821160417683,
    1.1908651334230003,
    -0.26660054344693696,
    0.0034879384050853198,
    2.260119694991869,
    -2.9763925659067256,
    -0.0755355699272795,
]
"""Only the elbow is next to singular, and steps in eight bring no start to the part of the curve that this is on."""


def test_starts_that_steps_in_eight_miss_lead_to_parts_of_intervals():
    """Given up with shoulder and wrist far from singular, they cost 0.1 rad of this interval."""
    q = np.array(STRETCHED_ALONE)
    made = runpy.run_path(str(BENCHMARKS / "subjects.py"))["random_arms"](np.random.default_rng(9), 1e-3, 0.0)
    arm = next(islice(made, 1, None))
    assert inside(q, arm.lower, arm.upper)
    pose = arm.forward_kinematics(q)
    branch, psi = arm.branch(q), arm.arm_angle(q)
    assert any(i.branch == branch and i.lower < psi < i.upper for i in arm.intervals(pose))


ALONE = [-0.2711505841443289, 0.0, 1.405866915567667, 1.7764747463181174, 2.835471058004974, 0.0, -0.34598129010373313]
"""Shoulder and wrist singular at once: a posture on no curve of its pose."""


@pytest.mark.skipif("rm75" not in arms.here("rm75"), reason="its file is not here")
def test_known_postures_are_lost_hidden_or_found(bench):
    """The judge: what no pose loses by rounding is lost if no interval has it, a posture on no curve is hidden."""
    arm = arms.load("rm75")
    known = bench["Known"](arm)
    for q, answer in ((np.array(ALONE), None), (np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2]), False)):
        pose = arm.forward_kinematics(q).homogeneous
        assert bench["is_found"](known, bench["Case"](q, pose, q, (), 0.0), []) is answer
    assert bench["is_found"](known, bench["Case"](q, pose, q, (), 0.0), arm.intervals(pose)) is True


def test_an_answer_with_another_arm_angle_is_told_by_its_elbow(bench):
    arm = arms.load("iiwa14")
    known, pose = bench["Known"](arm), arms.forward("iiwa14")(np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2]))
    found, psi = arm.solve_batch(np.array([pose, pose]), arm_angle=np.array([0.2, 0.3])), np.array([0.2, 0.3001])
    told = bench["elbows_elsewhere"](known, found, psi)
    assert found.ok.all()
    assert told[0] < 1e-12
    assert bench["ELSEWHERE"] < told[1] < 1e-4


TOUCHED_AT_A_WRIST = [
    "-0.7179199084875543 1e-07 -2.6452166102108987 2.5699999989999998 2.350226128770295 -1e-07 1.7709998928651656",
    "-2.777908546853088 1e-09 -1.58286656762695 -2.57 -0.46244313936385195 1e-09 -2.4036207798561597",
    "-1.078862100163997 -1e-12 -2.4825758397302997 2.5699999989999998 2.3011035449614488 -1e-12 0.03888198077085914",
    "0.1890625672475088 -1e-08 -1.5991306673211898 2.57 -0.8689518206356719 -1e-08 1.539124392647457",
    "-0.7912837967921491 1e-12 -1.6291445608380042 -2.57 -0.5772305248603362 1e-12 1.1953437654529484",
]
"""Of a gen3: the elbow comes back to its limit, by up to 1e-9 rad, where shoulder and wrist are singular."""


OFF_CURVES = [
    "-0.12 0.0 -0.92 -1.89 0.0 0.0 -0.28",
    "1.14 0.0 -1.03 -1.38 0.0 0.0 1.42",
    "-0.99 0.0 0.0 0.58 -0.16 0.0 1.16",
    "1.36 0.0 0.0 -0.35 0.47 0.0 -1.54",
    "1.27 1e-08 0.0 1.18 0.0 -1e-08 0.25",
    "0.65 1e-06 -1.03 -0.39 0.0 -1e-06 1.75",
    "0.2324145940381439 1e-08 1.4202001010477803 -2.5699999999 0.0033949994884356904 -1e-08 -3.0924542376499318",
]
"""Of a gen3, shoulder and wrist singular: no other posture of the pose is around, or a closed curve of 1e-3 rad."""


@pytest.mark.parametrize("given", TOUCHED_AT_A_WRIST + OFF_CURVES)
def test_where_the_wrist_is_singular_postures_are_in_an_interval(bench, given):
    """Limits that are touched left none; what no curve led to lay up to 11 mrad beside the curves around."""
    assert_is_whole(bench, arms.load("gen3"), np.array(given.split(), float))


def test_all_of_a_small_closed_curve_is_in_an_interval(bench):
    """Followed all around on Pinocchio's Jacobian, in steps of a thousandth of its length."""
    arm, first = arms.load("gen3"), np.array(OFF_CURVES[-1].split(), float)
    pose = arm.forward_kinematics(first)
    intervals, q, way, seen = arm.intervals(pose), first, np.zeros(7), 0
    for step in range(2000):
        to = np.linalg.svd(arm.jacobian(q))[2][6]
        way = to if to @ way >= 0.0 else -to
        q = q + 5e-6 * way
        for _ in range(4):
            here = arm.forward_kinematics(q)
            turn = here.rotation @ pin.log3(here.rotation.T @ pose.rotation)
            q = q + np.linalg.pinv(arm.jacobian(q)) @ np.r_[pose.translation - here.translation, turn]
        if step % 20 == 0:
            case = bench["Case"](q, pose.homogeneous, q, (), 0.0)
            assert bench["beside"](arm, case, intervals) < bench["BESIDE"], (step, q.tolist())
            seen += 1
        if step > 100 and np.abs(q - first).max() < 5e-6:
            break
    assert np.abs(q - first).max() < 5e-6
    assert seen > 20


ON_THE_LINE = [
    "-1.6905982145188356 -1e-06 2.262444538424402 -1e-06 -1.3497831175688073 0.04101666741545218 0.5626755074916785",
    "-0.4319744407004902 1.566606791939765 -0.0416011289077689 -1e-08 -2.3730955126194675 -1e-08 -4.943029627884295",
    "1.4442931598429962 0.0001 -2.2733104746952493 0.0 -1.6647015142007213 0.01 -1.837746181287348",
]


@pytest.mark.skipif("rm75" not in arms.here("rm75"), reason="its file is not here")
@pytest.mark.parametrize("given", ON_THE_LINE)
def test_what_is_met_all_around_the_line_from_shoulder_to_wrist_is_one_interval(bench, given):
    """Curves of a rounded arm turn around there within less than their steps: intervals had gaps that were none."""
    arm, q = arms.load("rm75"), np.array(given.split(), float)
    assert_is_inside(bench, "rm75", q)
    pose = arm.forward_kinematics(q)
    whole = [interval.branch for interval in arm.intervals(pose) if interval.width > 2.0 * np.pi - 1e-9]
    assert whole == list(range(8))
    for branch, psi in product(range(8), np.linspace(-3.0, 3.0, 9)):
        assert arm.solve(pose, arm_angle=psi, branch=branch)
