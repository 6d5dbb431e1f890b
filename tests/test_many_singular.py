"""Almost exact limbs where two or three of shoulder, elbow and wrist are singular at once."""

import runpy
import sys
import time
from itertools import islice
from pathlib import Path

import arms
import numpy as np
import pinocchio as pin
import pytest
from oracles import inside

BENCHMARKS = Path(__file__).resolve().parents[1] / "benchmarks"
NAMES = (*arms.here("rm75"), "random_0", "random_1")
RM75 = tuple(name for name in arms.here("rm75") if name == "rm75")
TOGETHER = ((1, 3), (3, 5), (1, 5), (1, 3, 5))
MISS = 1e-6

LEFT = 1.001e-10
"""Error of a pose (m, rad) that Newton's method may leave at such a posture, and rounding."""

LOST = 1
"""Known postures of 30 that no interval holds, at most."""

LONGEST = 10.0
"""A self-motion of a pose takes no longer, s, on a busy machine; a minute where each sample follows all curves."""

SOLVED = 1e-9
"""Error of a pose (m, rad) of what is a solution."""

WRIST_ON_LIMIT = (
    -3.0999999000000003,
    -0.4426582573768174,
    -2.5697617364849155,
    0.9808343285365004,
    3.0999999000000003,
    0.0,
    1.8717049336601148,
)
"""One with a singular wrist, and joints 1 and 5 on limits but for 1e-7 rad."""


SMALL_CURVE = (
    (3.1273534513657184, 1e-08, 0.4942473691486926, -1.8131530949631356, 1.0149030700177688, 1e-08,
     -2.8257378564871733),
    (3.1791732725426263, 0.0782338395867388, 0.5770636685856487, -1.8441502337628881, 1.0516558476957099,
     0.0905117144796707, -2.8959834055313474),
    (3.13185, 0.000124, 0.48971, -1.81324, 1.06521, -0.0000535, -2.876),
)  # fmt: skip
ANOTHER_TURN = (
    (-4.843234605999712, 2.1798118856162088, 1.3081877125158732, -1.5214931010743458, -1.4536207031511634, -1e-12,
     -2.705600594172021),
    (1.9732028411968594, 3.119851737826802, 1.0974394498804712, 4.818332457873422, -4.222058597326704,
     -1.4173591305161102, -4.883011497657262),
    (-0.04402, 2.33414, -1.09368, 4.75985, -4.02027, -1.05739, -5.03822),
)  # fmt: skip
"""A posture whose pose is asked for, a seed, and about where another posture is that is nearer to that: on the other
side of a small closed curve; and where joint 7 is on a limit, beyond which it goes on a turn away."""


NEEDLES = [
    ((0.7019016130668634, -1.7236701894459932, 0.2898864677704913, 0.0, -2.2743501762442575, 2.2329999000000003,
      -2.374146819526991),
     (-1.3885517645949348, -0.9119924128597396, -1.8264850425205206, 1.1373623620063045, 2.526986025352469,
      2.0693276048329223, -3.0800165551337866)),
    ((-0.4757429334853458, 1.4951542290643167, 1.4000546224068233, 0.0, 0.6506225425067758, -1.2446782157311456,
      -0.8713688884260948),
     (-1.5831290023323585, -0.5156150747312698, 2.8502077141572406, 1.2049635982686047, -0.08940117615869791,
      -1.1070741583871453, -3.839918949656922)),
]  # fmt: skip
"""Postures of a straight elbow whose pose is asked for, and seeds: the curve turns around in a needle."""

ON_TWO_LIMITS = (
    (-3.1, -1.6878948150353028, -0.36410796686015257, -1e-09, -1.516886136210061, 2.233, 1.6292694241087338),
    (-2.9510526716141197, -1.574769084270125, -0.3567986103621665, -0.1445866694622516, -1.5553774866238377, 2.233,
     1.5098949637371857),
)  # fmt: skip

NEXT_TO_A_LIMIT = (
    (-2.028584903632845, 2.175343791663945, -2.7610408098257815, 0.0016538253736340931, -0.7795206342430285,
     -5.318485514746554, -2.573048350979516),
    (-1.99943536499732, 2.248202307671621, -3.170342895977315, -0.06253038983277907, -0.4082551840034092,
     -5.318495514746553, -2.573058350979516),
)  # fmt: skip
"""The same where rounding decides at which postures the elbow's turn leaves the limits; there, about 2e-5 rad of a turn
are left."""

