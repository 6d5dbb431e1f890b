"""`Objective`: values against plain NumPy on Pinocchio's Jacobian, and what is refused."""

import arms
import numpy as np
import pytest
from objective_parameters import FORCE, NAMES, PARAMETERS, REFERENCE, SIX, VELOCITY

import srs_ik
from srs_ik import InvalidConfiguration, InvalidTask, Objective
from srs_ik.solve.objectives import DEFAULT_TOLERANCE


def expected(arm, name, q):
    J = arm.jacobian(q)
    A = J[:3] @ J[:3].T
    f, v, six = (x / np.linalg.norm(x) for x in (FORCE, VELOCITY, SIX))
    if name == "force_velocity_ratio":
        return (f @ A @ f / (v @ A @ v),)
    if name == "force_then_velocity":
        return f @ A @ f, v @ A @ v
    if name == "velocity_then_force":
        return v @ A @ v, f @ A @ f
    if name in ("twist", "wrench"):
        return (six @ J @ J.T @ six,)
    if name == "manipulability":
        return (np.sqrt(np.linalg.det(J @ J.T)),)
    if name == "limit_margin":
        limited = np.isfinite(arm.upper)
        room = np.minimum(q - arm.lower, arm.upper - q)[limited]
        return ((room / (0.5 * (arm.upper - arm.lower)[limited])).min(),)
    if name == "reference_posture":
        return (np.sum((q - REFERENCE) ** 2),)
    return (gravity_from_energy(arm, q),)


def gravity_from_energy(arm, q):
    """Squared torques over limits, the torques as differences of the potential energy of the masses."""
    import pinocchio as pin

    data = arm.model.createData()

    def energy(angles):
        return pin.computePotentialEnergy(arm.model, data, arm.configuration(angles))

    h = 1e-5
    torque = np.array([(energy(q + h * e) - energy(q - h * e)) / (2.0 * h) for e in np.eye(7)])
    return np.sum((torque / arm.effort_limit) ** 2)


def test_every_name_is_tested():
    assert set(NAMES) == set(srs_ik.OBJECTIVES)


@pytest.mark.parametrize("robot", ["iiwa14", "gen3", "human_arm"])
@pytest.mark.parametrize("name", NAMES)
def test_values_are_those_of_the_formula(robot, name):
    arm = arms.load(robot)
    if name == "gravity_torque" and not np.isfinite(arm.effort_limit).all():
        pytest.skip("no effort limits to relate torques to")
    objective = Objective(name, **PARAMETERS[name])
    for q in arms.configurations(robot, 10, 40):
        values = expected(arm, name, q)
        assert objective.values(arm, q) == pytest.approx(values, rel=1e-6 if name == "gravity_torque" else 1e-9)
        assert objective.value(arm, q) == objective.values(arm, q)[0]


@pytest.mark.parametrize("name", NAMES)
def test_the_optimum_carries_the_value_of_its_posture(name):
    for robot in ("iiwa14", "gen3", "human_arm"):
        arm = arms.load(robot)
        for q in arms.configurations(robot, 5, 41):
            optimum = arm.optimise(arm.forward_kinematics(q), name, **PARAMETERS[name])
            objective = optimum.objective
            assert optimum
            assert optimum.value == pytest.approx(objective.value(arm, optimum.q), rel=1e-9, abs=1e-12)
            if objective.second >= 0:
                assert optimum.second_value == pytest.approx(objective.values(arm, optimum.q)[1], rel=1e-9)
            else:
                assert optimum.second_value is None


def test_directions_may_have_any_length():
    arm = arms.load("iiwa14")
    q = arms.configurations("iiwa14", 1, 42)[0]
    for factor in (1e-200, 3.0, 1e200):
        scaled = Objective("force_velocity_ratio", force=factor * FORCE, velocity=VELOCITY / factor)
        assert scaled.value(arm, q) == pytest.approx(expected(arm, "force_velocity_ratio", q)[0], rel=1e-12)


