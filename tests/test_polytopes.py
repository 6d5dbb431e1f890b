"""Polytopes against linear programmes, sampled velocities and forces, and torques by Pinocchio's inverse dynamics."""

import re
import sys
from collections import Counter

import arms
import numpy as np
import pinocchio as pin
import pytest
from oracles import unit
from scipy.optimize import linprog
from tip import FOLDED, ROWS, STRETCHED, held, moved

import srs_ik
from srs_ik.errors import install_command

pytest.importorskip("pycapacity")

Q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
PARTS = ("linear", "angular")
ARMS = arms.here("iiwa14", "gen3", "human_arm", "openarm_left")
LEAST, MOST = -np.linspace(1.0, 2.0, 7), np.linspace(2.5, 0.5, 7)


def half_spaces(polytope: srs_ik.Polytope) -> tuple[np.ndarray, np.ndarray]:
    """Outward normals and offsets of the faces as they are listed, slivers left out."""
    a, b, c = (polytope.vertices[polytope.faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    size = np.linalg.norm(normals, axis=1)
    broad = size > 1e-7 * size.max()
    normals = normals[broad] / size[broad, None]
    return normals, np.einsum("ij,ij->i", normals, a[broad])


def directions(name: str, count: int = 40) -> np.ndarray:
    rng = arms.generator(name, 11)
    return np.vstack([[unit(rng) for _ in range(count)], np.eye(3), -np.eye(3)])


def gravity(arm, q: np.ndarray) -> np.ndarray:
    still = np.zeros(7)
    return pin.rnea(arm.model, arm.model.createData(), arm.configuration(q), still, still)


def own_limits(arm, kind: str) -> dict:
    """None where the description gives them."""
    given = arm.velocity_limit if kind == "velocity" else arm.effort_limit
    return {} if np.isfinite(given).all() else {"upper": np.where(np.isfinite(given), given, 30.0)}


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize("name", ARMS)
def test_velocities_reach_as_far_as_a_linear_programme_says(name, part):
    arm = arms.load(name)
    for q in arms.configurations(name, 4, salt=11):
        P = srs_ik.velocity_polytope(arm, q, part, LEAST, MOST)
        J = arm.jacobian(q)[ROWS[part]]
        for u in directions(name):
            best = linprog(-u @ J, bounds=list(zip(LEAST, MOST, strict=True)))
            assert P.extent_along(u) == pytest.approx(-best.fun, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize("name", ARMS)
def test_forces_reach_as_far_as_a_linear_programme_says(name, part):
    arm = arms.load(name)
    limits = own_limits(arm, "effort")
    bound = limits.get("upper", arm.effort_limit)
    for q in arms.configurations(name, 4, salt=12):
        P = srs_ik.force_polytope(arm, q, part, **limits)
        J, load = arm.jacobian(q)[ROWS[part]], gravity(arm, q)
        for u in directions(name):
            best = linprog(
                -u, np.vstack([J.T, -J.T]), np.concatenate([bound - load, bound + load]), bounds=(None, None)
            )
            assert P.extent_along(u) == pytest.approx(-best.fun, rel=1e-8)


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize("name", ARMS)
def test_sampled_motions_are_inside_and_the_extreme_ones_touch(name, part):
    arm, forward = arms.load(name), arms.forward(name)
    rng = arms.generator(name, 13)
    for q in arms.configurations(name, 2, salt=13):
        P = srs_ik.velocity_polytope(arm, q, part, LEAST, MOST)
        normals, offsets = half_spaces(P)
        rates = [rng.uniform(LEAST, MOST) for _ in range(60)]
        rates += [np.where(rng.random(7) < 0.5, LEAST, MOST) for _ in range(60)]
        # For every face, the joint velocities that go farthest across it, by differences of the tip's pose.
        columns = np.array([moved(forward, q, row)[ROWS[part]] for row in np.eye(7)])
        extreme = [np.where(columns @ n > 0.0, MOST, LEAST) for n in normals]
        points = np.array([moved(forward, q, rate)[ROWS[part]] for rate in rates])
        assert (points @ normals.T - offsets).max() < 1e-7
        touching = np.array([moved(forward, q, rate)[ROWS[part]] for rate in extreme])
        assert np.abs(np.einsum("ij,ij->i", touching, normals) - offsets).max() < 1e-7


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize("name", ARMS)
def test_sampled_forces_are_inside_and_the_extreme_ones_touch(name, part):
    arm = arms.load(name)
    limits = own_limits(arm, "effort")
    bound = limits.get("upper", arm.effort_limit)
    data = arm.model.createData()
    rng = arms.generator(name, 14)
    for q in arms.configurations(name, 3, salt=14):
        P = srs_ik.force_polytope(arm, q, part, **limits)
        normals, offsets = half_spaces(P)
        load = gravity(arm, q)

        def torque(force, q=q, load=load):
            wrench = np.zeros(6)
            wrench[ROWS[part]] = force
            return load + held(arm, arm.model, data, q, wrench)

        for corner in P.vertices:
            used = np.abs(torque(corner)) / bound
            assert used.max() < 1.0 + 1e-8
            assert (used > 1.0 - 1e-8).sum() >= 3
        # From nothing at all, which is inside, each way until the first joint is at its limit.
        assert (offsets > 0.0).all()
        for u in (unit(rng) for _ in range(40)):
            rate = torque(u) - load
            loaded = np.abs(rate) > 1e-9
            farthest = np.min((np.sign(rate) * bound - load)[loaded] / rate[loaded])
            assert np.max((farthest * u) @ normals.T - offsets) == pytest.approx(0.0, abs=1e-8 * farthest)


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize("name", ARMS)
def test_the_faces_close_and_turn_outwards(name, part):
    arm = arms.load(name)
    for q in arms.configurations(name, 5, salt=15):
        for P in (
            srs_ik.velocity_polytope(arm, q, part, LEAST, MOST),
            srs_ik.force_polytope(arm, q, part, **own_limits(arm, "effort")),
        ):
            assert P.rank == 3
            assert P.singular.shape == (3, 0)
            edges = Counter((f[k], f[(k + 1) % 3]) for f in P.faces.tolist() for k in range(3))
            assert set(edges.values()) == {1}
            assert all((b, a) in edges for a, b in edges)
            assert set(P.faces.ravel().tolist()) == set(range(len(P.vertices)))
            normals, offsets = half_spaces(P)
            scale = np.abs(P.vertices).max()
            assert (P.vertices @ normals.T - offsets).max() < 1e-6 * scale


def test_the_arm_has_its_own_limits_and_its_weight():
    arm = arms.load("iiwa14")
    assert srs_ik.velocity_polytope(arm, Q).extent_along([0, 0, 1]) == pytest.approx(
        np.abs(arm.jacobian(Q)[2] * arm.velocity_limit).sum()
    )
    with_weight, without = srs_ik.force_polytope(arm, Q), srs_ik.force_polytope(arm, Q, gravity=False)
    assert without.extent_along([0, 0, 1]) == pytest.approx(without.extent_along([0, 0, -1]))
    # Lifting is harder than pushing down.
    assert with_weight.extent_along([0, 0, 1]) < without.extent_along([0, 0, 1]) < with_weight.extent_along([0, 0, -1])


@pytest.mark.parametrize("part", PARTS)
def test_the_ellipsoids_of_the_limits_lie_inside(part):
    arm = arms.load("iiwa14")
    for q in arms.configurations("iiwa14", 5, salt=16):
        J = arm.jacobian(q)
        for P, e in (
            (srs_ik.velocity_polytope(arm, q, part), srs_ik.velocity_ellipsoid(J, arm.velocity_limit, part)),
            (srs_ik.force_polytope(arm, q, part, gravity=False), srs_ik.force_ellipsoid(J, arm.effort_limit, part)),
        ):
            normals, offsets = half_spaces(P)
            farthest = np.linalg.norm((normals @ e.axes) * e.radii, axis=1)
            assert (farthest < offsets * (1.0 + 1e-9)).all()


def test_a_joint_near_its_limit_has_little_time():
    arm = arms.load("iiwa14")
    q = Q.copy()
    q[0] = arm.upper[0]
    P = srs_ik.velocity_polytope(arm, q, "angular", horizon=0.1)
    normals, offsets = half_spaces(P)
    J = arm.jacobian(q)[3:]
    most = np.minimum(arm.velocity_limit, (arm.upper - q) / 0.1)
    least = np.maximum(-arm.velocity_limit, (arm.lower - q) / 0.1)
    assert most[0] == 0.0
    for u in directions("iiwa14"):
        assert P.extent_along(u) == pytest.approx(np.maximum((u @ J) * most, (u @ J) * least).sum(), abs=1e-9)
    assert np.max(-normals @ np.zeros(3) - offsets) <= 1e-9
    assert srs_ik.velocity_polytope(arms.load("gen3"), Q, horizon=0.1).rank == 3
    q[0] += 0.01
    with pytest.raises(srs_ik.InvalidConfiguration, match=r"outside its limits by 0\.01 rad"):
        srs_ik.velocity_polytope(arm, q, horizon=0.1)


@pytest.mark.parametrize("q", [STRETCHED, FOLDED], ids=["stretched", "folded"])
def test_the_stretched_and_the_folded_iiwa_are_flat_and_unbounded_along_their_line(q):
    arm, forward = arms.load("iiwa14"), arms.forward("iiwa14")
    line = forward(np.array(q)).translation - arm.limb.shoulder
    line /= np.linalg.norm(line)
    P, F = srs_ik.velocity_polytope(arm, q), srs_ik.force_polytope(arm, q)
    assert (P.rank, P.flat, P.unbounded, F.rank, F.flat, F.unbounded) == (2, True, False, 2, False, True)
    assert np.abs(P.vertices @ line).max() < 1e-9
    assert np.abs(F.vertices @ line).max() < 1e-6
    assert P.singular.shape == (3, 1)
    assert abs(P.singular[:, 0] @ line) == pytest.approx(1.0)
    assert F.extent_along(line) == np.inf
    assert F.extent_along(-line) == np.inf
    assert "flat" in repr(P)
    assert "unbounded" in repr(F)
    J, load, bound = arm.jacobian(q)[:3], gravity(arm, np.array(q)), arm.effort_limit
    for u in directions("iiwa14"):
        across = u - (u @ line) * line
        # Rounding along the line would be called unbounded.
        across = P.vertices.T @ (np.linalg.pinv(P.vertices.T) @ across)
        assert P.extent_along(across) == pytest.approx(
            np.abs(across @ J / np.linalg.norm(across)) @ arm.velocity_limit, rel=1e-8
        )
        best = linprog(
            -across / np.linalg.norm(across),
            np.vstack([J.T, -J.T]),
            np.concatenate([bound - load, bound + load]),
            bounds=(None, None),
        )
        assert F.extent_along(across) == pytest.approx(-best.fun, rel=1e-7)
    # One polygon without holes: each inner edge twice, the rim once.
    edges = Counter(tuple(sorted((f[k], f[(k + 1) % 3]))) for f in P.faces.tolist() for k in range(3))
    assert sum(count == 1 for count in edges.values()) == len(P.vertices)
    assert max(edges.values()) <= 2


def test_at_zero_the_iiwa_has_a_line_of_velocities_and_of_forces():
    arm = arms.load("iiwa14")
    P, F = srs_ik.velocity_polytope(arm, np.zeros(7)), srs_ik.force_polytope(arm, np.zeros(7))
    J = arm.jacobian(np.zeros(7))[0]
    assert (P.rank, len(P.vertices), P.faces.shape) == (1, 2, (0, 3))
    assert sorted(P.vertices[:, 0]) == pytest.approx([-np.abs(J) @ arm.velocity_limit, np.abs(J) @ arm.velocity_limit])
    moving = np.abs(J) > 1e-9
    assert F.extent_along(F.vertices[1]) == pytest.approx((arm.effort_limit[moving] / np.abs(J[moving])).min())
    assert F.singular.shape == (3, 2)


def test_near_a_singularity_nothing_breaks():
    arm = arms.load("iiwa14")
    for bend in 10.0 ** np.arange(-14.0, 0.0):
        q = np.array(STRETCHED)
        q[3] = bend
        P, F = srs_ik.velocity_polytope(arm, q), srs_ik.force_polytope(arm, q)
        J = arm.jacobian(q)[:3]
        for u in directions("iiwa14", 10):
            assert P.extent_along(u) == pytest.approx(np.abs(u @ J) @ arm.velocity_limit, rel=1e-8)
        assert P.rank == F.rank
        assert np.isfinite(F.vertices).all()


def test_faces_that_are_parallel_but_for_rounding_have_corners():
    q = [-2.417816442575165, -1.783057472505325, 0.28564346816340613, 1e-12]
    q += [1.7808749859216526, -0.5950159980364251, -0.15610444092429354]
    lower = -np.array([18.221282139755424, 0.06734050015006746, 97.56188844865639, 0.32355878489881856])
    lower = np.append(lower, [-0.07368139865717356, -0.273421548850758, -0.01860365105271702])
    upper = np.array([58.90690886206362, 1.3222900083229197, 0.0196383382135379, 0.019317456956343605])
    upper = np.append(upper, [0.02168554051493714, 0.04164246417094409, 0.10165851909415556])
    arm = arms.load("human_arm")
    P = srs_ik.velocity_polytope(arm, q, lower=lower, upper=upper)
    J = arm.jacobian(q)[:3]
    for u in directions("human_arm"):
        assert P.extent_along(u) == pytest.approx(np.maximum((u @ J) * lower, (u @ J) * upper).sum(), abs=1e-8)


def test_an_arm_too_weak_for_its_weight_can_exert_nothing():
    arm = arms.load("iiwa14")
    weak = srs_ik.force_polytope(arm, Q, upper=np.full(7, 1.0))
    assert weak.empty
    assert weak.vertices.shape == weak.faces.shape == (0, 3)
    assert weak.extent_along([1, 0, 0]) == -np.inf
    assert "empty" in repr(weak)
    assert not srs_ik.force_polytope(arm, Q, upper=np.full(7, 1.0), gravity=False).empty
    assert srs_ik.force_polytope(arm, STRETCHED, upper=np.full(7, 1.0)).empty
    upright = srs_ik.force_polytope(arm, np.zeros(7), upper=np.full(7, 1e-3))
    assert upright.empty == bool(np.abs(gravity(arm, np.zeros(7))).max() > 1e-3)


def test_limits_that_are_not_given_are_named():
    human = arms.load("human_arm")
    with pytest.raises(srs_ik.MissingLimits, match="human_arm gives no velocity limit for ") as caught:
        srs_ik.velocity_polytope(human, np.full(7, 0.1))
    assert caught.value.joints == human.joint_names
    with pytest.raises(srs_ik.MissingLimits, match="is needed, in N m") as caught:
        srs_ik.force_polytope(human, np.full(7, 0.1))
    assert caught.value.joints == tuple(np.array(human.joint_names)[np.isinf(human.effort_limit)])


@pytest.mark.parametrize("name", arms.here("iiwa14_experimental"))
def test_an_arm_without_masses_is_named(name):
    arm = arms.load(name)
    limits = np.full(7, 50.0)
    with pytest.raises(srs_ik.InvalidTask, match="has no masses"):
        srs_ik.force_polytope(arm, Q, upper=limits)
    assert srs_ik.force_polytope(arm, Q, upper=limits, gravity=False).rank == 3


@pytest.mark.parametrize(
    ("options", "named"),
    [
        ({"part": "full"}, "'full' is for ellipsoids"),
        ({"part": "both"}, "'both'"),
        ({"upper": np.ones(6)}, "upper must be 7 finite numbers"),
        ({"lower": np.full(7, -np.inf)}, "lower must be 7 finite numbers"),
        ({"lower": "none"}, "lower must be 7 finite numbers"),
        ({"upper": -np.ones(7)}, "lower must not be above upper"),
    ],
)
def test_malformed_input_is_named(options, named):
    for build in (srs_ik.velocity_polytope, srs_ik.force_polytope):
        with pytest.raises(srs_ik.InvalidTask) as caught:
            build(arms.load("iiwa14"), Q, **options)
        assert named in str(caught.value)


@pytest.mark.parametrize("horizon", [0.0, -1.0, np.inf, np.nan, "soon"])
def test_a_horizon_is_a_time(horizon):
    with pytest.raises(srs_ik.InvalidTask, match="horizon must be a positive number of seconds"):
        srs_ik.velocity_polytope(arms.load("iiwa14"), Q, horizon=horizon)


def test_a_horizon_is_any_kind_of_number():
    expected = srs_ik.velocity_polytope(arms.load("iiwa14"), Q, horizon=0.25).vertices
    assert (srs_ik.velocity_polytope(arms.load("iiwa14"), Q, horizon=np.float32(0.25)).vertices == expected).all()


def test_other_wrong_input():
    arm = arms.load("iiwa14")
    with pytest.raises(srs_ik.InvalidConfiguration):
        srs_ik.velocity_polytope(arm, Q[:6])
    with pytest.raises(srs_ik.InvalidTask, match="below the upper ones"):
        srs_ik.force_polytope(arm, Q, lower=np.ones(7), upper=np.ones(7))
    with pytest.raises(srs_ik.InvalidTask, match="horizon leaves"):
        srs_ik.velocity_polytope(arm, Q, lower=np.full(7, 0.9), upper=np.ones(7), horizon=1e3)
    for wrong in ([0, 0, 0], [1, 0], [np.nan, 0, 0], "x"):
        with pytest.raises(srs_ik.InvalidTask, match="direction must be 3 finite numbers"):
            srs_ik.velocity_polytope(arm, Q).extent_along(wrong)


def test_without_pycapacity_the_pip_command_is_given(monkeypatch):
    monkeypatch.setitem(sys.modules, "pycapacity", None)
    with pytest.raises(srs_ik.MissingExtra, match=re.escape(install_command("polytopes"))):
        srs_ik.velocity_polytope(arms.load("iiwa14"), Q)


def test_units_and_shape_are_said():
    P = srs_ik.velocity_polytope(arms.load("iiwa14"), Q)
    assert P.unit == "m/s"
    assert srs_ik.force_polytope(arms.load("iiwa14"), Q, "angular").unit == "N m"
    assert repr(P) == f"<Polytope of linear velocity: {len(P.vertices)} vertices, {len(P.faces)} faces>"


@pytest.mark.parametrize(("least", "most"), [(0.0, 100.0), (-100.0, 0.0), (99.0, 100.0), (-1e-3, 100.0)])
@pytest.mark.parametrize("part", ["linear", "angular"])
def test_torques_of_one_sign_leave_what_they_hold(least, most, part):
    """Joint 7 bears no force at a tip on its axis: its limit is a plane without a normal, at zero a shaky one."""
    arm = arms.load("iiwa14")
    lower, upper = np.full(7, least), np.full(7, most)
    P = srs_ik.force_polytope(arm, Q, part, lower, upper)
    J = arm.jacobian(Q)[:3] if part == "linear" else arm.jacobian(Q)[3:]
    weight = pin.computeGeneralizedGravity(arm.model, arm.model.createData(), Q)
    torques = P.vertices @ J + weight
    assert (torques >= lower - 1e-9).all()
    assert (torques <= upper + 1e-9).all()
    # A corner of three dimensions is where three joints are at their limits; an empty one is told by SciPy too.
    ends = (np.abs(torques - lower) < 1e-9) | (np.abs(torques - upper) < 1e-9)
    assert (ends.sum(axis=1) >= 3).all()
    asked = linprog(np.zeros(3), np.vstack([J.T, -J.T]), np.r_[upper - weight, weight - lower], bounds=(None, None))
    if not P.empty:
        assert asked.status == 0
    if asked.status == 2:
        assert P.empty


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize("name", ARMS)
def test_pure_forces_end_where_the_first_joint_is_at_its_limit(name, part):
    """And pure velocities where a linear programme says; both within the largest component."""
    arm = arms.load(name)
    limits = own_limits(arm, "effort")
    bound = limits.get("upper", arm.effort_limit)
    for q in arms.configurations(name, 4, salt=17):
        J, load = arm.jacobian(q)[ROWS[part]], gravity(arm, q)
        F = srs_ik.force_polytope(arm, q, part, **limits)
        V = srs_ik.velocity_polytope(arm, q, part, LEAST, MOST)
        for P in (F, V):
            assert np.linalg.norm(P.normals, axis=1) == pytest.approx(1.0)
            assert (P.vertices @ P.normals.T - P.offsets).max() < 1e-9 * np.abs(P.vertices).max()
        for u in directions(name):
            rate = J.T @ u
            loaded = np.abs(rate) > 1e-9
            farthest = np.min((np.sign(rate) * bound - load)[loaded] / rate[loaded])
            assert F.radius_along(3.0 * u) == pytest.approx(farthest, rel=1e-8)
            best = linprog(
                np.r_[np.zeros(7), -1.0],
                A_eq=np.column_stack([J, -u]),
                b_eq=np.zeros(3),
                bounds=[*zip(LEAST, MOST, strict=True), (None, None)],
            )
            assert V.radius_along(u) == pytest.approx(-best.fun, rel=1e-7)
            assert F.radius_along(u) <= F.extent_along(u) * (1.0 + 1e-9)
            assert V.radius_along(u) <= V.extent_along(u) * (1.0 + 1e-9)


def test_a_pure_force_of_the_documentation_is_held_and_a_larger_one_is_not():
    """The largest component upwards, 370 N, needs a force sideways; alone it is beyond a joint's limit."""
    arm = arms.load("iiwa14")
    P, data = srs_ik.force_polytope(arm, Q), arm.model.createData()
    for u in np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]):
        force = P.radius_along(u)
        torque = gravity(arm, Q) + held(arm, arm.model, data, Q, np.r_[force * u, np.zeros(3)])
        assert (np.abs(torque) / arm.effort_limit).max() == pytest.approx(1.0, abs=1e-9)
        assert force < 0.95 * P.extent_along(u)


def test_pure_forces_and_velocities_at_singular_postures():
    arm, forward = arms.load("iiwa14"), arms.forward("iiwa14")
    for q in (STRETCHED, FOLDED):
        line = forward(np.array(q)).translation - arm.limb.shoulder
        line /= np.linalg.norm(line)
        across = np.linalg.svd(line[None])[2][1]
        V, F = srs_ik.velocity_polytope(arm, q), srs_ik.force_polytope(arm, q)
        assert V.radius_along(line) == pytest.approx(0.0, abs=1e-12)
        assert V.radius_along(line + across) == pytest.approx(0.0, abs=1e-12)
        # Rounding along the line would leave the plane.
        assert 0.0 < V.radius_along(V.vertices.T @ np.linalg.pinv(V.vertices.T) @ across) < np.inf
        assert F.radius_along(line) == F.radius_along(-line) == np.inf
        # The structure carries what is along the line: what is left counts.
        assert F.radius_along(line + across) == pytest.approx(np.sqrt(2.0) * F.radius_along(across), rel=1e-9)
    weak = srs_ik.force_polytope(arm, Q, upper=np.full(7, 1.0))
    assert weak.radius_along([1, 0, 0]) == -np.inf
    with pytest.raises(srs_ik.InvalidTask, match="direction must be 3 finite numbers"):
        weak.radius_along([0, 0, 0])


def test_limits_that_leave_zero_out_leave_some_directions_without_any_velocity():
    arm = arms.load("iiwa14")
    J, lower, upper = arm.jacobian(Q)[:3], np.full(7, 0.5), np.full(7, 1.0)
    P = srs_ik.velocity_polytope(arm, Q, lower=lower, upper=upper)
    met = 0
    for u in np.vstack([directions("iiwa14"), P.vertices, [J @ (0.5 * (lower + upper))]]):
        u = u / np.linalg.norm(u)
        best = linprog(
            np.r_[np.zeros(7), -1.0],
            A_eq=np.column_stack([J, -u]),
            b_eq=np.zeros(3),
            bounds=[*zip(lower, upper, strict=True), (None, None)],
        )
        if best.status == 0:
            assert P.radius_along(u) == pytest.approx(-best.fun, rel=1e-7)
            met += 1
        else:
            assert P.radius_along(u) == -np.inf
    assert 0 < met < len(P.vertices) + 47
