"""Postures that are known by construction lie in an interval of their pose, and all of an interval is met.

`benchmarks/known.py` tries many more.
"""

import runpy
import sys
from itertools import islice, product
from pathlib import Path

import arms
import chains
import numpy as np
import pinocchio as pin
import pytest
from oracles import distance, inside, phases, random_limb
from scipy.optimize import minimize

import srs_ik

TIGHT = {"xatol": 1e-12, "fatol": 1e-14, "maxiter": 600}
BENCHMARKS = Path(__file__).resolve().parents[1] / "benchmarks"


@pytest.fixture(scope="module")
def bench():
    sys.path.insert(0, str(BENCHMARKS))
    yield runpy.run_path(str(BENCHMARKS / "known.py"), run_name="known")
    sys.path.remove(str(BENCHMARKS))


def placed(name, q, joints, offset, rng):
    """A posture with some middle joints this close to singular, inside the limits; None where these forbid it."""
    arm, q, angles = arms.load(name), q.copy(), phases(arms.load(name).limb)
    for joint in joints:
        q[joint] = angles[joint] + offset * rng.choice([-1.0, 1.0])
    return q if inside(q, arm.lower, arm.upper) else None


def postures(name, count, salt, together, offsets):
    rng = arms.generator(name, salt)
    for number, q in enumerate(arms.configurations(name, count, salt)):
        for joints in together:
            near = placed(name, q, joints, offsets[(number + len(joints)) % len(offsets)], rng)
            if near is not None:
                yield near


def assert_all_is_met(name, pose, count):
    """Every arm angle of every interval has a posture in its branch, inside the limits, by Pinocchio."""
    arm, forward, asked = arms.load(name), arms.forward(name), 0
    for interval in arm.intervals(pose):
        for share in np.linspace(0.0, 1.0, count):
            psi = interval.lower + share * interval.width
            solution = arm.solve(pose, arm_angle=psi, branch=interval.branch)
            assert solution, (interval, share, solution)
            assert max(distance(pose, forward(solution.q))) < 1e-9
            assert inside(solution.q, arm.lower, arm.upper)
            asked += 1
    return asked


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


NEARLY_STRAIGHT = [
    [2.022509806951285, -1.6978942590630572, 1.0951563723747988, -0.03440066694748101, 1.9099775572521365],
    [0.8022066076768497, -1.4355679630019904, -0.6195359453834746, -0.008431414597084963, -0.016301992872528537],
    [-1.7629925920585412, -1.31943694094839, -0.08569091353850311, -0.06881983761089572, 0.6872961319085507],
    [1.2355251201268453, -0.9214670633663602, 2.6556836911895276, -0.04769062813452862, 1.2471541902707841],
]
"""Joints 1 to 5; the nearest exact arm has its elbow on the line from shoulder to wrist, or cannot reach."""


def assert_is_inside(bench, name, q):
    """The arm angle of a posture is in an interval of its branch, or where a joint is singular of either side of it."""
    arm, pose = arms.load(name), arms.forward(name)(q)
    away = bench["beside"](arm, bench["Case"](q, pose, q, (), 0.0), arm.intervals(pose))
    assert away < 1e-6, (away, q.tolist())


@pytest.mark.parametrize("name", arms.here("iiwa14_experimental"))
def test_both_bends_of_an_almost_straight_elbow_have_intervals(bench, name):
    """An arm whose axes miss by fractions of a millimetre bends its elbow where the nearest exact one is straight."""
    rng = arms.generator(name, 73)
    for given in NEARLY_STRAIGHT:
        assert_is_inside(bench, name, np.array([*given, 0.4, -0.9]))
    for q in arms.configurations(name, 60, 74):
        q[3] = rng.uniform(0.003, 0.08) * rng.choice([-1.0, 1.0])
        assert_is_inside(bench, name, q)


@pytest.mark.parametrize("name", arms.here("iiwa14_experimental"))
def test_small_curves_about_a_greatest_reach_have_intervals_where_rounding_decides(bench, name):
    """How far the limb reaches tells what starts of a straight elbow lead to, but not within rounding."""
    for q in (
        [2.8378766872454815, 0.12927798863992973, -1.0581080018381885, -0.0010340114436732668, 1.891047453117289,
         -1.1091486540319835, -0.4079414894517277],
        [-1.0556709500505725, -1.7071509724411085, 2.7498386472571266, -0.0010401585646910968, 1.0553554147314541,
         -1.8413548297134958, 1.3145614556600194],
        [-0.942343124455089, -1.6895466036658515, -1.636255585055987, -0.001029508667387744, -1.5683744914105693,
         -0.21026069673635414, 1.8772476949019659],
    ):  # fmt: skip
        assert_is_inside(bench, name, np.array(q))


@pytest.mark.parametrize("name", arms.here("iiwa14_experimental"))
def test_curves_that_pass_two_singularities_at_once_are_not_left_for_others(bench, name):
    """There a jump to the curve beside turns the orientation around twice, and is not noticed by it."""
    q = [-0.06701729400825007, -0.0001, -2.429632585369881, 0.2983243203429651, 1.9475864157432952, 0.0001]
    assert_is_inside(bench, name, np.array([*q, 1.3160759865457488]))
    for other in postures(name, 20, 75, ((1, 5),), (1e-4, 1e-5, 1e-6, 3e-4)):
        assert_is_inside(bench, name, other)


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


