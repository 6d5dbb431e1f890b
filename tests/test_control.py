"""Force profiles, laws and torques, against the equations, quadrature, Pinocchio and finite differences."""

import time
import warnings

import arms
import numpy as np
import pinocchio as pin
import pytest
from oracles import random_angles
from scipy.integrate import quad

import srs_ik
from srs_ik.control import ForceProfile, FractalImpedance, JointLimits, JointSpeeds, TorqueController
from srs_ik.control.baselines import JointImpedance, LinearImpedance, OperationalSpace
from srs_ik.kernels.entries import control as entries
from srs_ik.kernels.layout import control as at

TIP, TURN, ELBOW = ForceProfile.tanh(1000.0, 60.0), ForceProfile.tanh(60.0, 12.0), ForceProfile.tanh(600.0, 40.0)

# The equations, written once more.


def tanh(stiffness, largest):
    return lambda x: largest * np.tanh(stiffness * x / largest)


def saturated(stiffness, largest):
    return lambda x: np.minimum(stiffness * x, largest)


def published(stiffness, largest, e0, eb):
    b, rise = (eb - e0) / 20.0, largest - stiffness * e0
    return lambda x: np.where(
        x < e0, stiffness * x, rise * (1.0 - np.exp(-(np.maximum(x, e0) - e0) / b)) + stiffness * e0
    )


PROFILES = {
    "tanh": (ForceProfile.tanh(1000.0, 50.0), tanh(1000.0, 50.0)),
    "soft tanh": (ForceProfile.tanh(3.0, 200.0), tanh(3.0, 200.0)),
    "saturated": (ForceProfile.saturated(1000.0, 50.0), saturated(1000.0, 50.0)),
    "published tip": (ForceProfile.published(800.0, 100.0, 0.060, 0.080), published(800.0, 100.0, 0.060, 0.080)),
    "published elbow": (ForceProfile.published(630.0, 10.0, 0.010, 0.011), published(630.0, 10.0, 0.010, 0.011)),
    "simulated tip": (ForceProfile.published(5000.0, 150.0, 0.005, 0.006), published(5000.0, 150.0, 0.005, 0.006)),
    "simulated elbow": (ForceProfile.published(1000.0, 100.0, 0.010, 0.011), published(1000.0, 100.0, 0.010, 0.011)),
}


@pytest.mark.parametrize("name", PROFILES)
def test_force_and_energy_are_those_of_the_equations(name):
    profile, force = PROFILES[name]
    x = np.concatenate([[0.0, 1e-12, 1e-6], np.linspace(1e-3, 0.3, 200)])
    assert profile.force(x) == pytest.approx(force(x), rel=1e-12, abs=1e-300)
    for distance in (1e-6, 0.0102, 0.05, 0.061, 0.2):
        corners = sorted({0.01, 0.05, 0.060, 0.0602, 0.065} | {0.0101, 0.011})
        area, _ = quad(force, 0.0, distance, points=[c for c in corners if c < distance] or None, epsabs=1e-14)
        assert profile.energy(distance) == pytest.approx(area, rel=1e-9)
    assert profile.force(x).max() <= profile.largest
    slopes = np.diff(force(np.linspace(0.0, 0.2, 400_001))) / 5e-7
    assert profile.steepest == pytest.approx(slopes.max(), rel=2e-2)


def injected(force, largest, law, peaks):
    """Share of U(e_M) that a law returns beyond what the profile took, by the rule of Simpson on the equations."""
    worst = 0.0
    for peak in peaks:
        x = np.linspace(0.0, peak, 4001)
        F = force(x)
        U = np.append(0.0, np.cumsum(0.5 * (F[1:] + F[:-1]) * x[1]))
        if law == "A":
            h = F[-1] / peak * (2.0 * x - peak)
        else:
            h = np.clip(U[-1] / (0.5 * peak) ** 2 * (x - 0.5 * peak), -largest, largest)
        returned = np.append(np.cumsum((0.5 * (h[1:] + h[:-1]) * x[1])[::-1])[::-1], 0.0)
        worst = max(worst, float(np.max(returned - (U[-1] - U)) / U[-1]))
    return worst