BETWEEN_LIMITS = (
    (-3.1, 2.268, -2.625771845570208, 0.0, -3.1, 0.0, 4.188100740587639),
    (-3.0553982212749737, 2.231617837360167, -2.56914801519736, -0.0514688735371348, -3.1, -0.012459638176236014,
     4.191457425813439),
)  # fmt: skip
"""Shoulder and wrist of the posture keep the limits by less than the pose tells; the seed is 0.1 rad beside it."""

SHORT_STRETCH = (
    (-3.594031126, -0.752451305, -3.4692, 3.155265985, 0.120646726, 0.20893254, 0.968746602),
    (-0.958259371, -1.538617541, -3.413798827, 2.211201141, -0.862576396, 3.33861573, 0.875111793),
)
"""A posture and a seed: joints 1 and 3 are in these turns on a short stretch of the curve alone."""

TIPS = [
    ("random_rounded", 79000001, 8,
     (-0.5158817681537791, 1e-12, 2.0083794006973266, -7.597411402207652e-08, 5.517230401232952, 1e-12,
      3.673029559072515),
     (-0.9340817443140212, -0.3227659237077664, 2.392448388733022, -0.22949489949933163, 5.250098642574679,
      -0.4766532267950527, 3.8801336776234776),
     (-0.6954703113115528, -1.4175841080308052e-08, 2.342183565624579, -8.426673637220657e-08, 5.141200179990194,
      -1.654932216848715e-09, 3.894844158545794)),
    ("random_oblique", 77000001, 87,
     (1.5816032231880284, -0.07779234729968154, 1.5589574648623605, 0.0, -3.8200632267850687, -3.0745468079253016,
      -0.11511241705960984),
     (1.6032800224261745, -0.06296586604705161, 1.560369890834407, 0.006261663085052757, -3.8354616714523053,
      -3.086249987563821, -0.09401316208917133),
     (1.5826221035519679, -0.07747253961399553, 1.5578871742586797, -2.411578133128487e-07, -3.8196198045170204,
      -3.0747261687033207, -0.11465851801240169)),
]  # fmt: skip
"""Made arms, by kind, seed and place; postures with shoulder, elbow and wrist singular, seeds, and postures that are as
near to these as steps along those of the pose lead."""

LEVERS = [
    ("random_rounded", 97000001, 20,
     (0.2712086912411005, 0.0, -5.215480040675378, 1.7727550538637615e-08, -3.787635409595604, 0.0,
      -2.3936284018451985),
     (0.4596826109586072, 1.1657517361545036, 0.8885223942316856, -4.151390264557091, 2.558013566062897,
      0.801556187862297, -3.1480756926088977),
     (0.6653338071844572, 8.694382329056042e-09, 0.8566616856766451, 2.15758083243589e-08, 2.81410556280323,
      1.0391297153188184e-08, -2.8952656021802388)),
    ("random_rounded", 97000001, 36,
     (2.599874201324135, 0.0, -0.911720707266007, -6.643188665833577e-09, 0.07874322836805181, 0.0,
      0.8176021565270197),
     (2.4957181200965444, 2.124003295383896, -0.35952852412528724, 1.3386562460973046, 0.7946061195606644,
      2.8079258207111737, 0.4487468463443749),
     (2.7921220763797816, 4.4424248448767534e-09, -0.7621403611948232, -7.270920086214062e-09, 0.3647242814137575,
      -2.3563856482148345e-09, 0.18979288235448274)),
    ("random_rounded", 97000001, 94,
     (2.9352856661720175, -5.164060469613336, 1.4573487585304528, -3.1415926453173473, -1.7294328846136184, 0.0,
      3.9414216289756094),
     (-0.3022813859844047, -3.5317194564012726, 1.9233776538231537, 0.38528199044545897, 0.5248528627232845,
      5.681294989779049, 0.957530757867235),
     (-3.347899792106374, -5.164060469613336, 2.1264236665545804, -3.1415925643873543, 1.1675422341175303,
      6.283185390720059, 1.7135213523184873)),
    ("random_rounded", 96000001, 55,
     (3.7748286023101407, -0.0001, -4.423817389147723, -9.996345760555628e-05, 0.029665974108886495,
      -2.5700980365658532, 2.972203701880309),
     (-2.031168872545316, -3.4441043391234007, 3.506999247475223, -2.8833227933928995, -1.1877928351891787,
      0.005556711443524431, 3.0610092560255753),
     (-2.5008457642493895, -0.00010233881352805435, 1.9122624115975984, -9.996752736886806e-05,
      -0.030733895505349242, -2.5700980365658532, 2.972210317645688)),
]  # fmt: skip
"""The same, of postures where an error of 1e-12 m, or a joint 1e-9 rad beside its limit, is worth 1e-4 rad or more; the
last one is closed with 40 digits, since one of 3e-15 is worth 3e-6 rad there."""