FLAT = {
    "human_arm": [
        "-0.6575933164735053 1.5707963266948965 0.05959711605541518 -1e-10 0.9886238527338576 -0.8922694439697152 "
        "0.029826158283755344",
        "-0.680644824880581 1.5707963167948966 1.1765871631176488 -1e-08 0.8983358559468375 0.32890206456146265 "
        "0.031005699200406467",
        "0.725662594813996 1.5707963266948965 -0.03984544526550504 -1e-10 -1.3041325637735413 0.7475897441085817 "
        "0.3365557268393749",
        "0.4830646206746233 -1.5707963267948966 0.8805544072151692 -0.012501040052796064 0.15368006489482777 "
        "-0.7926390240460277 0.35773421304969405",
    ],
    "human_left": [
        "1.162054333620211 1.6849384696079734 -0.11821314921415116 1e-10 2.0991747645379397 -1.5707963267948966 "
        "-0.4826207107606885",
        "1.2415146729092967 2.4252711474482647 1.3369233383290278 0.0 1.4442480550189116 -1.5707963267948966 "
        "-0.10769669693792094",
        "-1.6690967291663128 -0.3983764023857318 0.7641262049968292 1e-12 2.620299557323087 -1.5707963267958966 "
        "-0.4291917980531412",
    ],
    "iiwa14": [
        "2.610357463251722 -1e-12 -2.5427901793486454 1.9301338642994659 1.902878876355051 1e-12 2.2773352031315506",
        "-0.22357044633273748 -1e-08 -0.7360290300918404 -1e-08 -1.224445750958444 1e-08 1.1289412372969183",
        "1.6268403178582034 1e-12 1.770906534789523 -0.3993420134164394 1.3580566833804504 1e-12 0.37763141831666047",
    ],
}
"""Postures of exact arms: an elbow as good as flat next to a singular shoulder or wrist, or both of these singular."""


@pytest.mark.parametrize("name", FLAT)
def test_exact_arms_lose_nothing_next_to_singular_postures(bench, name):
    for given in FLAT[name]:
        assert_is_whole(bench, arms.load(name), np.array(given.split(), float))


ON_LIMITS = {
    "iiwa14": [
        # An elbow that is told to 1e-8 rad, two joints on limits.
        "2.9670597283903604 1.0851618413054882 -1.1635576430107546 -0.0001 -0.6713318880353674 2.0943951023931953 "
        "3.0543261909900767",
        # Limits that a joint almost touches: where the bend lets it.
        "-2.9670597183903604 0.4804281070081613 -0.9347916579729683 -1e-06 -2.9670597183903604 1e-06 1.721745058168385",
        "0.639097210870728 -0.4478024330709216 2.9670597283803604 0.0001 1.5465193923851963 -0.6413492589599881 "
        "3.0543261909800767",
        # An interval that the limits as they are leave no arm angle of, but for rounding: its end, too.
        "2.9670597283903604 1e-10 -2.9670597283903604 1e-10 1.8459012584321188 2.0943951023931953 0.13843927373726705",
        # Both outer joints of a singular shoulder.
        "-2.9670597283903604 0.0001 -2.9670597283903604 1.6584164185957495 -0.46429277943491964 -0.9110974133381942 "
        "3.0543261909900767",
    ],
    "human_arm": [
        "1.5707963267948966 -1.5707963167948966 -3.141592653589793 -0.44060925050757715 0.5716907685246475 "
        "-1.3962634015954636 -0.11267746473124199",
        "-0.10710158898492428 1.5707963167948966 -3.141592653589793 -1.1443244603554616 -0.11910509552754656 "
        "0.22150063460788694 -0.3490658503988659",
        "1.3803237164962385 1.5706963267948966 -3.141592653589793 -0.0001 0.7390399674937906 0.6716213640982602 "
        "0.5235987755982988",
        "1.4503313743234658 2.6179938779914944 0.1536831201213169 -2.4871883629073187e-09 -0.9321310218483052 "
        "1.2217304763960306 0.13117742090097534",
        # Three joints on limits, and the bend that the pose hides is the only one.
        "-0.6981317007977318 1.3761878257774467 0.44396614028080306 -1e-09 "
        "-1.3962634015954636 -0.04341593393264365 0.5235987755982988",
        "-0.6981317007977318 -1.5707963267938965 -3.141592653589793 -0.7103658427990986 "
        "1.3797692354926874 -1.3962634015954636 -0.09128482507312063",
    ],
    "human_left": [
        "1.0882440231912618 -0.016876387497678502 -1.4142958385214537 1.4151895948473872 3.14159 -1.5707963257948965 "
        "0.785398",
        "-1.3370532615594348 0.3400953688278556 0.5962926122608969 2.617991667 3.14159 -1.5707863267948965 0.785398",
        # A limit 3.7e-6 rad beside a singular angle, whose cosine floats do not tell from 1.
        "-1.743712437330728 -1.0472 -1.0173538968566571 1.478560980574802e-10 "
        "1.8382754670278877 -1.5708 -0.05175522114950182",
        # Limits that cross at three bends next to each other.
        "-1.8290523685960762 0.5413450828876143 -1.57079999 1e-06 -0.34906599 -1.5707953267948966 -0.78539799",
    ],
}
"""Postures next to singular ones with some joints on limits, each the only one of its arm angles, or at their end."""


@pytest.mark.parametrize("name", arms.here(*ON_LIMITS))
def test_postures_on_limits_next_to_singular_ones_are_in_intervals(bench, name):
    for given in ON_LIMITS[name]:
        assert_is_whole(bench, arms.load(name), np.array(given.split(), float))


TOUCHING = {
    5: "-2.8684032596452016 0.3054213257812291 5.087777304360135 -5.387786716970934 0.39413843468434084 "
    "-0.10276260937300391 -2.5391910372864244",
    19: "-0.7174938871743333 -3.086572593733182 -3.739669134626658 -1.4628445761106326 0.8534387655476015 "
    "2.9236443178520846 1.1674186038558148",
    26: "1.1592787791644916 -2.9133998537240693 0.10224463205868428 3.1415936535897933 -0.695284129385473 "
    "0.25744723177574863 -2.417626688551766",
}
"""Postures of arms with oblique axes, by their number: shoulder and wrist are both at the end of their reach."""


HIDDEN = {
    140: "0.04179738652474985 0.24381599978463156 -1.7302833177380836 1e-09 "
    "2.806676941600383 -4.959423631768023 0.15105646060373523",
    178: "5.298650821302228 -2.9091545159521477 -4.010521394644747 -1e-08 "
    "-0.2639596706467673 -1.2099660415282028 -5.004469313900547",
    200: "-3.301784310926493 3.016527774225868 5.256323582482743 0.0001 "
    "0.5987910851847529 0.15329650682634255 5.332607580969976",
    211: "2.061940064572428 0.2879182463277372 -5.217110428378039 -1e-07 "
    "1.8459857037051357 -0.11043229519269121 -3.4930726159145076",
}
"""Postures of such arms next to the end of a reach, with an elbow almost flat: some arm angles are met at one bend."""