@pytest.mark.parametrize(
    ("name", "law", "share"),
    [
        ("tanh", "A", 0.0),
        ("tanh", "B", 0.018),
        ("published tip", "A", 0.23),
        ("published tip", "B", 0.0),
        ("published elbow", "A", 0.126),
        ("published elbow", "B", 0.0),
        ("simulated tip", "A", 1.614),
        ("simulated tip", "B", 0.0),
        ("simulated elbow", "A", 3.248),
        ("saturated", "A", 0.0),
    ],
)
def test_the_energy_that_a_reversal_injects(name, law, share):
    profile, force = PROFILES[name]
    peaks = np.unique(
        np.concatenate([np.geomspace(1e-3, 0.4, 150), *(np.linspace(e0, 1.1 * e0, 200) for e0 in (0.005, 0.01, 0.06))])
    )
    from_equations = injected(force, profile.largest, law, peaks)
    assert from_equations == pytest.approx(share, abs=0.005)
    assert profile.injection(law) == pytest.approx(from_equations, abs=0.003)


@pytest.mark.parametrize(
    ("gains", "share"),
    [
        ((5000.0, 150.0, 0.005, 0.006), 1.48),
        ((800.0, 100.0, 0.060, 0.080), 0.23),
        ((630.0, 10.0, 0.010, 0.011), 0.10),
    ],
)
def test_the_table_of_injected_energy_is_that_of_the_equations(gains, share):
    # Simulated tip, tip and elbow of the hardware; peaks from the knee to twice its error, twenty in a geometric row.
    stiffness, largest, e0, _ = gains
    peaks = np.geomspace(1.0, 2.0, 20) * e0
    assert injected(published(*gains), largest, "A", peaks) == pytest.approx(share, abs=0.005)
    assert injected(published(*gains), largest, "B", peaks) == pytest.approx(0.0, abs=1e-3)
    # Where the rise behind the knee is a step, r = Fmax/(K e0): r^2/(2 r - 1) - 1, which bounds every width.
    step = largest / (stiffness * e0)
    assert share < injected(published(*gains), largest, "A", np.linspace(e0, 1.1 * e0, 400))
    assert (
        injected(published(*gains), largest, "A", np.linspace(e0, 1.1 * e0, 400)) < step**2 / (2.0 * step - 1.0) - 1.0
    )


@pytest.mark.parametrize("name", ["published tip", "published elbow", "simulated tip", "simulated elbow"])
def test_a_profile_that_injects_is_refused_with_the_reason(name):
    profile, _ = PROFILES[name]
    with pytest.raises(srs_ik.InvalidController, match="not passive with a published profile: its force over distance"):
        FractalImpedance("tip", profile)
    with pytest.raises(srs_ik.InvalidController, match="tanh"):
        FractalImpedance("tip", TIP, law="B")
    FractalImpedance("tip", profile, law="B")
    FractalImpedance("tip", profile, may_inject=True)


def test_the_free_response_of_a_linear_spring_is_half_a_cosine():
    mass, stiffness, start = 3.0, 1000.0, 0.02
    w = np.sqrt(2.0 * stiffness / mass)
    dt = np.pi / w / 2000
    positions = np.empty(2001)
    entries.free_response(ForceProfile.saturated(stiffness, 1e6).row("A"), mass, start, dt, positions)
    closed = 0.5 * start * (1.0 + np.cos(w * dt * np.arange(2001)))
    assert np.abs(positions - closed).max() < 1e-9
    speed = np.abs(np.diff(positions)) / dt
    assert speed.max() / speed.mean() == pytest.approx(np.pi / 2.0, rel=1e-5)


def test_a_tanh_comes_to_rest_at_the_target_from_any_peak():
    for start in (0.001, 0.05, 0.5):
        positions = np.empty(20001)
        # Law A is linear in the error, whatever the profile: w^2 = 2 F(e_M) / (e_M m).
        w = np.sqrt(2.0 * float(TIP.force(start)) / start / 3.0)
        entries.free_response(TIP.row("A"), 3.0, start, np.pi / w / 20000, positions)
        assert abs(positions[-1]) < 1e-9
        assert positions.min() > -1e-9


