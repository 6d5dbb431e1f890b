"""Ellipsoids against motions of the tip by Pinocchio on the whole robot of the file, and plain linear algebra."""

import warnings

import arms
import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from oracles import random_limb, unit
from tip import FOLDED, ROWS, STRETCHED, held, moved

import srs_ik
from srs_ik.analysis import ellipsoids

ARMS = arms.here("iiwa14", "gen3", "human_arm", "sia5d", "openarm_left")
PARTS = ("linear", "angular", "full")
Q = [0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2]


def spheres(count: int, seed: int) -> np.ndarray:
    u = np.random.default_rng(seed).normal(size=(count, 7))
    return u / np.linalg.norm(u, axis=1, keepdims=True)


def level(ellipsoid: srs_ik.Ellipsoid, points: np.ndarray) -> np.ndarray:
    """Below 1 inside, 1 on the surface."""
    return np.linalg.norm(points @ ellipsoid.axes / ellipsoid.radii, axis=-1)


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize("limited", [False, True])
@pytest.mark.parametrize("name", ARMS)
def test_motions_of_the_tip_fill_the_velocity_ellipsoid(name, limited, part):
    arm, forward = arms.load(name), arms.forward(name)
    weight = np.linspace(0.5, 2.0, 7) if limited else np.ones(7)
    # All of them away from singular postures: differences have no digits to spare for an axis of 0.1 mm/s.
    for q in arms.configurations(name, 3, salt=6):
        e = srs_ik.velocity_ellipsoid(arm.jacobian(q), weight if limited else None, part)
        assert e.rank == len(e.radii)
        points = np.array([moved(forward, q, weight * u)[ROWS[part]] for u in spheres(60, 1)])
        assert level(e, points).max() < 1.0 + 1e-6
        # The joint velocities that matter most for an axis, from differences alone, end on the tip of that axis.
        columns = np.array([moved(forward, q, w * row) for w, row in zip(weight, np.eye(7), strict=True)])[
            :, ROWS[part]
        ]
        for axis, radius in zip(e.axes.T, e.radii, strict=True):
            best = columns @ axis
            reached = moved(forward, q, weight * best / np.linalg.norm(best))[ROWS[part]]
            assert np.allclose(reached, radius * axis, rtol=0.0, atol=1e-7)


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize("name", ARMS)
def test_forces_of_the_force_ellipsoid_take_torques_of_norm_1(name, part):
    arm = arms.load(name)
    model, data = arm.model, arm.model.createData()
    for q in arms.configurations(name, 5, salt=2):
        limit = np.linspace(3.0, 40.0, 7)
        plain, weighted = (srs_ik.force_ellipsoid(arm.jacobian(q), w, part) for w in (None, limit))
        for ellipsoid, scale in ((plain, np.ones(7)), (weighted, limit)):
            for axis, radius in zip(ellipsoid.axes.T, ellipsoid.radii, strict=True):
                wrench = np.zeros(6)
                wrench[ROWS[part]] = radius * axis
                torque = held(arm, model, data, q, wrench)
                assert np.linalg.norm(torque / scale) == pytest.approx(1.0, rel=1e-10)


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize("name", ARMS)
def test_force_is_the_reciprocal_of_velocity(name, part):
    for q in arms.configurations(name, 50, salt=3):
        J = arms.load(name).jacobian(q)
        velocity, force = srs_ik.velocity_ellipsoid(J, part=part), srs_ik.force_ellipsoid(J, part=part)
        assert np.array_equal(velocity.axes, force.axes)
        assert np.allclose(force.radii * velocity.radii, 1.0, rtol=0.0, atol=1e-12)
        # The same from the quadratic form itself, as far as its condition goes.
        rows = J[ROWS[part]]
        axes = force.axes * force.radii
        assert np.allclose(axes.T @ rows @ rows.T @ axes, np.eye(len(rows)), rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("seed", range(10))
def test_another_base_frame_turns_the_axes_and_keeps_the_radii(seed):
    limb = random_limb(seed, limits="usual")
    turn = pin.SE3.Random()
    limb.model.addFrame(pin.Frame("elsewhere", 0, 0, turn, pin.OP_FRAME))
    one, other = (srs_ik.load(limb.model, base=base, tip="tool") for base in ("base", "elsewhere"))
    q = limb.configuration()
    T_base_elsewhere = one.forward_kinematics(q) * other.forward_kinematics(q).inverse()
    for part in PARTS:
        for build in (srs_ik.velocity_ellipsoid, srs_ik.force_ellipsoid):
            a = build(one.jacobian(q), part=part).in_axes(T_base_elsewhere.rotation)
            b = build(other.jacobian(q), part=part)
            assert np.allclose(a.radii, b.radii, rtol=1e-9, atol=0.0)
            shape_a, shape_b = (e.axes @ np.diag(e.radii**-2.0) @ e.axes.T for e in (a, b))
            assert np.allclose(shape_a, shape_b, rtol=0.0, atol=1e-9 * np.abs(shape_a).max())


def test_tip_axes_are_those_of_the_tip_frame():
    arm, forward = arms.load("iiwa14"), arms.forward("iiwa14")
    q = np.array(Q)
    R_base_tip = forward(q).rotation
    e = srs_ik.velocity_ellipsoid(arm.jacobian(q)).in_axes(R_base_tip)
    points = np.array([R_base_tip.T @ moved(forward, q, u)[:3] for u in spheres(60, 4)])
    assert 0.9 < level(e, points).max() < 1.0 + 1e-6


@pytest.mark.parametrize("q", [STRETCHED, FOLDED], ids=["stretched", "folded"])
def test_the_stretched_and_the_folded_iiwa_cannot_move_along_their_own_line(q):
    arm, forward = arms.load("iiwa14"), arms.forward("iiwa14")
    line = forward(np.array(q)).translation - arm.limb.shoulder
    line /= np.linalg.norm(line)
    assert np.abs([moved(forward, np.array(q), u)[:3] @ line for u in spheres(30, 5)]).max() < 1e-9
    J = arm.jacobian(q)
    velocity, force = srs_ik.velocity_ellipsoid(J), srs_ik.force_ellipsoid(J)
    assert velocity.rank == force.rank == 2
    assert velocity.flat is True
    assert velocity.unbounded is False
    assert force.unbounded is True
    assert force.flat is False
    assert velocity.radii[2] == 0.0
    assert force.radii[2] == np.inf
    assert velocity.singular.tolist() == force.singular.tolist() == [False, False, True]
    assert abs(velocity.axes[:, 2] @ line) == pytest.approx(1.0, abs=1e-12)
    assert velocity.radius_along(line) == 0.0
    assert force.radius_along(line) == np.inf
    assert srs_ik.analysis.isotropy(J) == 0.0
    assert srs_ik.manipulability(J, "linear") < 1e-12
    across = velocity.axes[:, 0] + 0.5 * velocity.axes[:, 1]
    assert 0.0 < velocity.radius_along(across) < np.inf
    assert 0.0 < force.radius_along(across + line) < np.inf
    assert "flat" in repr(velocity)
    assert "unbounded" in repr(force)


def test_at_zero_the_tip_of_the_iiwa_moves_along_one_line():
    J = arms.load("iiwa14").jacobian(np.zeros(7))
    ranks = [srs_ik.velocity_ellipsoid(J, part=part).rank for part in PARTS]
    assert ranks == [np.linalg.matrix_rank(J[ROWS[part]], tol=1e-9) for part in PARTS] == [1, 2, 3]
    e = srs_ik.velocity_ellipsoid(J)
    assert np.allclose(np.abs(e.axes[:, 0]), [1.0, 0.0, 0.0])
    assert e.radii.tolist()[1:] == [0.0, 0.0]


def test_a_tip_that_nothing_moves_has_no_extent():
    velocity, force = srs_ik.velocity_ellipsoid(np.zeros((6, 7))), srs_ik.force_ellipsoid(np.zeros((6, 7)))
    assert (velocity.rank, velocity.radii.tolist(), force.radii.tolist()) == (0, [0.0] * 3, [np.inf] * 3)
    assert velocity.radius_along([1, 0, 0]) == 0.0
    assert force.radius_along([1, 0, 0]) == np.inf
    assert srs_ik.analysis.isotropy(np.zeros((6, 7))) == 0.0


@pytest.mark.parametrize("part", PARTS)
def test_transmission_ratios_are_those_of_least_joint_velocities_and_of_torques(part):
    arm = arms.load("gen3")
    rng = arms.generator("gen3", 6)
    for q in arms.configurations("gen3", 10, salt=6):
        J, u = arm.jacobian(q), rng.normal(size=6)[ROWS[part]]
        rows, u1 = J[ROWS[part]], u / np.linalg.norm(u)
        least = np.linalg.lstsq(rows, u1, rcond=None)[0]
        assert srs_ik.analysis.velocity_transmission(J, 7.0 * u, part=part) == pytest.approx(
            1 / np.linalg.norm(least), rel=1e-9
        )
        assert srs_ik.analysis.force_transmission(J, u, part=part) == pytest.approx(
            1 / np.linalg.norm(u1 @ rows), rel=1e-9
        )


def test_figures_of_merit_are_their_formulas():
    arm = arms.load("iiwa14")
    for q in arms.configurations("iiwa14", 20, salt=7):
        J = arm.jacobian(q)
        for part in PARTS:
            square = J[ROWS[part]] @ J[ROWS[part]].T
            assert srs_ik.manipulability(J, part) == pytest.approx(np.sqrt(np.linalg.det(square)), rel=1e-8)
            eigenvalues = np.linalg.eigvalsh(square)
            assert srs_ik.analysis.isotropy(J, part) == pytest.approx(
                np.sqrt(eigenvalues[0] / eigenvalues[-1]), rel=1e-8
            )


@pytest.mark.parametrize("scale", [1e-200, 1e-3, 1e160, 1e300])
def test_the_ratio_is_that_of_any_multiple_of_the_jacobian(scale):
    J = np.random.default_rng(5).normal(size=(6, 7))
    f, v = np.array([1.0, 2.0, 3.0]), np.array([-1.0, 0.5, 0.0])
    expected = (f @ J[:3] @ J[:3].T @ f) / (v @ J[:3] @ J[:3].T @ v) * (v @ v) / (f @ f)
    with warnings.catch_warnings(action="error"):
        assert srs_ik.force_velocity_ratio(scale * J, f, v) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("q", "line"), [(np.zeros(7), [1.0, 0.0, 0.0]), (STRETCHED, None)], ids=["one direction left", "two left"]
)
def test_the_ratio_of_directions_that_are_singular_is_no_rounding(q, line):
    """At zero angles the tip of iiwa14 moves along x alone, and stretched across the arm alone: by SVD."""
    J = arms.load("iiwa14").jacobian(q)
    U, values, _ = np.linalg.svd(J[:3])
    rank = np.count_nonzero(values > 1e-9)
    assert rank == (2 if line is None else 1)
    assert line is None or abs(U[0, 0]) == pytest.approx(1.0)
    moved, stuck = U[:, :rank].T, U[:, rank:].T
    for v in stuck:
        for f in stuck:
            assert srs_ik.force_velocity_ratio(J, f, v) == np.inf
            assert srs_ik.force_velocity_ratio(1e-3 * J, -f, 5.0 * v) == np.inf
        assert all(srs_ik.force_velocity_ratio(J, f, v) > 1e15 for f in moved)
    for v in moved:
        assert all(srs_ik.force_velocity_ratio(J, f, v) < 1e-15 for f in stuck)
        expected = np.sum((J[:3].T @ moved[0]) ** 2) / np.sum((J[:3].T @ v) ** 2)
        assert srs_ik.force_velocity_ratio(J, moved[0], v) == pytest.approx(expected, rel=1e-9)