LEANING = {
    3: "1.3011081325280989 -1.1066910033438636e-06 -5.626543744199689 -3.141592643589793 "
    "-1.3007985309728343 2.079599561982651 0.9568731280582519",
    34: "-3.5720377572285975 1.9194848684808212 1.939865594206303 -3.141592653489793 "
    "-2.907206716244333 1.9153729679798372 -1.9464673310588845",
}
"""Postures of arms whose axes lean by up to 1e-6 rad, with a folded elbow: its bend turns the arm about S-W."""


@pytest.mark.parametrize(
    ("kind", "seed", "cases"),
    [("random_oblique", 101, TOUCHING), ("random_oblique", 8802, HIDDEN), ("random_leaning", 6410000, LEANING)],
)
def test_postures_of_oblique_axes_at_the_end_of_their_reach_are_whole(bench, kind, seed, cases):
    made = [arm for arm, _ in islice(subjects()["arms_of"](kind, 10000, seed), max(cases) + 1)]
    for number, given in cases.items():
        assert_is_whole(bench, made[number], np.array(given.split(), float))


@pytest.mark.parametrize(("name", "joints"), [("human_arm", (1, 3)), ("human_left", (3, 5)), ("iiwa14", (1, 3, 5))])
def test_flat_elbows_next_to_singular_joints_lose_nothing(bench, name, joints):
    """The smaller the bend, the less a pose tells it; joints of a sum turn far with it."""
    arm, seen = arms.load(name), 0
    for q in postures(name, 60, 77, (joints,), (1e-10, 1e-9, 1e-8, 1e-7)):
        assert_is_whole(bench, arm, q)
        seen += 1
    assert seen > 15


def subjects():
    return runpy.run_path(str(BENCHMARKS / "subjects.py"), run_name="subjects")


def assert_is_whole(bench, arm, q):
    """A posture is in an interval of its pose, as closely as its bend is told, and all arm angles of all are met."""
    case = bench["Case"](q, arm.forward_kinematics(q).homogeneous, q, (), 0.0)
    intervals = arm.intervals(case.pose)
    bend = abs(np.sin(q[3] - bench["singular_angles"](arm.limb)[3]))
    away = bench["beside"](arm, case, intervals)
    assert away < bench["BESIDE"] + bench["ROUNDING"] / max(bend, 1e-300), (away, q.tolist())
    assert not list(bench["missed"](arm, [case], [intervals]))


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


WIDE = {
    0: "1.2908703028725057 -0.8624504872642724 -1.953645526299448 0.04305278008699093 -1.2568981027573767 "
    "-1.0725374870650524 -2.830081973127222",
    1: "0.5576461086257041 -1.4227713871444712 1.1020431089348863 -0.09165756061137117 0.12261893497800491 "
    "1.4455493758609217 -2.250764773754148",
}
"""Postures of arms whose axes miss by up to 12 mm, by their number: at a greatest reach, where the elbow of the nearest
exact limb is bent by 0.3 to 0.5 rad."""


@pytest.mark.parametrize("number", WIDE)
def test_greatest_reaches_are_found_where_the_nearest_exact_limb_is_well_bent(bench, number):
    """Next to one, a closed curve of a few tenths of a radian passes a posture."""
    arm = next(islice(subjects()["random_arms"](np.random.default_rng(21), 0.012, 0.0), number, None))
    for bend in (-1e-3, 1e-3):
        assert_is_whole(bench, arm, np.array(WIDE[number].split(), float) + bend * np.eye(7)[3])


LITTLE_MORE_THAN_FLAT = {
    "rm75": [
        "2.800983686790317 -1e-12 0.31337986579206145 -1e-12 0.6608257756371159 1e-12 -2.7478221329961077",
        "-2.1275177050842915 -1e-11 3.1 -1e-11 -1.3120675033912663 -1e-11 -3.864670392509532",
        "3.0999999000000003 -1e-06 -0.11459228026390589 -1e-06 -2.842992036818512 -2.2329999 4.7159834499139786",
        "-1.5436311092193324 1e-12 2.6219419444916174 1e-12 0.2410884952811192 -1e-12 3.723127533867019",
    ],
    "j2s7s300": [
        "-0.6291584108992576 1.9122919749756446 3.137276671381348 3.141592653579793 0.8916497433422235 "
        "1.7386054774177393 0.2248133714656948",
    ],
    "made_near": [
        "-0.27466659170716357 0.0 -0.4590226964706363 -0.27966438804115645 2.7766092915407268 0.0 -0.7057760027082431",
    ],
    ("random_near", 43): [
        "0.5246679728725647 -0.772455927841615 -0.10981481110027591 -0.000708140438594079 -0.5740426796095559 "
        "-3.1662272575437154 -3.4276265826931773",
    ],
}
"""Postures on closed curves of which little tells: the square of what axes miss by micrometres (rm75), or a reach that
is greater than the pose asks for by parts of a nanometre; the last of an arm by its number."""


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", [name for name in LITTLE_MORE_THAN_FLAT if isinstance(name, tuple) or name in arms.here(name)]
)
def test_closed_curves_of_which_little_tells_are_found(bench, name):
    made = subjects()["arms_of"]("random_near", 10000, 6410000)
    arm = arms.load(name) if isinstance(name, str) else next(islice(made, name[1], None))[0]
    for given in LITTLE_MORE_THAN_FLAT[name]:
        assert_is_whole(bench, arm, np.array(given.split(), float))


IN_ANOTHER_TURN = [
    "2.8678307946983885 0.01439782813373487 -0.24906101299832573 -1.0166241802240372 0.14959519499428486 "
    "-0.00745458719158799 -0.32771464163351594",
    "-1.0014838570735332 0.6018730577803297 -2.3830167270522793 0.5718856757746291 0.7540285074927628 "
    "-0.019269298622843902 -0.8279243280994448",
    "0.4392339047356524 0.012792937177646716 -1.5484239796154329 -0.7933626159001597 0.11886304334155007 "
    "0.004951235264810171 2.9330732133714275",
]
"""Postures of an arm whose joint 7 turns by almost a turn: of some of their pose, at the end of an interval, it is more
than half a turn from zero where the closed form of the nearest exact limb tells it."""


@pytest.mark.parametrize("given", IN_ANOTHER_TURN if "iiwa14_experimental" in arms.here("iiwa14_experimental") else [])
def test_a_joint_in_another_turn_than_its_limits_ends_an_interval(bench, given):
    assert_is_whole(bench, arms.load("iiwa14_experimental"), np.array(given.split(), float))


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