def test_a_function_keeps_its_name_and_sense():
    def elbow_bend(q):
        return abs(q[3])

    objective = Objective(elbow_bend, maximise=True)
    assert (objective.name, objective.maximise, objective.unit) == ("elbow_bend", True, "")
    assert objective.value(arms.load("iiwa14"), np.full(7, -0.5)) == 0.5
    assert repr(objective) == "<Objective elbow_bend, maximised>"


def test_gravity_torques_need_masses():
    arm = srs_ik.load(arms.load("iiwa14").model.copy(), tip=arms.load("iiwa14").tip, base=arms.load("iiwa14").base)
    for inertia in arm.model.inertias:
        inertia.mass = 0.0
    with pytest.raises(InvalidTask, match="has no masses"):
        Objective("gravity_torque").value(arm, np.zeros(7))


def test_gravity_torques_are_absolute_where_an_effort_limit_is_missing():
    arm = srs_ik.load("iiwa14")
    q = arms.configurations("iiwa14", 1, 43)[0]
    relative = Objective("gravity_torque").value(arm, q)

    def with_efforts(limits):
        model = arm.model.copy()
        model.effortLimit = limits
        return Objective("gravity_torque").value(srs_ik.load(model, base=arm.base, tip=arm.tip), q)

    tenth = with_efforts(np.full(7, 10.0))
    assert with_efforts(np.where(np.arange(7) == 2, np.inf, arm.effort_limit)) == pytest.approx(100.0 * tenth)
    assert relative < tenth


def refused(*arguments, **parameters):
    with pytest.raises(InvalidTask) as caught:
        Objective(*arguments, **parameters)
    assert isinstance(caught.value, ValueError)
    return str(caught.value)


def test_an_unknown_name_is_met_with_the_known_ones():
    message = refused("manipulabilty")
    assert "did you mean 'manipulability'" in message
    assert all(name in message for name in NAMES)


@pytest.mark.parametrize(
    ("parameters", "clause"),
    [
        ({"force": FORCE}, "needs velocity=, 3 numbers"),
        ({"force": FORCE, "velocity": [1.0, 0.0]}, "velocity must be 3 numbers, not an array of shape (2,)"),
        ({"force": FORCE, "velocity": [0.0, 0.0, 0.0]}, "velocity must not be zero"),
        ({"force": [np.nan, 0.0, 1.0], "velocity": VELOCITY}, "force has entries that are not finite"),
        ({"force": "up", "velocity": VELOCITY}, "force must be 3 numbers, not str"),
        ({"force": FORCE, "velocity": VELOCITY, "speed": 1.0}, "takes no parameter 'speed'; it takes force, velocity"),
        ({"force": FORCE, "velocity": VELOCITY, "tolerance": 0.1}, "takes no parameter 'tolerance'"),
    ],
)
def test_malformed_parameters_are_named(parameters, clause):
    assert clause in refused("force_velocity_ratio", **parameters)


@pytest.mark.parametrize("tolerance", [-0.1, np.nan, np.inf, "small"])
def test_a_tolerance_is_a_small_positive_number(tolerance):
    assert "tolerance must be a number" in refused(
        "force_then_velocity", force=FORCE, velocity=VELOCITY, tolerance=tolerance
    )
    assert Objective("force_then_velocity", force=FORCE, velocity=VELOCITY).tolerance == DEFAULT_TOLERANCE


def test_other_wrong_objectives_are_refused():
    assert "not int" in refused(3)
    assert "always maximised" in refused("manipulability", maximise=False)
    assert "no parameter 'force'" in refused(lambda q: 0.0, force=FORCE)
    with pytest.raises(InvalidConfiguration):
        Objective("reference_posture", reference=[0.0] * 6)
    arm = arms.load("iiwa14")
    with pytest.raises(InvalidTask, match="finite number, not nan"):
        Objective(lambda q: np.nan).value(arm, np.zeros(7))
    with pytest.raises(InvalidTask, match="must return a number, not NoneType"):
        Objective(lambda q: None).value(arm, np.zeros(7))
    with pytest.raises(InvalidTask, match="has its parameters already"):
        arm.optimise(np.eye(4), Objective("manipulability"), force=FORCE)