ELSEWHERE = [
    ("random_near", 52200001, 6,
     (-2.369356321047101, 1e-05, -0.1331738982156101, -0.00016600798461878895, -0.07682620269323048, 1e-05,
      -1.998649725187788),
     (-0.9853716265177663, 2.0631773258383577, -0.8100855285355615, -5.472479445261488, 0.043542479667716405,
      0.7069795379349157, 2.2995980307587587),
     (-2.4026346613466418, -3.0946605458208686e-05, -0.13173130770479236, -0.00012282238963197677,
      -0.0035491008082875592, 7.4311023835971529e-06, 4.2430942302915753)),
    ("random_rounded", 22200106, 21,
     (2.6277481418674515, -0.7570997715195609, -1.7563590149825292, 2.837465942814765e-08, -1.0198399396168925,
      -2.4696258321571603, -2.8530698090103273),
     (2.6277481418674515, -0.7034938410067859, -1.6354050162365787, 0.1338096594254328, -1.1841219943694004,
      -2.3636108331141585, -2.681774877772474),
     (2.6277481418674515, -0.7570997715195609, -1.7563590149825292, 2.837465942814765e-08, -1.0198399396168925,
      -2.4696258321571603, -2.8530698090103273)),
    ("random_oblique", 97000001, 14,
     (0.861099524302867, -0.03968189907601314, 4.494957926241266, 1e-12, -0.18960876602473364, 0.05546514773334712,
      -1.0158092536930048),
     (0.9305396741821881, -1.4638392277209806, 5.256997515008216, 2.887434292531318, 0.9326549793152643,
      3.5580397761485987, -2.7038466490586197),
     (0.861099524302867, -0.03968189907601314, 4.494957926241266, 1e-12, -0.18960876602473364, 0.05546514773334712,
      -1.0158092536930048)),
    ("random_near", 99100001, 42,
     (-1.669731783036523, 0.0, -1.33063989847887, 0.00198269451478561, -2.29119887027784, -3.472209384767584,
      4.693913166270736),
     (-1.423219542876549, 1.7096284723453032, -0.01573521146702639, -4.747898707952486, -1.3223525483714416,
      1.05926781303139, 3.826044883956513),
     (-1.669731783036523, 0.0, -1.33063989847887, 0.00198269451478561, -2.29119887027784, 2.8109759224120023,
      4.693913166270736)),
    ("random_rounded", 99100001, 97,
     (1.1377832703322213, 1.6947147481092286, -3.43736792722552, -3.0369013045564013, -4.491982969856736, -0.0001,
      4.424244137691678),
     (-0.11856493014807601, 4.236860769019444, 0.38807228967272245, -1.5453968875823636, 1.451629158812528,
      2.253207307326316, -2.0639661517475334),
     (-1.8135818448122834, 4.333663109287814, -1.5882496686263776, -3.0369013045564013, 0.9163746660813274,
      -0.44299733127534024, -2.292768954985959)),
    ("random_rounded", 99300001, 30,
     (3.644278964508418, 4.510104997287413, -1.4656686115732358, 3.141592668127239, -1.2756835629669645,
      3.8304576041408973, -4.840531081908657),
     (3.6275737093640723, 4.510104997297413, -1.4637727799682498, 3.1244161366315013, -1.2596345175297763,
      3.822709656188526, -4.835970350027931),
     (3.644278964508418, 4.510104997287413, -1.4656686115732358, 3.141592668127239, -1.2756835629669645,
      3.8304576041408973, -4.840531081908657)),
]  # fmt: skip
"""The same, of postures that are nearer elsewhere: on a small closed curve to whose centre 13 steps lead, with joint 7,
beyond a limit but for rounding, a turn away, in an interval of 4e-5 rad, where the reaches of shoulder and wrist end,
where joints 5 and 7 come to limits in turns that other postures do not have, where an elbow that moves by 1e-8 rad
along its curve leaves a limit, and where a folded elbow leaves limits of three joints one posture."""