STRAIGHT_UP = [
    [0.5 * np.pi, -0.5 * np.pi, 0.0, 0.0, 0.0, 0.0, 0.5 * np.pi],
    [0.0, -0.5 * np.pi, 0.0, 0.0, 0.0, -0.5 * np.pi, 0.5 * np.pi],
    [-0.5 * np.pi, -0.5 * np.pi, 0.0, 0.0, 0.0, 0.0, 0.0],
]
"""Of a gen3: the elbow straight at the end of its reach, where the nearest exact limb has no posture."""


def outermost(arm, q):
    """A posture next to one with an almost straight elbow, of which no joint moves the tip along one direction."""
    straight = phases(arm.limb)[3]

    def least(x):
        posture = np.array([q[0], q[1], x[0], straight + x[1], q[4], q[5], q[6]])
        return np.linalg.svd(arm.jacobian(posture), compute_uv=False)[-1]

    turns = [minimize(least, (turn, 0.0), method="Nelder-Mead", options=TIGHT) for turn in (-2.0, 0.0, 2.0)]
    best = min(turns, key=lambda found: found.fun)
    q = q.copy()
    q[2:4] = best.x[0], straight + best.x[1]
    return q if best.fun < 1e-8 else None


@pytest.mark.parametrize("name", arms.here("gen3", "made_near", "j2s7s300"))
def test_poses_next_to_the_end_of_the_reach_are_met_where_it_is_greatest(bench, name):
    """There the elbow is left a small part of all turns about the line S-W, and a bend of up to 0.001 rad."""
    arm, asked = arms.load(name), 0
    for q in arms.configurations(name, 12, 73):
        end = outermost(arm, q)
        for bend in (-1e-3, 1e-4, 1e-3) if end is not None else ():
            near = end + bend * np.eye(7)[3]
            if inside(near, arm.lower, arm.upper):
                assert_is_inside(bench, name, near)
                asked += 1
    assert asked > 9


@pytest.mark.parametrize("q", STRAIGHT_UP)
def test_a_near_limb_stretched_out_has_the_interval_of_its_posture(q):
    arm = arms.load("gen3")
    T = arm.forward_kinematics(q)
    found = arm.intervals(T)
    answers = arm.solve_all(T)
    assert found
    assert len(answers) == len(found)
    for interval, answer in zip(found, answers, strict=True):
        assert max(distance(T, arm.forward_kinematics(answer.q))) < 1e-9
        assert interval.branch == answer.branch
        again = arm.solve(T, arm_angle=0.5 * (interval.lower + interval.upper), branch=interval.branch)
        assert again
    batch = arm.intervals_batch([T])
    assert batch.lower.tolist() == [interval.lower for interval in found]


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


ROUNDED = {
    0: "-1.1431686948816164 1e-08 -5.075971376377706 -2.4217844899021655e-09 4.741792707951234 2.6301426432651365 "
    "2.412537400743655",
    1: "-2.561950591386843 -1e-08 -1.8578825815589854 2.9496895087864914e-08 1.210965495333889 -1e-08 "
    "-1.0027270084713047",
    3: "-1.5913804140734116 -3.141592663589793 -4.833741821769592 3.617817950247627e-08 1.8988243209956828 1e-08 "
    "0.6965608892056481",
    7: "0.08911633826788545 -1.358731046843248 3.2699411832703444 -3.751643973259888e-08 -5.046081522310415 0.0 "
    "2.700418740654361",
    9: "-0.2602966120801615 -1.5037095316986928 -3.780659482208685 1.3959147444036035e-07 -5.901494043988516 1e-08 "
    "-0.7083293291458934",
}
"""Postures of arms whose axes miss by 1e-8 m: elbows on the line from shoulder to wrist, closer than what they miss."""


@pytest.fixture(scope="module")
def rounded():
    return [arm for arm, _ in islice(subjects()["arms_of"]("random_rounded", 10000, 9601), max(ROUNDED) + 1)]


@pytest.mark.parametrize("number", ROUNDED)
def test_elbows_of_rounded_arms_on_the_line_from_shoulder_to_wrist_lose_nothing(bench, rounded, number):
    assert_is_whole(bench, rounded[number], np.array(ROUNDED[number].split(), float))


@pytest.mark.slow
@pytest.mark.parametrize("number", [0, 7])
def test_an_elbow_on_the_line_is_at_every_arm_angle_in_all_kinds_of_call(rounded, number):
    arm, q = rounded[number], np.array(ROUNDED[number].split(), float)
    pose = arm.forward_kinematics(q)
    whole = [i for i in arm.intervals(pose) if i.width > 6.28]
    assert whole
    for motion in arm.self_motion(pose, count=9):
        assert motion.ok.all()
    for interval in whole:
        for psi in (-2.0, 0.3, 2.9):
            alone = arm.solve(pose, arm_angle=psi, branch=interval.branch)
            among = arm.solve_batch([pose.homogeneous], arm_angle=[psi], all_branches=True)
            for answer in (alone.q, among.q[0, interval.branch]):
                assert max(distance(pose, arm.forward_kinematics(answer))) < 1e-9
                assert inside(answer, arm.lower, arm.upper)


CLOSE_TO_FLAT = [
    "-2.319680924494283 -0.7996655876862502 2.7196371775311934 0.0001 2.995747387637652 0.7355529779117749 "
    "6.264610202286449",
    "-0.3014366807894784 1.9728236141034392 2.277368633341174 0.0001 0.27662174602722533 0.3018166509867868 "
    "-4.152802332517478",
]
"""Of an rm75: ends of intervals on a limit, whose arm angle rounding tells to 1e-8 rad, for axes miss by 1e-6 m."""


@pytest.mark.parametrize("given", CLOSE_TO_FLAT if arms.here("rm75") else [])
def test_ends_on_a_limit_next_to_a_flat_elbow_are_met(bench, given):
    arm = arms.load("rm75")
    assert_is_whole(bench, arm, np.array(given.split(), float))


