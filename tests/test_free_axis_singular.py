"""A pose with shoulder and wrist singular at once: all splits of both sums meet it, and the answer is none farther."""

import math

import arms
import numpy as np
import pytest

from srs_ik import FreeAxis

STEP = 2e-3
"""Splits are swept so finely, rad."""

AXES = ([0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.6, -0.3, 0.8], [-0.5, -0.9, -0.4])


def opposite(name, q, first):
    """Which way joint `first + 2` has to turn as joint `first` does, for the tip to stay: by the robot's file."""
    for way in (-1.0, 1.0):
        other = q.copy()
        other[[first, first + 2]] += 0.1, 0.1 * way
        if np.abs(arms.forward(name)(other).homogeneous - arms.forward(name)(q).homogeneous).max() < 1e-9:
            return way
    raise AssertionError("the joint is not singular")


def least_split(name, q, seed, first):
    """The least squared distance of two joints from a seed over a fine sweep of their splits, inside the limits."""
    arm, way = arms.load(name), opposite(name, q, first)
    t = np.arange(-7.0, 7.0, STEP)
    best = math.inf
    for turn in 2.0 * np.pi * np.arange(-2, 3):
        both = np.stack([q[first] + t, q[first + 2] + way * t + turn], axis=1)
        joints = [first, first + 2]
        inside = ((both >= arm.lower[joints]) & (both <= arm.upper[joints])).all(axis=1)
        away = ((both - seed[joints]) ** 2).sum(axis=1)
        best = min(best, away[inside].min(initial=math.inf))
    return best


@pytest.mark.parametrize("cone", [0.0, 1e-5, 0.1])
@pytest.mark.parametrize(
    ("name", "singular"),
    [(name, joints) for name in arms.here("iiwa14", "sia10f") for joints in ([5], [1], [1, 5])]
    + [("gen3", [5]), ("gen3", [1])],
)
def test_a_posture_next_to_the_seed_is_not_passed_over(name, singular, cone):
    arm, rng = arms.load(name), arms.generator(name, 171)
    q0 = np.full(7, 0.3)
    own = arms.forward(name)(q0).rotation.T @ arm.jacobian(q0)[3:, 6]
    for _ in range(30):
        q = rng.uniform(np.maximum(arm.lower, -3.0), np.minimum(arm.upper, 3.0))
        q[singular] = 0.0
        seed = np.clip(q + 1e-4 * rng.normal(size=7), arm.lower, arm.upper)
        found = arm.solve(arms.forward(name)(q).homogeneous, seed=seed, free_axis=FreeAxis(own, cone=cone))
        assert found, found.message
        assert np.linalg.norm(found.q - seed) <= np.linalg.norm(q - seed) + 1e-6


@pytest.mark.parametrize("cone", [0.0, 1e-6])
@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("name", arms.here("iiwa14", "med7", "sia10f"))
def test_no_split_is_nearer_to_the_seed(name, axis, cone):
    arm, rng = arms.load(name), arms.generator(name, 170)
    lower, upper = np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi)
    for _ in range(60):
        q, seed = rng.uniform(lower, upper, (2, 7))
        q[[1, 5]] = 0.0
        rest = ((q - seed)[[1, 3, 5]] ** 2).sum()
        known = rest + least_split(name, q, seed, 0) + least_split(name, q, seed, 4)
        pose = arms.forward(name)(q).homogeneous
        found = arm.solve(pose, seed=seed, free_axis=FreeAxis(axis, cone=cone))
        assert found, found.message
        assert np.linalg.norm(found.q - seed) <= math.sqrt(known) + 1e-6