FARTHER_INSIDE = (
    (0, (2.8883971832896487, 1e-10, -3.1655901855809496, -2.4773068477198968e-08, 0.4426132107692151, 1e-10,
         5.306572392300396),
     (-0.8027790093453171, -2.890558187013737e-08, -0.35088483263244685, 3.035606724753772e-09, -0.835265285561845,
      1.2250792586613576e-08, 1.1777364211383752)),
    (3, (5.257255315654201, -1e-12, 0.11254253768103073, -5.0928311701087775e-08, 0.9552087131933957,
         3.141592653590793, -4.293031013281334),
     (3.2892467411905315, 9.128351263366757e-08, -0.13871229834378773, -3.459679028181974e-08, -2.0107949000431393,
      3.141592712404617, -3.1951127298267763)),
    (5, (2.941038226892365, -1e-07, 2.796266262421305, 1.0830701832509244e-08, -3.3151851940933734,
         -1.2383498227818523, 0.1997720854074414),
     (1.672251010038098, -2.530163037886311e-08, 2.1791577874006127, -2.996802621147668e-08, -1.4292894887392606,
      -1.2383498975436251, 0.19977204410551025)),
)  # fmt: skip
"""Random limbs by their numbers, a posture that no curve is led to, and one of its pose farther from the limits."""

STRIDE = 1e-3
AS_WELL = 2e-13
"""A step beside an answer, rad, and the error (m, rad) with which it is no worse a posture."""


@pytest.fixture(scope="module")
def judges():
    """The scripts that try many more: their arms, seeded answers, and intervals."""
    sys.path.insert(0, str(BENCHMARKS))
    names = ("subjects", "singular", "known")
    yield {name: runpy.run_path(str(BENCHMARKS / f"{name}.py"), run_name=name) for name in names}
    sys.path.remove(str(BENCHMARKS))


def load(judges, name):
    """A real arm of a file with rounded figures, or a made one whose axes miss by as much."""
    if not name.startswith("random"):
        return arms.load(name)
    made = judges["subjects"]["random_arms"](np.random.default_rng(5), MISS, 0.0)
    return next(islice(made, int(name.split("_")[1]), None))


@pytest.mark.parametrize("joints", TOGETHER)
@pytest.mark.parametrize("name", NAMES)
def test_known_postures_bound_the_distance_from_any_seed(judges, name, joints):
    """Seeds from a breath to a radian beside the posture of which the pose is."""
    arm, rng = load(judges, name), np.random.default_rng(72)
    farther = 0
    for case in judges["singular"]["cases"](arm, 12, rng, (joints,)):
        seed = np.clip(case.q + rng.uniform(-1.0, 1.0, 7) * 10.0 ** rng.uniform(-3.0, 0.0), arm.lower, arm.upper)
        solution = arm.solve(case.pose, seed=seed)
        assert max(arm.verify(case.pose, solution.q)) < LEFT
        assert inside(solution.q, arm.lower, arm.upper)
        farther += np.linalg.norm(solution.q - seed) > np.linalg.norm(case.q - seed) + 1e-9
    assert farther == 0


@pytest.mark.parametrize("joints", TOGETHER)
@pytest.mark.parametrize("name", NAMES)
def test_known_postures_bound_the_distance_from_any_seed_in_their_branch(judges, name, joints):
    """The branch of a posture next to a border is asked for: what rounding does not tell from it counts as in it."""
    arm, rng = load(judges, name), np.random.default_rng(79)
    farther = 0
    for case in judges["singular"]["cases"](arm, 25, rng, (joints,), 0.3):
        seed = np.clip(case.q + rng.uniform(-1.0, 1.0, 7) * 10.0 ** rng.uniform(-3.0, 0.0), arm.lower, arm.upper)
        solution = arm.solve(case.pose, seed=seed, branch=arm.branch(case.q))
        assert max(arm.verify(case.pose, solution.q)) < LEFT
        assert inside(solution.q, arm.lower, arm.upper)
        farther += np.linalg.norm(solution.q - seed) > np.linalg.norm(case.q - seed) + 1e-6
    assert farther == 0


@pytest.mark.parametrize("case", [SMALL_CURVE, ANOTHER_TURN], ids=["small curve", "another turn"])
def test_postures_that_are_nearer_elsewhere_on_a_curve_are_found(judges, case):
    """The other one is closed by Newton's method on Pinocchio's Jacobian: no answer may be farther than that."""
    q, seed, nearer = np.array(case)
    if case is SMALL_CURVE:
        arm = arms.load("gen3")
    else:
        arm = next(judges["subjects"]["random_arms"](np.random.default_rng([6500000, len("random_near")]), 2e-4, 0.0))
    pose = arm.forward_kinematics(q)
    for _ in range(10):
        here = arm.forward_kinematics(nearer)
        turn = here.rotation @ pin.log3(here.rotation.T @ pose.rotation)
        nearer = nearer + np.linalg.pinv(arm.jacobian(nearer)) @ np.r_[pose.translation - here.translation, turn]
    assert max(arm.verify(pose, nearer)) < SOLVED
    assert inside(nearer, arm.lower, arm.upper)
    solution = arm.solve(pose, seed=seed)
    assert max(arm.verify(pose, solution.q)) < SOLVED
    assert np.linalg.norm(solution.q - seed) < np.linalg.norm(nearer - seed) + 1e-9