def test_a_seed_next_to_a_stretched_near_limb_has_the_nearest_posture():
    """The true chain bends its elbow where the nearest exact limb does not reach: 0.42 rad too far."""
    arm = arms.load("gen3")
    q = np.array(
        [-2.992667730378908, 0, -0.34805971184642814, 0, 0.25333412359005436, -1.188728257542746, -2.850541690772822]
    )
    seed = np.array(
        [
            -2.9963437599061793,
            -0.12798635450949514,
            -0.30165691801852856,
            -0.0524606848062616,
            0.35199535637032725,
            -1.1941620840997695,
            -2.7854546677611145,
        ]
    )
    pose = arm.forward_kinematics(q)
    solution = arm.solve(pose, seed=seed)
    assert max(distance(pose, arms.forward("gen3")(solution.q))) < 1e-9
    assert inside(solution.q, arm.lower, arm.upper)
    assert np.linalg.norm(solution.q - seed) < np.linalg.norm(q - seed) + 1e-9


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


def on_limits(bench, arm, rng):
    """A configuration with two or three joints exactly on limits, and which ones."""
    q = bench["anywhere"](arm, rng)
    bounded = np.flatnonzero(np.isfinite(arm.lower) & np.isfinite(arm.upper))
    chosen = rng.permutation(bounded)[: rng.integers(2, 4)]
    for j in chosen:
        q[j] = arm.upper[j] if rng.random() < 0.5 else arm.lower[j]
    return q, chosen


@pytest.mark.parametrize("name", arms.here("gen3", "rm75", "j2s7s300"))
def test_arm_angles_at_which_joints_leave_no_room_are_intervals(bench, name):
    """Joints on limits that the self-motion leaves in opposite directions: a single arm angle, or next to it.

    The elbow of an almost exact arm turns so little with the arm angle that it tells the arm angle to 1e-6 rad alone.
    """
    arm, rng, single, asked = arms.load(name), np.random.default_rng(13), 0, 0
    for _ in range(60):
        q, chosen = on_limits(bench, arm, rng)
        pose = arm.forward_kinematics(q).homogeneous
        way = np.linalg.svd(np.asarray(arm.jacobian(q)))[2][-1][chosen]
        outward = way * np.where(q[chosen] == arm.upper[chosen], 1.0, -1.0)
        intervals = arm.intervals(pose)
        away = bench["beside"](arm, bench["Case"](q, pose, q, (), 0.0), intervals)
        assert away < (1e-5 if 3 in chosen else 1e-6), (away, q.tolist())
        single += outward.min() < 0.0 < outward.max()
        for interval in intervals:
            if interval.width < 1e-9:
                solution = arm.solve(pose, arm_angle=interval.lower, branch=interval.branch)
                assert solution, (interval, q.tolist())
                assert inside(solution.q, arm.lower, arm.upper)
                reached = arm.forward_kinematics(solution.q).homogeneous
                assert np.abs(reached - pose).max() < 1e-9
                asked += 1
    assert single > 15
    assert asked > 10


TOUCHED_BETWEEN = [
    [3.1, 2.268, 2.9606091816515847, -0.8569429252995913, -1.302831015266397, -1e-10, -2.855223645242845],
    [3.1, -0.4445539495400668, 2.603139700407328, 0.8790503211897698, -2.9750260302734706, 1e-11, -6.28],
    [-2.399233784138461, -1.5387995103873868, 3.1, 0.5353757763065787, 0.005483281420487263, 0.0, 6.28],
    [-3.1, -2.268, 3.1, 0.6877073636630309, -1.5384797208434275, 0.0, 2.0955607636734834],
]
"""Wrist singular, two or three joints on limits that they touch where q6 passes zero, between the only two samples of
an arc."""

ON_THREE_LIMITS = [
    [-0.14313786780524929, -0.8453783551810308, -0.6208581819800405, 2.355, 3.1, -0.01998563151131468, -6.28],
    [3.1, 2.268, 2.2700294336586473, 0.06322283054611633, 3.1, -1.9285089175285024, -4.6141291064945555],
]
"""Joint 5 on its way across the gap between its limits, elbow and joint 7 on theirs; two joints that come in at the one
arm angle at which a third goes out."""

ALONE = [-0.2711505841443289, 0.0, 1.405866915567667, 1.7764747463181174, 2.835471058004974, 0.0, -0.34598129010373313]
"""Shoulder and wrist singular at once: a posture on no curve of its pose."""


@pytest.mark.skipif("rm75" not in arms.here("rm75"), reason="its file is not here")
@pytest.mark.parametrize("q", TOUCHED_BETWEEN + ON_THREE_LIMITS)
def test_limits_that_are_touched_between_two_samples_leave_an_interval(bench, q):
    assert_is_inside(bench, "rm75", np.array(q))


def test_dips_of_a_curve_are_not_those_of_one_that_crosses_it():
    # Shoulder and wrist singular, the elbow on its limit: five arm angles of an interval of 3e-7 rad had no posture.
    q = [2.3423812671432627, -1e-11, -0.8404400367243801, -2.57, -1.951941743962961, -1e-11, 1.7471140868097867]
    assert assert_all_is_met("gen3", arms.forward("gen3")(np.array(q)), 7) > 20


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


STRAIGHT = {
    "rm75": (
        [1.1123280540383447, 1.9821440314516856, 0.07755995006912952, 1e-9, -1.8650065862553113, -0.4617920758379215,
         -6.044231983032412],
        [-0.7916038318313059, -0.4364553631638728, -0.06954912923565537, 1e-9, 1.3372344131400369,
         -0.8086425105614214, -2.705635080089331],
    )
}  # fmt: skip
"""Postures whose elbow is straight by less than their axes miss: whether they reach a pose is a matter of rounding."""


@pytest.mark.parametrize("name", arms.here("rm75", "gen3", "h1_2_left"))
def test_all_branches_of_a_straight_elbow_are_found(name):
    arm, rng = arms.load(name), arms.generator(name, 77)
    q = arms.configurations(name, 60, 77)
    q[:, 3] = rng.choice([0.0, 1e-12, 1e-9, 1e-7, 1e-6], len(q)) * rng.choice([-1.0, 1.0], len(q))
    for each in [*STRAIGHT.get(name, ()), *q]:
        psi = arm.arm_angle(each)
        found = arm.intervals(arms.forward(name)(each), respect_limits=False)
        turns = psi + 2.0 * np.pi * np.array([-1.0, 0.0, 1.0])
        assert any(((one.lower - 1e-6 <= turns) & (turns <= one.upper + 1e-6)).any() for one in found)
        if name == "rm75":
            assert {one.branch for one in found} == set(range(8))