@pytest.mark.parametrize("law", ["A", "B", "spring"])
def test_sampled_motion_is_that_of_a_plain_simulation(law):
    profile, force = PROFILES["tanh"]
    mass, start, period, delay, n = 3.0, 0.08, 0.004, 0.0, 400
    out, state = np.empty((n, 3)), np.zeros(at.STATE)
    state[at.LAST : at.LAST + 3] = -1.0
    entries.sampled_response(profile.row(law), state, np.array([mass, start, period, delay]), np.zeros(2), out)
    x, v, peak, back = start, 0.0, 0.0, False
    for k in range(n):
        size = abs(x)
        back = k > 0 and x * v < 0.0
        peak = max(size, peak) if back else size
        pull = float(force(size))
        if back and law == "A":
            pull = float(force(peak)) * (2.0 * size / peak - 1.0)
        elif back and law == "B":
            U = 50.0**2 / 1000.0 * np.log(np.cosh(1000.0 * peak / 50.0))
            pull = float(np.clip(U / (0.5 * peak) ** 2 * (size - 0.5 * peak), -50.0, 50.0))
        h = -np.sign(x) * pull
        assert out[k] == pytest.approx([x, v, h], rel=1e-6, abs=1e-9)
        x, v = x + period * v + 0.5 * h / mass * period**2, v + h / mass * period


# The arm


def reference_torque(arm, forward, q, forces):
    """Torques of tip force, tip torque and elbow force, by Pinocchio and finite differences of the whole robot."""
    J = arm.jacobian(q)
    elbow = np.empty((3, 7))
    for k in range(7):
        step = np.zeros(7)
        step[k] = 1e-6
        elbow[:, k] = (
            forward.carried(q + step, 3, arm.limb.elbow) - forward.carried(q - step, 3, arm.limb.elbow)
        ) / 2e-6
    return J[:3].T @ forces[0] + J[3:].T @ forces[1] + elbow.T @ forces[2]


@pytest.mark.parametrize("per_axis", [False, True])
@pytest.mark.parametrize("name", arms.here("iiwa14", "gen3", "human_arm", "j2s7s300"))
def test_torques_are_transposed_jacobians_times_forces_and_weight(name, per_axis):
    arm, rng = arms.load(name), arms.generator(name, 5)
    ports = [
        FractalImpedance(on, profile, per_axis=per_axis)
        for on, profile in (("tip", TIP), ("orientation", TURN), ("elbow", ELBOW))
    ]
    c = TorqueController(arm, ports, max_torque=1e9)
    data = arm.model.createData()
    for q, wanted in zip(arms.configurations(name, 20, 1), arms.configurations(name, 20, 2), strict=True):
        c.set_posture(wanted)
        tau = c.torque(q, rng.normal(size=7))
        T, T_wanted = arm.forward_kinematics(q), arm.forward_kinematics(wanted)
        elbow = [arms.forward(name).carried(x, 3, arm.limb.elbow) for x in (q, wanted)]
        errors = [
            T_wanted.translation - T.translation,
            pin.log3(T_wanted.rotation @ T.rotation.T),
            elbow[1] - elbow[0],
        ]
        forces = []
        for error, force in zip(errors, (tanh(1000.0, 60.0), tanh(60.0, 12.0), tanh(600.0, 40.0)), strict=True):
            size = np.linalg.norm(error)
            forces.append(np.sign(error) * force(np.abs(error)) if per_axis else error / size * force(size))
        g = pin.computeGeneralizedGravity(arm.model, data, arm.configuration(q))
        assert tau == pytest.approx(reference_torque(arm, arms.forward(name), q, forces) + g, abs=2e-6)
        assert c.gravity_torque == pytest.approx(g, abs=1e-9)
        for reading, error, force in zip(c.readings, errors, forces, strict=True):
            assert reading.error == pytest.approx(error, abs=1e-9)
            assert reading.force == pytest.approx(force, abs=1e-6)


