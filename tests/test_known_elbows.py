"""Straight, folded and flat elbows: known postures lie in an interval of their pose, and all of an interval is met."""

from itertools import islice, product

import arms
import numpy as np
import pinocchio as pin
import pytest
from known_postures import assert_intervals_are_met, assert_is_inside, assert_is_whole, postures, subjects
from oracles import distance, inside, phases, random_limb
from scipy.optimize import minimize

import srs_ik

TIGHT = {"xatol": 1e-12, "fatol": 1e-14, "maxiter": 600}


NEARLY_STRAIGHT = [
    [2.022509806951285, -1.6978942590630572, 1.0951563723747988, -0.03440066694748101, 1.9099775572521365],
    [0.8022066076768497, -1.4355679630019904, -0.6195359453834746, -0.008431414597084963, -0.016301992872528537],
    [-1.7629925920585412, -1.31943694094839, -0.08569091353850311, -0.06881983761089572, 0.6872961319085507],
    [1.2355251201268453, -0.9214670633663602, 2.6556836911895276, -0.04769062813452862, 1.2471541902707841],
]
"""Joints 1 to 5; the nearest exact arm has its elbow on the line from shoulder to wrist, or cannot reach."""


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


@pytest.mark.parametrize(("name", "joints"), [("human_arm", (1, 3)), ("human_left", (3, 5)), ("iiwa14", (1, 3, 5))])
def test_flat_elbows_next_to_singular_joints_lose_nothing(bench, name, joints):
    """The smaller the bend, the less a pose tells it; joints of a sum turn far with it."""
    arm, seen = arms.load(name), 0
    for q in postures(name, 60, 77, (joints,), (1e-10, 1e-9, 1e-8, 1e-7)):
        assert_is_whole(bench, arm, q)
        seen += 1
    assert seen > 15


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


BY_THE_LINE = (
    "1.05560754014479 0.8122907677080996 1.4280073527123909 1.5045997785507044 -0.6547039916547166 0.1930547181736849 "
    "-0.9453279473790397"
)


@pytest.mark.skipif("h1_2_left" not in arms.here("h1_2_left"), reason="its file is not here")
def test_arm_angles_next_to_where_the_elbow_passes_by_the_line_are_met(bench):
    """Between two samples the arm angle turns around, goes on by almost half a turn, and turns around again."""
    assert_intervals_are_met(bench, arms.load("h1_2_left"), np.array(BY_THE_LINE.split(), float))


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