@pytest.mark.slow
@pytest.mark.parametrize("name", arms.here("rm75", "gen3"))
def test_the_branch_of_an_answer_has_nothing_farther_when_it_is_asked_for(name):
    arm, rng = arms.load(name), arms.generator(name, 78)
    for q in arms.configurations(name, 40, 78):
        some = rng.random(3) < 0.6
        q[[1, 3, 5]] = np.where(some, rng.choice([0.0, 1e-12, 1e-9, 1e-6]), q[[1, 3, 5]])
        seed = np.clip(q + rng.normal(size=7) * rng.choice([1e-3, 0.05, 0.3]), arm.lower, arm.upper)
        pose = arms.forward(name)(q)
        nearest = arm.solve(pose, seed=seed)
        asked = arm.solve(pose, seed=seed, branch=nearest.branch)
        assert np.linalg.norm(asked.q - seed) < np.linalg.norm(nearest.q - seed) + 1e-6


@pytest.mark.parametrize(
    ("seed", "miss", "q"),
    [
        (4000, 0.002, [0.44779495, 0.74806712, 0.0872653, -0.88268985, 1.91135153, -1.38404507, 2.14363242]),
        (4003, 0.0005, [-1.21216406, -0.1112644, 0.49229373, 0.84896609, 1.27153143, 1.03958507, 0.36212286]),
    ],
)
def test_postures_with_an_almost_straight_elbow_that_steps_find_lie_in_intervals(seed, miss, q):
    """Some lie on small closed curves, between the arm angles at which curves were looked for."""
    limb = random_limb(seed, "coordinate", "offset", "usual", miss)
    arm, model = srs_ik.load(limb.model, base="base", tip="tool"), limb.model
    data, base, tool = model.createData(), model.getFrameId("base"), model.getFrameId("tool")

    def forward(x):
        pin.framesForwardKinematics(model, data, x)
        return data.oMf[base].actInv(data.oMf[tool])

    pose, rng, found = forward(np.array(q)), np.random.default_rng(0), set()
    intervals = arm.intervals(pose, respect_limits=False)
    for _ in range(300):
        x = rng.uniform(-np.pi, np.pi, 7)
        x[3] = q[3] + rng.uniform(-0.05, 0.05)
        for _ in range(40):
            left = pin.log6(forward(x).actInv(pose)).vector
            step = np.linalg.lstsq(pin.computeFrameJacobian(model, data, x, tool, pin.LOCAL), left, rcond=1e-12)[0]
            x = x + step * min(1.0, 0.5 / np.abs(step).max())
        if np.linalg.norm(left) > 1e-12:
            continue
        branch, psi = arm.branch(x), arm.arm_angle(x)
        # Next to an end, by what is left of the pose.
        near = (i for i in intervals if i.branch == branch)
        assert any(psi in i or min(abs(psi - i.lower), abs(psi - i.upper)) < 1e-6 for i in near), (branch, psi)
        found.add(branch)
    assert len(found) > 3, found


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


def assert_intervals_are_met(bench, arm, q):
    case = bench["Case"](q, arm.forward_kinematics(q).homogeneous, q, (), 0.0)
    intervals = arm.intervals(case.pose)
    assert intervals
    assert not list(bench["missed"](arm, [case], [intervals]))


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


MEETING_LIMITS = [
    # Both outer joints of an almost singular shoulder on limits, which leave one posture between them.
    ("rm75", "-3.1 1e-08 -3.1 2.355 -0.43731310752139807 -1e-08 -3.6440121822395137"),
    # A piece between two corners at which its curve almost crosses another one, and steps end.
    (
        "iiwa14_experimental",
        "-2.7854245335726118 -2.0941999999 1.7650668865708674 1e-11 1.4334861570178442 1e-11 -3.0540999999",
    ),
    # Joint 1 comes in where joint 5 goes out, into a narrow gap that two samples lie on either side of.
    (
        "rm75",
        "3.1 -0.7309720451723747 -2.6476531029293247 0.6357392411126366 -3.1 -0.00015851210158739011 4.313919301638815",
    ),
    # Joints 2 and 6 on limits, and an elbow that is bent so little that rounding moves both by 1e-10 rad.
    (
        "rm75",
        "0.538440843016263 2.268 0.37051202067565825 -1e-05 -1.5633951747910864 -2.233 2.774324376841162",
    ),
]


@pytest.mark.parametrize(("name", "given"), [at for at in MEETING_LIMITS if at[0] in arms.here(at[0])])
def test_postures_on_limits_of_almost_singular_joints_are_in_intervals_that_are_met(bench, name, given):
    q = np.array(given.split(), float)
    assert_is_inside(bench, name, q)
    assert_intervals_are_met(bench, arms.load(name), q)


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


BY_THE_LINE = (
    "1.05560754014479 0.8122907677080996 1.4280073527123909 1.5045997785507044 -0.6547039916547166 0.1930547181736849 "
    "-0.9453279473790397"
)


@pytest.mark.skipif("h1_2_left" not in arms.here("h1_2_left"), reason="its file is not here")
def test_arm_angles_next_to_where_the_elbow_passes_by_the_line_are_met(bench):
    """Between two samples the arm angle turns around, goes on by almost half a turn, and turns around again."""
    assert_intervals_are_met(bench, arms.load("h1_2_left"), np.array(BY_THE_LINE.split(), float))


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


NEXT_TO_SPLITS = [
    (70395, "coordinate", "offset", "mixed", 0.01, [1.3145426936650446, -1.5532381740301044, -1.3026693903051993,
     1.4522685571566245, 4.452225829066514, 1.4485193356004684, 2.9245010612433955]),
    (311043, "coordinate", "straight", "wide", 0.02, [3.3204711293105973, 1.573489703188206, 2.2268185748280804,
     0.013027555837399844, -0.5386823283212911, -0.6935802989394526, -2.197158346218642]),
    (206009, "coordinate", "offset", "usual", 0.005, [0.12788870833630456, -0.5344870300631738, 1.2294407555970257,
     1.2410742471897953, 1.9885936884225757, -1.6908131442784524, 0.6622384603181031]),
    (207014, "tilted", "straight", "mixed", 0.0001, [0.6832519083391366, -1.5912785210486362, -0.27521500456905634,
     -0.005397939028201989, -0.4555169239790726, 1.9269391073420123, 1.9666991393645312]),
    (207014, "tilted", "straight", "mixed", 0.0001, [0.6581807242035094, -1.584830680259096, -0.26755883770950706,
     0.0031275757686729374, -0.4584104551510193, 1.9268852359315833, 1.939075546733265]),
]  # fmt: skip
"""Random limbs, and postures on closed curves next to an almost straight elbow whose shoulder or wrist is almost
singular: as close to it as the upper arm turns with the bend. Some are 0.05 rad long."""