def test_a_controller_holds_the_weight_alone_until_it_has_a_target():
    """And so do the rivals; once told, each does what one does that never was without."""
    arm = arms.load("iiwa14")
    q, v = np.array([1.5, 0.6, 0.0, -1.4, 0.0, 0.8, 0.0]), np.linspace(-0.4, 0.3, 7)
    g = pin.computeGeneralizedGravity(arm.model, arm.model.createData(), arm.configuration(q))
    profiles = {"tip": TIP, "orientation": TURN, "elbow": ELBOW, "arm_angle": TURN}
    ports = [FractalImpedance(on, profile, damping=3.0) for on, profile in profiles.items()]
    c = TorqueController(arm, ports)
    for _ in range(3):
        assert c.torque(q, v) == pytest.approx(g, abs=1e-9)
    assert c.energy == c.power == 0.0
    assert all(np.all(reading.force == 0.0) and np.all(reading.error == 0.0) for reading in c.readings)
    assert [reading.on for reading in c.readings] == list(profiles)
    # The elbow alone is told: the others go on doing nothing.
    elbow = arms.forward("iiwa14").carried(q, 3, arm.limb.elbow)
    c.set_elbow(elbow + 0.02 * np.eye(3)[1])
    c.torque(q, v)
    assert [bool(np.any(reading.force)) for reading in c.readings] == [False, False, True, False]
    assert c.readings[2].error == pytest.approx([0.0, 0.02, 0.0], abs=1e-9)
    c.set_posture(q + 0.1)
    other = TorqueController(arm, ports)
    other.set_posture(q + 0.1)
    for _ in range(3):
        np.testing.assert_array_equal(c.torque(q, v), other.torque(q, v))
        assert np.abs(c.torque(q, v) - g).max() > 1.0
        other.torque(q, v)
    for rival in (OperationalSpace(arm), LinearImpedance(arm), JointImpedance(arm)):
        assert rival.torque(q, v) == pytest.approx(g, abs=1e-9)
        assert rival.gravity_torque == pytest.approx(g, abs=1e-9)
        rival.set_posture(q + 0.1)
        assert np.abs(rival.torque(q, v) - g).max() > 1.0