def farthest_out(arm, q):
    """Of all joints with limits, the largest distance from the middle of the range, as a part of half the range."""
    limited = np.isfinite(arm.lower) & np.isfinite(arm.upper)
    middle, half = 0.5 * (arm.lower + arm.upper)[limited], 0.5 * (arm.upper - arm.lower)[limited]
    return np.abs((np.asarray(q)[limited] - middle) / half).max()


@pytest.mark.parametrize(("number", "q", "other"), FARTHER_INSIDE, ids=[str(case[0]) for case in FARTHER_INSIDE])
def test_postures_that_no_curve_is_led_to_are_as_far_from_the_limits_as_others(judges, number, q, other):
    """Such a posture was looked for at arm angles all around before, and not where joints are free to turn."""
    arm, _ = next(islice(judges["subjects"]["arms_of"]("random_rounded", 1000, 19000001), number, None))
    pose = arm.forward_kinematics(q)
    assert max(arm.verify(pose, other)) < AS_WELL
    assert inside(np.array(other), arm.lower, arm.upper)
    solution = arm.solve(pose)
    assert solution.status == "OK"
    assert max(arm.verify(pose, solution.q)) < LEFT
    assert farthest_out(arm, solution.q) < farthest_out(arm, other) + 1e-3


def beside(arm, q, pose, seed, stride):
    """The posture a stride along the self-motion from one, towards a seed, by Pinocchio's Jacobian: it, and its error.

    What is as good as lost of the pose is left out of the steps.
    """
    way = np.linalg.svd(arm.jacobian(q))[2][6]
    q = q + stride * np.sign(way @ (seed - q)) * way
    for _ in range(5):
        here = arm.forward_kinematics(q)
        turn = here.rotation @ pin.log3(here.rotation.T @ pose.rotation)
        q = q + np.linalg.pinv(arm.jacobian(q), rcond=1e-7) @ np.r_[pose.translation - here.translation, turn]
    return q, max(arm.verify(pose, q))


@pytest.mark.parametrize("case", NEEDLES)
@pytest.mark.parametrize("name", RM75)
def test_needles_of_straight_elbows_are_gone_along_to_their_tips(name, case):
    arm, (q, seed) = arms.load(name), np.array(case)
    pose = arm.forward_kinematics(q)
    solution = arm.solve(pose, seed=seed)
    assert max(arm.verify(pose, solution.q)) < LEFT
    other, error = beside(arm, solution.q, pose, seed, STRIDE)
    nearer = np.linalg.norm(other - seed) < np.linalg.norm(solution.q - seed) - 1e-6
    assert not (nearer and error < AS_WELL and inside(other, arm.lower, arm.upper))


def assert_is_no_farther(judges, case):
    """The answer to a seed is no farther from it than a posture that meets the pose as well as floats tell."""
    kind, seed, place, q, start, nearer = case
    arm = next(islice((arm for arm, _ in judges["subjects"]["arms_of"](kind, 1000, seed)), place, None))
    pose = arm.forward_kinematics(q)
    assert max(arm.verify(pose, nearer)) < AS_WELL
    assert inside(np.array(nearer), arm.lower, arm.upper)
    solution = arm.solve(pose, seed=start)
    assert max(arm.verify(pose, solution.q)) < LEFT
    assert np.linalg.norm(solution.q - start) < np.linalg.norm(np.subtract(nearer, start)) + 1e-6


@pytest.mark.parametrize("case", TIPS, ids=["rounded", "oblique"])
def test_steps_where_three_parts_are_singular_end_where_none_leads_nearer(judges, case):
    assert_is_no_farther(judges, case)


@pytest.mark.parametrize("case", LEVERS, ids=["closed", "all singular", "on limits", "almost singular"])
def test_steps_go_on_where_what_is_left_of_an_error_is_worth_far_more(judges, case):
    assert_is_no_farther(judges, case)