@pytest.mark.parametrize(("seed", "pattern", "elbow", "limits", "miss", "q"), NEXT_TO_SPLITS)
def test_closed_curves_next_to_free_splits_of_straight_elbows_are_found(seed, pattern, elbow, limits, miss, q):
    arm = srs_ik.load(random_limb(seed, pattern, elbow, limits, miss).model, base="base", tip="tool")
    found = arm.intervals(arm.forward_kinematics(q), respect_limits=False)
    assert any(arm.arm_angle(q) in each for each in found if each.branch == arm.branch(q))


FROM_A_SEED = [
    (
        "-3.099999999999 -1e-10 2.4321488624254894 1e-05 0.6714517476427377 1e-12 2.302254177997985",
        "-3.1 -0.14992571093748872 2.656040253502294 -0.1436866409425179 0.8366958984281264 -0.023205944019279823 "
        "2.3351765460535434",
    ),
    (
        "-1.2240901230524037 -1e-08 1.8422792701953186 -1e-05 2.6272727058063468 1e-09 -5.409149574229435",
        "-1.2076019778705482 -0.005127024862106787 1.8381622697274822 -0.0022660501786562347 2.641038620128045 "
        "0.014098619619983094 -5.397916313974166",
    ),
]


@pytest.mark.skipif("rm75" not in arms.here("rm75"), reason="its file is not here")
@pytest.mark.parametrize(("given", "seed"), FROM_A_SEED)
def test_an_elbow_on_the_line_keeps_no_nearer_posture_at_its_arm_angle_from_a_seed(given, seed):
    """The one that is at every arm angle is up to 7 rad away; rounding moves others along their curve by 1e-4 rad."""
    arm, q, seed = arms.load("rm75"), np.array(given.split(), float), np.array(seed.split(), float)
    pose, psi = arm.forward_kinematics(q), arm.arm_angle(q)
    for branch in (None, arm.branch(q)):
        found = arm.solve(pose, arm_angle=psi, branch=branch, seed=seed)
        assert np.linalg.norm(found.q - seed) < np.linalg.norm(q - seed) + 1e-4


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


MORE_THAN_HALF_A_TURN = {
    "h1_2_left": "0.710318579938376 1.8576118423365267 -0.6751398512789213 1.5045987785507045 -2.588009983751906 "
    "-0.19426729147689464 -0.6054057224128593",
    "iiwa14_experimental": "1.1216527487278345 0.094607262546055 1.7302881308064997 -1e-06 1.7275967185068737 -1e-06 "
    "-2.165151961955795",
}


@pytest.mark.parametrize("robot", [robot for robot in MORE_THAN_HALF_A_TURN if robot in arms.here(robot)])
def test_intervals_end_where_the_elbow_passes_by_the_line_on_its_other_side(robot):
    """Between two samples the arm angle goes on by more than half a turn: intervals went the other way around."""
    arm = arms.load(robot)
    pose = arm.forward_kinematics(np.array(MORE_THAN_HALF_A_TURN[robot].split(), float))
    found = arm.intervals(pose)
    assert len(found) > 4
    for one, share in product(found, np.linspace(0.0, 1.0, 41)):
        psi = one.lower + share * one.width
        assert arm.solve(pose, arm_angle=psi, branch=one.branch).status == "OK", (one, psi)


NEAREST_ON_LINE = [
    (
        "-0.9660110404694056 -2.1701430698361626 0.5387529470022083 -1e-11 -3.09999 0.30217282788171484 "
        "4.430904646576455",
        "-0.963552723118874 -2.1781855041975726 0.5342220464509713 -0.040372996527970516 -3.0704814402163505 "
        "0.28369438696752447 4.407488259680151",
    ),
    (
        "-3.1 -0.16763214853789066 2.2691012134650896 0.0 3.1 0.8215141191288065 6.28",
        "-3.1 -0.1715635585723825 2.2669008444219605 -0.0067595677314203385 3.097266952487304 0.8175947294967613 6.28",
    ),
    (
        "-2.0152669421727722 1e-12 -1.259402517491848 1e-12 -3.1 2.233 6.28",
        "-2.0153089441243504 -0.0005186217200306033 -1.259693166810799 -0.0004054008178165831 -3.1 2.233 6.28",
    ),
]


@pytest.mark.skipif("rm75" not in arms.here("rm75"), reason="its file is not here")
@pytest.mark.parametrize(("q", "seed"), NEAREST_ON_LINE)
def test_at_an_arm_angle_the_nearest_posture_to_a_seed_may_have_its_elbow_on_the_line(q, seed):
    """Of such elbows the first that was found was asked for, 6 rad away, and only where there was nothing else."""
    arm, q, seed = arms.load("rm75"), np.array(q.split(), float), np.array(seed.split(), float)
    for branch in (None, arm.branch(q)):
        found = arm.solve(arm.forward_kinematics(q), seed=seed, arm_angle=arm.arm_angle(q), branch=branch)
        assert found.status == "OK"
        assert np.linalg.norm(found.q - seed) < np.linalg.norm(q - seed) + 1e-3