def test_the_ratio_is_the_one_that_optimise_minimises():
    arm = arms.load("iiwa14")
    force, velocity = [1.0, 2.0, -3.0], [0.2, 0.0, 5.0]
    best = arm.optimise(arm.forward_kinematics(Q), "force_velocity_ratio", force=force, velocity=velocity)
    assert srs_ik.force_velocity_ratio(arm.jacobian(best.q), force, velocity) == pytest.approx(best.value, rel=1e-12)
    objective = srs_ik.Objective("force_velocity_ratio", force=force, velocity=velocity)
    for q in arms.configurations("iiwa14", 20, salt=8):
        ratio = srs_ik.force_velocity_ratio(arm.jacobian(q), force, velocity)
        assert ratio == pytest.approx(objective.value(arm, q), rel=1e-12)


def test_a_batch_is_the_single_answers():
    arm = arms.load("iiwa14")
    qs = np.vstack([arms.configurations("iiwa14", 6, salt=9), [STRETCHED, FOLDED, np.zeros(7)]])
    J = np.array([arm.jacobian(q) for q in qs])
    R = np.array([arm.forward_kinematics(q).rotation for q in qs])
    f, v = (
        np.array([unit(arm_rng) for _ in qs]) for arm_rng in (arms.generator("iiwa14", 1), arms.generator("gen3", 1))
    )
    for part in PARTS:
        for build, limit in (
            (srs_ik.velocity_ellipsoid, arm.velocity_limit),
            (srs_ik.force_ellipsoid, arm.effort_limit),
        ):
            many = build(J, limit, part).in_axes(R)
            assert len(many) == len(list(many)) == len(qs)
            assert many
            assert many[0]
            assert not build(J[:0], limit, part)
            assert f"{len(qs)} Ellipsoids" in repr(many)
            for i, one in enumerate(many):
                alone = build(J[i], limit, part).in_axes(R[i])
                assert (one.kind, one.part, one.unit, one.rank) == (alone.kind, alone.part, alone.unit, alone.rank)
                assert np.allclose(one.radii, alone.radii, rtol=1e-12)
                assert np.allclose(one.axes, alone.axes, atol=1e-12)
            assert many.flat.tolist() == [one.flat for one in many]
            assert many.unbounded.tolist() == [one.unbounded for one in many]
    for many, one in (
        (srs_ik.manipulability(J), srs_ik.manipulability),
        (srs_ik.analysis.isotropy(J), srs_ik.analysis.isotropy),
    ):
        assert np.allclose(many, [one(j) for j in J], rtol=1e-9, atol=1e-18)
    for ratio in (
        (
            srs_ik.analysis.velocity_transmission(J, v),
            [srs_ik.analysis.velocity_transmission(*pair) for pair in zip(J, v, strict=True)],
        ),
        (srs_ik.analysis.force_transmission(J, v[0]), [srs_ik.analysis.force_transmission(j, v[0]) for j in J]),
        (srs_ik.force_velocity_ratio(J, f, v), [srs_ik.force_velocity_ratio(*x) for x in zip(J, f, v, strict=True)]),
    ):
        assert np.allclose(*ratio, rtol=1e-9)
    with pytest.raises(TypeError):
        len(srs_ik.velocity_ellipsoid(J[0]))
    with pytest.raises(TypeError):
        srs_ik.velocity_ellipsoid(J[0])[0]