@pytest.mark.parametrize(
    "case",
    ELSEWHERE,
    ids=["small curve", "another turn", "narrow interval", "one posture of its turns", "hardly moves", "three limits"],
)
def test_nearer_postures_that_few_steps_or_rounding_hide_are_found(judges, case):
    assert_is_no_farther(judges, case)


@pytest.mark.parametrize("name", RM75)
def test_an_elbow_turns_as_far_as_limits_let_it_but_for_rounding(name):
    arm, (q, seed) = arms.load(name), np.array(ON_TWO_LIMITS)
    solution = arm.solve(arm.forward_kinematics(q), seed=seed)
    assert np.linalg.norm(solution.q - seed) < np.linalg.norm(q - seed) + 1e-6


@pytest.mark.parametrize("branch", [None, 0, 4])
@pytest.mark.parametrize("name", RM75)
def test_a_straight_elbow_between_joints_on_limits_is_found_from_a_seed_beside_it(name, branch):
    arm, (q, seed) = arms.load(name), np.array(BETWEEN_LIMITS)
    solution = arm.solve(arm.forward_kinematics(q), seed=seed, branch=branch)
    assert solution.status == "OK"
    assert np.linalg.norm(solution.q - seed) < np.linalg.norm(q - seed) + 1e-6


def test_an_elbow_turns_until_a_joint_is_on_its_limit(judges):
    made = judges["subjects"]["random_arms"](np.random.default_rng([6840000, len("random_near")]), 2e-4, 0.0)
    arm, (q, seed) = next(islice(made, 19, None)), np.array(NEXT_TO_A_LIMIT)
    pose = arm.forward_kinematics(q)
    solution = arm.solve(pose, seed=seed)
    other, error = beside(arm, solution.q, pose, seed, 1e-5)
    assert error < AS_WELL
    assert not inside(other, arm.lower, arm.upper)


@pytest.mark.slow
def test_turns_that_joints_have_on_a_short_stretch_alone_are_found(judges):
    made = judges["subjects"]["random_arms"](np.random.default_rng([9110000, len("random_near")]), 2e-4, 0.0)
    arm, (q, seed) = next(islice(made, 43, None)), np.array(SHORT_STRETCH)
    assert inside(q, arm.lower, arm.upper)
    solution = arm.solve(arm.forward_kinematics(q), seed=seed)
    assert np.linalg.norm(solution.q - seed) < np.linalg.norm(q - seed) + 1e-9


ALMOST_STRAIGHT = (
    "4.509120889766975 -3.4831513861736836 0.03252620650451821 6.52498339803742e-08 "
    "-3.54004740046986 -4.815132484577628 0.03173064075058907",
    "4.509120889766975 -3.4801641179669938 0.041434205692878256 0.007672269497106484 "
    "-3.539482507699757 -4.809339566719876 0.02986790417690148",
)
"""A posture on a limit, and a seed beside it, of an arm whose figures are rounded."""


def test_a_posture_of_the_exact_limb_leads_to_one_that_curves_miss(judges):
    made = judges["subjects"]["random_arms"](np.random.default_rng([9700400, len("random_rounded")]), 1e-8, 0.0)
    arm, (q, seed) = next(islice(made, 8, None)), (np.array(text.split(), float) for text in ALMOST_STRAIGHT)
    solution = arm.solve(arm.forward_kinematics(q), seed=seed)
    assert np.linalg.norm(solution.q - seed) < np.linalg.norm(q - seed) + 1e-6


ROUND = [
    (0.3, 0.0, 0.4, 1.0, 0.0, 0.0, 0.2),
    (1.14, 0.0, -1.03, -1.38, 0.0, 0.0, 1.42),
    (-0.16, 0.0, 1.07, 0.44, 0.0, 0.0, -1.07),
    (0.66, 0.0, -1.1, -1.02, 0.0, 0.0, -1.75),
    (-1.52, 0.0, -1.17, -0.62, 0.0, 0.0, -0.21),
    (1.887, 0.0, 0.0, -0.016, 0.388, 0.0, 0.759),
    (1.454, 0.0, 0.0, 0.017, -0.907, 0.0, 1.974),
    (0.588, 0.0, 0.0, -0.081, 1.52, 0.0, -1.926),
]