@pytest.mark.parametrize("part", range(3))
def test_ends_of_intervals_are_where_a_joint_next_to_singular_meets_its_limit(part):
    """Of 1,000 ends 15 were up to 2e-8 rad too far out, where a joint is outside by as much: refused."""
    asked = 0
    for seed in range(100 * part, 100 * part + 100):
        rng = np.random.default_rng(seed)
        limb = random_limb(seed, ("coordinate", "tilted")[seed % 2], "offset", "usual")
        free = srs_ik.load(limb.model, base="base", tip="tool")
        q, joint = rng.uniform(-2.5, 2.5, 7), (1, 5)[rng.integers(2)]
        off = rng.choice([1e-7, 1e-8, 1e-9]) * rng.choice([-1.0, 1.0])
        q[joint] = phases(free.limb)[joint] + off + np.pi * rng.integers(2)
        lower, upper = q - rng.uniform(0.01, 3.0, 7), q + rng.uniform(0.01, 3.0, 7)
        (lower, upper)[rng.integers(2)][joint] = q[joint]
        limits = {n: {"lower": a, "upper": b} for n, a, b in zip(free.joint_names, lower, upper, strict=True)}
        arm = srs_ik.load(limb.model, base="base", tip="tool", limits=limits)
        pose = arm.forward_kinematics(q)
        for found in arm.intervals(pose):
            beside = min(1e-9, found.width)
            for psi in (found.lower, found.lower + beside, found.upper - beside, found.upper):
                solution = arm.solve(pose, arm_angle=psi, branch=found.branch)
                assert solution, (seed, found, psi)
                assert max(distance(pose, arm.forward_kinematics(solution.q))) < 1e-9
                assert inside(solution.q, arm.lower, arm.upper)
                asked += 1
    assert asked > 500


MET_AT_A_BEND = [
    (
        "random_leaning",
        18000107,
        55,
        "1.313203446269009 -9.293317614871398e-07 -3.792084664555084 -3.141592753589793 1.7779621894036906"
        " -4.6886017318902305e-07 -0.20774725468333655",
    ),
    (
        "random_rounded",
        16000000,
        89,
        "-3.0353634668310456 1e-11 4.811882431122668 -3.682754546591459e-09 0.7115345120125012 -1.7262786612810257"
        " 2.269636611462001",
    ),
    (
        "random_leaning",
        98000001,
        52,
        "2.719367834776833 -3.141602222756402 -2.7418310477397534 3.141582653589793 1.113249642945894"
        " 9.60077385718904e-06 -1.224700614212931",
    ),
]
"""Elbow almost flat: bends at which a wrist comes to the end of its reach, a posture beside all curves of its pose, and
an arm angle that limits allow for rounding alone. Seeds of the arms, their numbers, postures."""


@pytest.mark.parametrize(("robot", "seed", "number", "given"), MET_AT_A_BEND)
def test_arm_angles_of_almost_flat_elbows_are_met(robot, seed, number, given):
    """In up to 2 % of an interval, and at its only arm angle, no answer was found."""
    arm, _ = next(islice(subjects()["arms_of"](robot, 1000, seed), number, None))
    pose, asked = arm.forward_kinematics(np.array(given.split(), float)), 0
    for found in arm.intervals(pose):
        for psi in found.lower + np.linspace(0.0, 1.0, 501 if found.width else 1) * found.width:
            solution = arm.solve(pose, arm_angle=psi, branch=found.branch)
            assert solution, (found, psi)
            assert max(distance(pose, arm.forward_kinematics(solution.q))) < 1e-9
            assert inside(solution.q, arm.lower, arm.upper)
            asked += 1
    assert asked > 0


def test_a_narrow_gap_that_all_bends_of_an_elbow_leave_is_in_no_interval(bench):
    """Of 1.5e-3 rad, between what two bends tell: longer steps went over it."""
    arm, _ = next(islice(subjects()["arms_of"]("random_leaning", 1000, 98400001), 66, None))
    q = "2.0668795286884976 6.637447004745434e-07 3.0841731840117097 -1e-08 -2.0511851476045697"
    assert_intervals_are_met(bench, arm, np.array(f"{q} 1.1883963542733033e-06 1.6383311312905082".split(), float))


def test_a_posture_between_two_limits_is_in_an_interval_where_the_elbow_is_almost_folded(bench):
    """One joint comes in at the arm angle where another goes out; what was looked at was farther off than thought."""
    arm, _ = next(islice(subjects()["arms_of"]("random_rounded", 1000, 22100106), 65, None))
    q = "1.7551844651575452 -3.256247765856609 3.4700406135626105 3.135274764068097 0.8645745312505797"
    q = np.array(f"{q} 3.5426702070960854 1.6821017689376854".split(), float)
    pose, psi, branch = arm.forward_kinematics(q), arm.arm_angle(q), arm.branch(q)
    away = [max(i.lower - psi, psi - i.upper) for i in arm.intervals(pose) if i.branch == branch]
    assert min(away) < 1e-9
    assert_intervals_are_met(bench, arm, q)


SLOW_ELBOWS = [
    (0, "-5.305377050926522 -0.4361130506359818 -1.3425870636144008 4.064385660980546 -1.5474114084837058 "
        "5.119097749879657 1.0751495708385908"),
    (10, "-0.008327013976169972 -3.8812328885147576 1.3150194640390316 1.9568145381026159 -2.3881160968941706 "
         "2.8688728701392554 -5.003679887196347"),
    (21, "0.8275977552127358 0.8723782154271902 2.700824097686321 -1.666752465218698 4.066097716525877 "
         "5.904494962449411 -4.378662069945197"),
    (23, "-0.22787196441728086 -2.2816202348851475 3.176064478391794 2.0780011550889066 -0.35143312026046836 "
         "-1.4236043321246123 -2.9464547576311197"),
]  # fmt: skip


@pytest.mark.parametrize(("number", "given"), SLOW_ELBOWS)
def test_an_interval_ends_where_an_elbow_on_its_limit_leaves_it_slowly(bench, number, given):
    """The arm angle turns such an elbow by 1e-8 of its own way, so 1e-13 rad of it are 1e-5 of that."""
    arm, _ = next(islice(subjects()["arms_of"]("random_rounded", 1000, 91000001), number, None))
    q = np.array(given.split(), float)
    pose, psi, branch = arm.forward_kinematics(q), arm.arm_angle(q), arm.branch(q)
    turns = [abs(i.lower + 0.5 * i.width - psi) % (2.0 * np.pi) for i in arm.intervals(pose) if i.branch == branch]
    widths = [i.width for i in arm.intervals(pose) if i.branch == branch]
    away = [min(turn, 2.0 * np.pi - turn) - 0.5 * width for turn, width in zip(turns, widths, strict=True)]
    assert min(away) < 1e-6
    assert_intervals_are_met(bench, arm, q)