@pytest.mark.skipif("human_arm" not in arms.here("human_arm"), reason="no human_arm here")
def test_a_sum_of_three_joints_is_shared_evenly_though_a_search_begins_with_one_on_its_limit():
    # Axes 1, 3 and 5 are one line, and joints 2, 4 and 7 stay on their limits: only the sum of 1, 3 and 5 is fixed.
    T = np.array(
        [
            [0.3119195339079067, -0.2686459307124264, -0.9113372417927013, -0.0665369086090305],
            [-0.7113483120085297, 0.5698225090956629, -0.411443662158671, -0.029053321673804665],
            [0.6298331393069831, 0.7766155239496424, -0.0133620578928917, 0.7587658657509084],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )
    seed = np.array(
        [
            -0.634509628192854,
            0.7730596292050476,
            -1.0667675122861149,
            -1.631301212358049,
            0.22082423939205165,
            0.2838724425873138,
            0.36041093018112663,
        ]
    )
    free, arm = FreeAxis([-0.026878954658698904, 0.7841365633209078, -0.6200059450196679]), arms.load("human_arm")
    sixth = 0.7498500705533365
    known = np.array([0.0, arm.lower[1], 0.0, arm.upper[3], 0.0, sixth, arm.lower[6]])
    known[[0, 2, 4]] = seed[[0, 2, 4]] + 0.4672115728454571
    tip = arms.forward("human_arm")(known)
    assert np.linalg.norm(tip.translation - T[:3, 3]) < 1e-9
    assert free.lean(tip.rotation, T[:3, :3]) < 1e-9
    found = arm.solve(T, seed=seed, free_axis=free)
    assert found, found.message
    assert np.linalg.norm(found.q - seed) <= np.linalg.norm(known - seed) + 1e-6


@pytest.mark.parametrize(
    ("name", "q", "seed"),
    [
        (
            "iiwa14",
            [-1.460572632525775, 0.0, -0.21300587387669667, 1e-05, -0.06073508203727318, -0.7321716936727332, 0.0],
            [-1.46041252, -9.849e-05, -0.21286029, -0.00112463, -0.06062089, -0.73028171, -0.97501762],
        ),
        (
            "iiwa14",
            [2.8036265361471697, 0.0, -2.2688078958650606, 1e-05, 0.8984425425656566, 0.3959265137853927, 0.0],
            [2.75568821, 0.00055839, -2.27826437, -0.02374161, 0.91068241, 0.29958358, 0.73832877],
        ),
        (
            "gen3",
            [2.3209112261846645, -1.3423398582778736, 1.622827117509889, 0.0, 2.535283880475318, 1e-05, 0.0],
            [2.30031077, -1.34625873, 1.60727021, 0.0789377, 2.57359073, 0.00285689, -2.46859113],
        ),
        (
            "rm75",
            [0.14242145537293327, 0.0, 2.754908378838756, 0.3109440507658534, -0.7916024269088577, 0.0, 0.0],
            [0.08288795, -0.08710005, 2.88737439, 0.33260867, -0.85204136, 0.02570727, 2.96569805],
        ),
        (
            "rm75",
            [
                -0.2559748505932027,
                -1.480494967032308,
                2.2012331928482713,
                2.355,
                0.7132407396810851,
                0.4700086989979,
                0.0,
            ],
            [-0.26978357, -1.49161604, 2.17091124, 2.32674081, 0.73339591, 0.45522723, 0.20341948],
        ),
        (
            "rm75",
            [
                -2.5233263349482753,
                2.1258930040480717,
                2.5848136952997023,
                -2.355,
                -0.599709543381486,
                -0.505660128137,
                0.0,
            ],
            [-2.51579188, 2.18832845, 2.53781107, -2.355, -0.56431947, -0.49704161, 1.50035527],
        ),
        (
            "iiwa14",
            [1.73055981, 0.0, -0.51975438, -0.9080265, 0.6645867, -1.85309635, 0.0],
            [0.28354163, -1.40881766, -1.96677256, -1.98129389, -0.95638547, -1.8879408, 2.8289948],
        ),
        (
            "gen3",
            [3.02753938, -1.15436472, 2.79473513, -1.49456975, 3.14118352, 0.00138983, 0.0],
            [2.78837237, -0.97323513, 0.61179151, -1.75952426, 3.13942155, 1.01131757, 3.13631162],
        ),
    ],
)
def test_with_the_roll_of_joint_7_free_the_answer_is_no_farther_than_a_posture_whose_joint_7_is_the_seeds(
    name, q, seed
):
    """Next to singular joints, with seeds far away, too, and with the elbow of rounded figures on its limit."""
    arm = arms.load(name)
    own = arms.forward(name)(np.zeros(7)).rotation.T @ arm.jacobian(np.zeros(7))[3:, 6]
    pose = arms.forward(name)(np.array(q)).homogeneous
    known = np.array([*q[:6], seed[6]])
    for cone in (0.0, 1e-6):
        found = arm.solve(pose, seed=seed, free_axis=FreeAxis(own, cone=cone))
        assert found, found.message
        assert np.linalg.norm(found.q - seed) <= np.linalg.norm(known - seed) + 1e-6


@pytest.mark.parametrize(
    ("name", "axis", "q", "seed"),
    [
        (
            "iiwa14",
            [0.0, 1.0, 0.0],
            [
                2.4147318710221555,
                -0.001,
                -0.4090821837018592,
                0.001,
                -1.4402403577085092,
                0.001,
                -2.424893487633938,
            ],
            [
                2.4166709433182323,
                -0.0014775042314932585,
                -0.409168594789464,
                -0.0006896610566266555,
                -1.4383298868726901,
                0.0003769981609127457,
                -2.4256254552603904,
            ],
        ),
        (
            "gen3",
            [0.9068274085243457, 0.35835655299926095, 0.2219113157806676],
            [
                1.165780775964122,
                -1e-08,
                0.03808811718799232,
                -1e-08,
                -1.998924926629761,
                -1e-08,
                0.8636652123286526,
            ],
            [
                1.169399997781768,
                -0.011831044344129144,
                0.0443098762849657,
                0.0038772135173057195,
                -1.9968013128423718,
                -0.01961664238659986,
                0.8568020641043749,
            ],
        ),
        (
            "human_arm",
            [1.0, 0.0, 0.0],
            [
                0.756190686645614,
                -1.5707963267948966,
                -1.0275223785918666,
                -1e-05,
                0.354747531099441,
                -0.8371767512818459,
                0.5235887755982989,
            ],
            [
                1.2524237812501384,
                -0.7145376088571456,
                -1.5980006902860018,
                -0.42153763296572455,
                0.329993590587771,
                -0.4955844494373186,
                0.22167970943195087,
            ],
        ),
        (
            "rm75",
            [-0.8343459816149271, -0.5447512203021913, 0.08433795671165653],
            [1.5664064606486394, 0.0, -3.1, 0.0, -1.8797021488654093, -2.233, -2.3525265193614064],
            [
                1.5928972370760675,
                -0.03853968739834041,
                -3.029068577385178,
                0.007225942020624003,
                -1.9372812136298863,
                -2.158882703347442,
                -2.3535989099807475,
            ],
        ),
    ],
)
def test_about_any_axis_no_singular_posture_beside_the_seed_is_passed_over(name, axis, q, seed):
    """Equations of singular poses almost depend on each other: a step that met them led far away from the seed."""
    arm = arms.load(name)
    pose = arms.forward(name)(np.array(q)).homogeneous
    for cone in (0.0, 1e-6):
        found = arm.solve(pose, seed=seed, free_axis=FreeAxis(axis, cone=cone))
        assert found, found.message
        assert np.linalg.norm(found.q - seed) <= np.linalg.norm(np.array(q) - seed) + 1e-6