@pytest.mark.parametrize("shift", [0.02, -0.02, 0.001])
@pytest.mark.parametrize("given", ROUND)
@pytest.mark.parametrize("along", [1.0, -1.0], ids=["alike", "to and fro"])
def test_a_posture_of_round_numbers_is_found_again_from_a_seed_beside_it(given, shift, along):
    """Shoulder and wrist are singular at once, and so is the true chain: plain steps end short of it, or far away."""
    arm, q = arms.load("gen3"), np.array(given)
    pose, seed = arm.forward_kinematics(q), q + shift * along ** np.arange(7)
    solution = arm.solve(pose, seed=seed)
    assert max(arm.verify(pose, solution.q)) < SOLVED
    assert np.linalg.norm(solution.q - seed) < abs(shift) * np.sqrt(7.0) + 1e-9


ALONE = [
    ((-0.406, 0.0, 0.0, 0.0026584, -0.127, 0.0, 0.452),
     (-0.32555465159163544, -0.008534020296394653, -0.09453130295624741, 0.05665930629738171,
      -0.1352924131019052, 0.057171848740261155, 0.5235347850059132)),
    ((-0.292, 0.0, 0.0, -0.066, 0.0, 0.0, 0.085),
     (-0.27315151674565336, 0.02752851503453984, -0.04843113438070477, -0.0003495911468678059,
      0.014975552464331824, -0.03425621694735881, 0.14675687719327313)),
    ((-1.872, 0.0, 0.0, 0.0030871, 0.0, 0.0, -1.347),
     (-1.8531138344380602, -0.01694942819954742, 0.011520409027079799, 0.011165312153405254,
      0.022482840406249045, -0.002751250962701657, -1.3461461955597254)),
    ((-1.889, 0.0, 0.0, 0.0042129, 0.0, 0.0, -1.069),
     (-1.8821425587444645, -0.005116797978428016, -0.007279060830457468, -0.0022312593540740906,
      -0.0062207551328326595, -0.004986079999769367, -1.076529313642849)),
]  # fmt: skip
"""Postures that are the only ones of their poses around, almost, and seeds."""


@pytest.mark.parametrize("case", ALONE)
def test_a_posture_of_round_numbers_that_is_alone_is_found_from_a_seed(case):
    arm, (q, seed) = arms.load("gen3"), map(np.array, case)
    pose = arm.forward_kinematics(q)
    solution = arm.solve(pose, seed=seed)
    assert max(arm.verify(pose, solution.q)) < SOLVED
    assert np.linalg.norm(solution.q - seed) < np.linalg.norm(q - seed) + 1e-6


IN_BLUR = [
    (-3.1, -1e-11, -0.2953852413418505, 2.355, 1.8054287173167824, 1e-11, -6.28),
    (-3.1, -1e-11, 0.4925909091867542, 2.355, 3.1, 1e-11, -3.0875698927019446),
]
"""Of an rm75: shoulder and wrist singular, alone for their poses but for rounding, which is 1e-4 rad wide there."""


@pytest.mark.parametrize("q", IN_BLUR if RM75 else [])
def test_a_posture_on_limits_that_is_alone_but_for_rounding_is_in_an_interval(judges, q):
    arm, q, known = arms.load("rm75"), np.array(q), judges["known"]
    case = known["Case"](q, arm.forward_kinematics(q).homogeneous, q, (), 0.0)
    intervals = arm.intervals(case.pose)
    assert known["beside"](arm, case, intervals) < known["BESIDE"]
    assert not list(known["missed"](arm, [case], [intervals]))


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_known_postures_lie_in_an_interval(judges, name):
    arm, known = load(judges, name), judges["known"]
    lost = 0
    for case in judges["singular"]["cases"](arm, 30, np.random.default_rng(74), TOGETHER):
        away = known["beside"](arm, case, arm.intervals(case.pose))
        bend = max(abs(np.sin(case.q[3] - judges["singular"]["singular_angles"](arm.limb)[3])), 1e-300)
        lost += away > known["BESIDE"] + known["ROUNDING"] / bend
    assert lost <= LOST


WHOLE = [*arms.here("j2s7s300"), "random_0", "random_1"]
"""Arms of which every arm angle of an interval is met, next to its ends too; of others, `known.py` counts the rest."""

ASKED = (0.0, 1e-3, 0.5, 1.0 - 1e-3, 1.0)
"""Where in an interval its postures are asked for, as a part of its width."""


def test_an_elbow_almost_on_its_limit_leaves_intervals(judges):
    """What the axes miss decides on which side of the limit the elbow of the nearest exact limb is."""
    arm, rng = load(judges, "random_5"), np.random.default_rng(74)
    for q in rng.uniform(arm.lower, arm.upper, (20, 7)):
        q[3] = rng.choice([arm.lower[3] + 1e-9, arm.upper[3] - 1e-9])
        case = judges["singular"]["Case"](q, arm.forward_kinematics(q).homogeneous, q, (), 0.0)
        assert judges["known"]["beside"](arm, case, arm.intervals(case.pose)) < 1e-6