def test_the_arm_angle_is_pulled_along_its_derivatives():
    arm = arms.load("iiwa14")
    c = TorqueController(arm, [FractalImpedance("arm_angle", TURN)], gravity=False)
    for q in arms.configurations("iiwa14", 50, 3):
        T = arm.forward_kinematics(q)
        wanted = arm.arm_angle(q) + 0.3
        c.set_target(T, arm_angle=wanted)
        g = arm.arm_angle_jacobian(q)
        share = min(1.0, 20.0 / np.linalg.norm(g))
        assert c.torque(q, np.zeros(7)) == pytest.approx(share * g * float(TURN.force(0.3)), rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("law", ["A", "spring"])
def test_an_arm_angle_gives_back_what_it_took_where_its_derivatives_are_scaled_down(law):
    """The elbow turns around within a millimetre of the line from shoulder to wrist, and comes back far from it."""
    arm, dt = arms.load("iiwa14"), 1.0 / 2000.0
    c = TorqueController(arm, [FractalImpedance("arm_angle", ForceProfile.tanh(30.0, 10.0), law)], gravity=False)
    q = np.array([0.0, 0.8, 0.005, -0.6, 0.0, 0.5, 0.0])
    c.set_posture(q)
    given, most = 0.0, -np.inf
    for joint, turn, seconds in ((1, -1.6, 1.5), (2, np.pi, 3.0)):
        for s in np.arange(0.0, 1.0, dt / seconds):
            now, v = q.copy(), np.zeros(7)
            now[joint] += turn * (10.0 * s**3 - 15.0 * s**4 + 6.0 * s**5)
            v[joint] = turn * (30.0 * s**2 - 60.0 * s**3 + 30.0 * s**4) / seconds
            c.torque(now, v)
            given += c.power * dt
            most = max(most, given)
        q[joint] += turn
        if joint == 1:
            reading = c.readings[0]
            assert abs(reading.error[0]) > 3.0
            # The elbow turns around in some 30 periods: sums over these are off by as much.
            taken = -given
            assert 0.0 < reading.energy < 1.1 * taken
    assert most < 0.1 * taken


def test_joint_limits_push_back_within_their_zone_alone():
    arm = arms.load("iiwa14")
    limits = JointLimits(margin=0.2)
    c = TorqueController(arm, [], gravity=False, limits=limits)
    assert np.all(c.torque(np.zeros(7), np.zeros(7)) == 0.0)
    for k in range(7):
        for q_k, sign in ((arm.upper[k] - 0.05, -1.0), (arm.lower[k] + 0.05, 1.0)):
            q = np.zeros(7)
            q[k] = q_k
            c.restart()
            expected = np.zeros(7)
            expected[k] = sign * 40.0 * np.tanh(300.0 * 0.15 / 40.0)
            assert c.torque(q, np.zeros(7)) == pytest.approx(expected, rel=1e-9)


def test_the_peak_is_the_largest_error_of_the_current_divergence():
    arm = arms.load("iiwa14")
    start = np.array([0.1, 0.5, 0.0, -1.2, 0.2, 0.7, 0.0])
    c = TorqueController(arm, [FractalImpedance("arm_angle", TURN, switch="error")], gravity=False)
    c.set_target(arm.forward_kinematics(start), arm_angle=arm.arm_angle(start))
    way = np.array([0.0, 0.05, 0.10, 0.15, 0.12, 0.08, 0.04, 0.06, 0.07, 0.05])
    readings = []
    for angle in way:
        q = arm.solve(arm.forward_kinematics(start), arm_angle=arm.arm_angle(start) + angle, seed=start).q
        c.torque(q, np.zeros(7))
        readings.append(c.readings[0])
    back = [False, False, False, False, True, True, True, False, False, True]
    assert [bool(r.converging[0]) for r in readings] == back
    assert [r.peak[0] for r in readings] == pytest.approx(way[[0, 1, 2, 3, 3, 3, 3, 7, 8, 8]], abs=1e-9)
    # Law A brakes below half of the peak.
    brake = float(TURN.force(0.15)) * (2.0 * 0.04 / 0.15 - 1.0)
    assert readings[6].force[0] == pytest.approx(-brake, rel=1e-6)
    assert brake < 0.0


def test_brakes_act_beyond_their_speed_alone_and_take_energy_out():
    arm = arms.load("iiwa14")
    c = TorqueController(arm, [], gravity=False, speeds=JointSpeeds(2.0, 3.0, 4.0, rate=4000.0))
    for speed, torque in ((0.0, 0.0), (1.9, 0.0), (2.5, 1.5), (-2.5, -1.5), (1e5, 4.0)):
        assert c.torque(np.zeros(7), np.full(7, speed)) == pytest.approx(np.full(7, -torque))
        assert c.power <= 0.0
    own = TorqueController(arm, [], gravity=False, speeds=JointSpeeds(rate=4000.0))
    tau = own.torque(np.zeros(7), arm.velocity_limit + 1.0)
    assert tau == pytest.approx(-0.05 * arm.effort_limit)
    assert np.all(own.torque(np.zeros(7), arm.velocity_limit) == 0.0)


@pytest.mark.parametrize("name", arms.here("iiwa14", "gen3", "openarm_left"))
def test_usual_brakes_stay_below_what_a_period_allows(name):
    arm, rng = arms.load(name), arms.generator(name)
    arm = arm.with_limits(velocity=np.ones(7), effort=np.full(7, 200.0))
    data = arm.model.createData()
    for options, period in (({}, 1e-3), ({"rate": 250.0}, 4e-3)):
        c = TorqueController(arm, [], gravity=False, speeds=JointSpeeds(**options))
        damping = -c.torque(np.zeros(7), arm.velocity_limit + 1e-3) / 1e-3
        used = np.zeros(7)
        for _ in range(300):
            q = random_angles(rng, arm.lower, arm.upper)
            q[1:6:2] = rng.choice((0.0, 1.0), 3) * q[1:6:2]
            M = pin.crba(arm.model, data, arm.configuration(q))
            inverse = np.linalg.inv(np.triu(M) + np.triu(M, 1).T)
            used = np.maximum(used, damping * period * np.diag(inverse))
            # A step takes energy out as long as no eigenvalue is above 2.
            assert np.linalg.eigvals(period * inverse * damping).real.max() < 1.8
        assert used.max() < 0.8
        assert used.min() > 0.001


def test_brakes_that_drive_their_joint_get_a_warning():
    arm = arms.load("iiwa14")
    with pytest.warns(UserWarning, match=r"brake on joint 'iiwa_joint_7' may drive it.* 0\.455 ms, not 1: name"):
        TorqueController(arm, [], speeds=JointSpeeds(damping=0.05 * arm.effort_limit))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        TorqueController(arm, [], speeds=JointSpeeds(damping=0.05 * arm.effort_limit, rate=4000.0))
        TorqueController(arm, [], speeds=True)


def bound(arm, q, axes):
    """Sum of |J'| Fmax over tip, orientation and elbow, (n, 7), each J in the axes (n, 3, 3, 3) of its port."""
    J = arm.jacobian_batch(q)
    lever = arm.centres(q).elbow - arm.forward_kinematics_batch(q)[:, :3, 3]
    of_elbow = J[:, :3] + np.cross(J[:, 3:], lever[:, :, None], axisa=1, axisb=1, axisc=1)
    of_elbow[:, :, 3:] = 0.0
    parts = enumerate(zip((J[:, :3], J[:, 3:], of_elbow), (60.0, 12.0, 40.0), strict=True))
    return sum(largest * np.abs(axes[:, k] @ part).sum(axis=1) for k, (part, largest) in parts)


def drawn(arm, rng, n):
    """Random configurations (n, 7); of half of them some joints are at zero, at 180 degrees or at a limit: singular."""
    q = rng.uniform(-3.2, 3.2, (n, 7))
    special = np.stack([np.zeros(7), np.full(7, np.pi), np.nan_to_num(arm.lower, neginf=0.0)])
    chosen = (rng.uniform(size=(n, 7)) < 0.5) & (np.arange(n) % 2 == 0)[:, None]
    return np.where(chosen, special[rng.integers(0, 3, (n, 7)), np.arange(7)], q)


def held_bounded(name, targets, a_target, per_axis):
    arm, rng = arms.load(name), arms.generator(name, 9)
    profiles = {"tip": TIP, "orientation": TURN, "elbow": ELBOW}
    ports = [FractalImpedance(on, profile, per_axis=per_axis) for on, profile in profiles.items()]
    c = TorqueController(arm, ports, max_torque=np.inf)
    torques, weights = np.empty((a_target, 7)), np.empty((a_target, 7))
    axes = np.empty((a_target, 3, 3, 3))
    for _ in range(targets):
        T = arm.forward_kinematics(drawn(arm, rng, 2)[0]).homogeneous
        T[:3, 3] *= rng.choice([0.0, 1.0, 1.3, 1e3])
        c.set_target(T)
        q, v = drawn(arm, rng, a_target), rng.normal(size=(a_target, 7)) * 10.0 ** rng.uniform(-3, 5)
        for i in range(a_target):
            torques[i], weights[i] = c.torque(q[i], v[i]), c.gravity_torque
            axes[i] = [port.axes for port in c.readings]
        # NaN is not below anything.
        assert (np.abs(torques) <= bound(arm, q, axes) + np.abs(weights) + 1e-9).all()


@pytest.mark.parametrize("per_axis", [False, True])
@pytest.mark.parametrize("name", arms.here("iiwa14", "gen3", "human_arm"))
def test_torques_are_finite_and_bounded_in_every_configuration(name, per_axis):
    held_bounded(name, 10, 150, per_axis)


@pytest.mark.slow
@pytest.mark.parametrize("per_axis", [False, True])
def test_a_million_torques_are_finite_and_bounded(per_axis):
    held_bounded("iiwa14", 500, 1000, per_axis)


def test_targets_come_from_solve_and_solve_task():
    arm = arms.load("iiwa14")
    ports = [FractalImpedance("tip", TIP), FractalImpedance("orientation", TURN), FractalImpedance("elbow", ELBOW)]
    c = TorqueController(arm, ports, gravity=False)
    T = arm.forward_kinematics([0.2, 0.6, -0.3, -1.3, 0.4, 0.9, 0.1])
    solution = c.set_target(T, arm_angle=0.4)
    assert solution.arm_angle == pytest.approx(0.4)
    assert np.abs(c.torque(solution.q, np.zeros(7))).max() < 1e-6
    task = srs_ik.Task([0.4, 0.2, 0.6], [0, 1, 0], [0, 0, 1])
    found = c.set_task(task)
    assert np.abs(c.torque(found.q, np.zeros(7))).max() < 1e-6
    far = T.homogeneous.copy()
    far[:3, 3] *= 10.0
    assert not c.set_target(far)
    assert np.isfinite(c.torque(found.q, np.zeros(7))).all()


def test_a_tick_takes_few_times_the_inverse_dynamics_of_pinocchio():
    """1.8 times on one machine, on which seven times would be 15 us: the least of many short turns of both."""
    arm = arms.load("iiwa14")
    ports = [FractalImpedance("tip", TIP), FractalImpedance("orientation", TURN), FractalImpedance("elbow", ELBOW)]
    c = TorqueController(arm, ports, limits=True)
    model, q, v, rest = arm.model, np.full(7, 0.3), np.full(7, 0.1), np.zeros(7)
    data = model.createData()
    tick, alone = np.inf, np.inf
    for _ in range(100):
        begin = time.thread_time()
        for _ in range(50):
            c.torque(q, v)
        between = time.thread_time()
        for _ in range(50):
            pin.rnea(model, data, q, v, rest)
        tick, alone = min(tick, between - begin), min(alone, time.thread_time() - between)
    assert tick < 7.0 * alone


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda arm: ForceProfile.tanh(-1.0, 2.0), "stiffness"),
        (lambda arm: ForceProfile.tanh(1.0, float("nan")), "largest"),
        (lambda arm: ForceProfile.published(800.0, 100.0, 0.08, 0.06), "second error"),
        (lambda arm: ForceProfile.published(800.0, 10.0, 0.06, 0.08), "below"),
        (lambda arm: FractalImpedance("hip", TIP), "hip"),
        (lambda arm: FractalImpedance("tip", TIP, law="C"), "law"),
        (lambda arm: FractalImpedance("tip", TIP, damping=-1.0), "damping"),
        (lambda arm: FractalImpedance("tip", 3.0), "ForceProfile"),
        (lambda arm: TorqueController(arm, ["tip"]), "FractalImpedance"),
        (lambda arm: TorqueController(arm, [], max_torque=-1.0), "max_torque"),
        (lambda arm: JointSpeeds(begin=[1.0, 2.0]), "begin"),
        (lambda arm: TorqueController(arms.load("human_arm"), [], speeds=True), "limits on all joints"),
        (lambda arm: TorqueController(arms.load("made_near"), []), "masses"),
        (
            lambda arm: TorqueController(arms.load("made_near"), [], False, speeds=JointSpeeds(1.0, largest=1.0)),
            "no inertias that tell it: name damping",
        ),
        (lambda arm: TorqueController(arm, []).torque(np.full(7, np.nan), np.zeros(7)), "q"),
        (lambda arm: TorqueController(arm, []).torque(np.zeros(7), np.full(7, np.inf)), "speeds"),
        (lambda arm: TorqueController(arm, []).torque(np.zeros(6), np.zeros(7)), "7 joint angles"),
    ],
)
def test_wrong_input_is_named_in_one_line(make, word):
    with pytest.raises((srs_ik.InvalidController, srs_ik.InvalidConfiguration), match=word) as caught:
        make(arms.load("iiwa14"))
    assert "\n" not in str(caught.value)