@given(arrays(np.float64, (6, 7), elements=st.floats(-1e6, 1e6, width=32)), st.sampled_from(PARTS))
def test_whatever_the_jacobian_the_axes_are_a_frame_and_no_figure_is_nan(J, part):
    for e in (srs_ik.velocity_ellipsoid(J, part=part), srs_ik.force_ellipsoid(J, part=part)):
        assert np.allclose(e.axes.T @ e.axes, np.eye(len(e.radii)), rtol=0.0, atol=1e-12)
        if part != "full":
            assert np.linalg.det(e.axes) == pytest.approx(1.0)
        order = e.radii if e.kind == "force" else e.radii[::-1]
        assert (order[1:] >= order[:-1]).all()
        assert not np.isnan(e.radii).any()
        assert np.isfinite(e.radii).sum() == (e.rank if e.kind == "force" else len(e.radii))
        for direction in (*e.axes.T, np.ones(len(e.radii))):
            assert e.radius_along(direction) >= 0.0
    assert np.isfinite([srs_ik.manipulability(J, part), srs_ik.analysis.isotropy(J, part)]).all()
    assert srs_ik.force_velocity_ratio(J, [1, 0, 0], [0, 1, 0]) >= 0.0


def test_a_limit_that_is_not_given_is_named():
    arm = arms.load("human_arm")
    J = arm.jacobian(np.full(7, 0.1))
    assert not np.isfinite(arm.velocity_limit).any()
    with pytest.raises(srs_ik.MissingLimits, match="velocity limit for joint 1, joint 2"):
        srs_ik.velocity_ellipsoid(J, arm.velocity_limit)
    limit = np.array([60.0, 70.0, np.inf, 50.0, np.inf, 7.0, 9.0])
    with pytest.raises(srs_ik.MissingLimits, match="effort limit for joint 3, joint 5; one for every joint") as caught:
        srs_ik.force_ellipsoid(J, limit)
    assert (caught.value.kind, caught.value.joints) == ("effort", ("joint 3", "joint 5"))