@pytest.mark.parametrize("name", RM75)
def test_an_interval_that_is_one_arm_angle_next_to_a_singular_wrist_is_met(judges, name):
    """Where two branches meet at a wrist on its limit: 1e-9 rad of arm angle are 0.02 rad of joint 5 there."""
    arm, q = arms.load(name), np.array(WRIST_ON_LIMIT)
    case = judges["singular"]["Case"](q, arm.forward_kinematics(q).homogeneous, q, (5,), 0.0)
    assert not list(judges["known"]["missed"](arm, [case], [arm.intervals(case.pose)]))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["gen3", *WHOLE, *RM75])
def test_all_arm_angles_of_intervals_are_met_in_both_kinds_of_call(judges, name):
    """A branch by itself, and all of them at once: the same postures exist, on the borders between branches too."""
    arm = load(judges, name)
    for case in judges["singular"]["cases"](arm, 4, np.random.default_rng(75), TOGETHER):
        intervals = arm.intervals(case.pose)
        asked = [(i.branch, i.lower + share * i.width) for i in intervals for share in ASKED]
        angles = np.array([psi for _, psi in asked])
        poses = np.broadcast_to(case.pose, (len(asked), 4, 4))
        of_all = arm.solve_batch(poses, arm_angle=angles, all_branches=True)
        for k, (branch, psi) in enumerate(asked):
            alone = arm.solve(case.pose, arm_angle=psi, branch=branch)
            for q in (alone.q, of_all.q[k, branch]):
                assert max(arm.verify(case.pose, q)) < LEFT
                assert inside(q, arm.lower, arm.upper)
            assert alone.branch == branch
        assert (of_all.branch == np.arange(8)).all()


@pytest.mark.parametrize("name", WHOLE)
def test_self_motions_of_singular_poses_are_met(judges, name):
    """Every posture, and in the time of few: the curves of a pose are followed once."""
    arm = load(judges, name)
    longest = 0.0
    for case in judges["singular"]["cases"](arm, 6, np.random.default_rng(76), TOGETHER):
        start = time.process_time()
        motions = arm.self_motion(case.pose, count=31)
        longest = max(longest, time.process_time() - start)
        assert [m.interval for m in motions] == arm.intervals(case.pose)
        for motion in motions:
            assert motion.ok.all()
            for q in motion.q[::6]:
                assert max(arm.verify(case.pose, q)) < LEFT
                assert inside(q, arm.lower, arm.upper)
    assert longest < LONGEST


@pytest.mark.parametrize("tilt", [0.0, 1e-9, 1e-5])
def test_self_motions_of_gen3_upright_are_met(tilt):
    """Shoulder, elbow and wrist are singular at once; some intervals are 1e-8 rad wide."""
    arm = arms.load("gen3")
    pose = arm.forward_kinematics(np.array([0.0, tilt, 0.0, 0.0, 0.0, -tilt, 0.0]))
    start = time.process_time()
    motions = arm.self_motion(pose)
    assert time.process_time() - start < LONGEST
    assert motions
    for motion in motions:
        assert motion.ok.all()
        for q in motion.q[::15]:
            assert max(arm.verify(pose, q)) < SOLVED


NEXT_TO_STRAIGHT = [
    -1.8750320754855423,
    1.7945477717571028,
    -0.528316598677927,
    1.566795905532185,
    -1.5157244395535339,
    -0.02170325411846874,
    0.06267383714759878,
]


def least_time(call):
    """Of seven calls, in this thread alone."""
    times = []
    for _ in range(7):
        start = time.thread_time()
        call()
        times.append(time.thread_time() - start)
    return min(times)


@pytest.mark.parametrize("name", arms.here("h1_2_left"))
def test_no_curves_are_looked_for_along_splits_of_elbows_that_stay_bent(name):
    """By the ratio to a pose with the same shoulder and wrist, and the elbow well bent: 7.6 with these starts."""
    arm = arms.load(name)
    bent = [*NEXT_TO_STRAIGHT[:3], 0.5, *NEXT_TO_STRAIGHT[4:]]
    pose, other = (arm.forward_kinematics(q) for q in (NEXT_TO_STRAIGHT, bent))
    assert least_time(lambda: arm.intervals(pose)) < 5.0 * least_time(lambda: arm.intervals(other))