GOOD = np.eye(6, 7)


@pytest.mark.parametrize(
    ("call", "named"),
    [
        (lambda: srs_ik.velocity_ellipsoid(np.eye(7, 6)), "shape (7, 6)"),
        (lambda: srs_ik.velocity_ellipsoid("J"), "J must be a Jacobian"),
        (lambda: srs_ik.velocity_ellipsoid(srs_ik.load("iiwa14"), np.zeros(7)), "not Arm; arm.jacobian(q) gives it"),
        (lambda: srs_ik.force_ellipsoid(np.zeros(7), [0.1] * 6), "J must be a Jacobian"),
        (lambda: srs_ik.velocity_ellipsoid(GOOD * np.nan), "not finite"),
        (lambda: srs_ik.force_ellipsoid(GOOD, part="lin"), "'lin'"),
        (lambda: srs_ik.force_ellipsoid(GOOD, np.ones(6)), "limit must be 7 positive"),
        (lambda: srs_ik.force_ellipsoid(GOOD, -np.ones(7)), "limit must be 7 positive"),
        (lambda: srs_ik.force_ellipsoid(GOOD, np.full(7, np.nan)), "limit must be 7 positive"),
        (lambda: srs_ik.force_ellipsoid(GOOD, "limit"), "limit must be 7 positive"),
        (lambda: srs_ik.manipulability(np.ones(7)), "shape (7,)"),
        (lambda: srs_ik.analysis.isotropy(GOOD, "all"), "'all'"),
        (lambda: srs_ik.force_velocity_ratio(GOOD, [0, 0, 0], [1, 0, 0]), "force must not be zero"),
        (lambda: srs_ik.force_velocity_ratio(GOOD, [1, 0, 0], [1, 0]), "velocity must be 3 numbers"),
        (lambda: srs_ik.force_velocity_ratio(GOOD[None], [1, 0, 0], np.ones((4, 3))), "1 times 3"),
        (lambda: srs_ik.analysis.velocity_transmission(GOOD, [1, 0, np.inf]), "direction must be 3 numbers"),
        (lambda: srs_ik.velocity_ellipsoid(GOOD).in_axes(np.eye(4)), "shape (4, 4)"),
        (lambda: srs_ik.velocity_ellipsoid(GOOD).in_axes(2.0 * np.eye(3)), "must be a rotation"),
        (lambda: srs_ik.velocity_ellipsoid(GOOD).in_axes(np.diag([1, 1, -1])), "must be a rotation"),
        (lambda: srs_ik.velocity_ellipsoid(GOOD).in_axes(np.stack([np.eye(3)] * 2)), "shape (2, 3, 3)"),
    ],
)
def test_malformed_input_is_named(call, named):
    with pytest.raises(srs_ik.InvalidTask) as caught:
        call()
    assert named in str(caught.value)
    assert "\n" not in str(caught.value)


def test_units_are_said():
    units = {
        (build.__name__, part): build(GOOD, part=part).unit
        for part in PARTS
        for build in (srs_ik.velocity_ellipsoid, srs_ik.force_ellipsoid)
    }
    assert units["velocity_ellipsoid", "linear"] == "m/s"
    assert units["force_ellipsoid", "angular"] == "N m"
    assert len(set(units.values())) == 6
    assert ellipsoids.UNITS["velocity"]["angular"] == units["velocity_ellipsoid", "angular"]
