"""The plant: MuJoCo beside Pinocchio, and what is done to the arm in it."""

import re
import time
import warnings
from pathlib import Path

import arms
import numpy as np
import pinocchio as pin
import pytest

import srs_ik
from srs_ik.control import ForceProfile, FractalImpedance, JointSpeeds, TorqueController
from srs_ik.control.baselines import Gains, JointImpedance, LinearImpedance, OperationalSpace

pytest.importorskip("mujoco", "3.14")

import mujoco

from srs_ik.sim import Plant, Push, simulate

BARE = ("made_near", "iiwa14_experimental", "sia10f", "sia5d")
"""Files without inertias."""

BODIED = tuple(name for name in arms.EVERY if name not in BARE)
HOME = np.array([0.0, 0.6, 0.0, -1.4, 0.0, 0.8, 0.0])


def controller(arm, per_axis=True, **options):
    ports = [
        FractalImpedance("tip", ForceProfile.tanh(1000.0, 60.0), per_axis=per_axis),
        FractalImpedance("orientation", ForceProfile.tanh(60.0, 12.0), per_axis=per_axis),
        FractalImpedance("elbow", ForceProfile.tanh(600.0, 40.0), per_axis=per_axis),
    ]
    return TorqueController(arm, ports, **options)


def test_there_are_ten_arms_to_compare():
    assert len([name for name in (*arms.BUILT_IN, *arms.MADE) if name not in BARE]) >= 9
    assert len(BODIED) >= 10


@pytest.mark.parametrize("name", BODIED)
def test_mass_matrix_and_bias_are_those_of_pinocchio(name):
    arm, rng = arms.load(name), arms.generator(name, 3)
    plant, data = Plant(arm), arm.model.createData()
    for _ in range(25):
        q, v = rng.uniform(-2.0, 2.0, 7), rng.normal(size=7)
        plant.reset(q, v)
        c = arm.configuration(q)
        M = pin.crba(arm.model, data, c)
        M = np.triu(M) + np.triu(M, 1).T
        h = pin.nonLinearEffects(arm.model, data, c, v)
        assert np.abs(plant.mass_matrix - M).max() < 1e-9 * np.abs(M).max()
        assert np.abs(plant.bias - h).max() < 1e-9 * np.abs(h).max()


def fallen(arm, q, seconds, dt):
    """Joint angles after a free fall, by Pinocchio and the method of Runge and Kutta."""
    model, data, v = arm.model, arm.model.createData(), np.zeros(7)

    def acceleration(q, v):
        return pin.aba(model, data, arm.configuration(q), v, np.zeros(7))

    for _ in range(round(seconds / dt)):
        a1 = acceleration(q, v)
        a2 = acceleration(q + 0.5 * dt * v, v + 0.5 * dt * a1)
        a3 = acceleration(q + 0.5 * dt * (v + 0.5 * dt * a1), v + 0.5 * dt * a2)
        a4 = acceleration(q + dt * (v + 0.5 * dt * a2), v + dt * a3)
        q = q + dt * v + dt**2 / 6.0 * (a1 + a2 + a3)
        v = v + dt / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
    return q


def steady_start(arm):
    """A posture from which a fall is no chaos: 1e-12 rad at its start stay below 1e-7 rad; and where it ends.

    A light wrist may whirl by 45 rad within the second, and turn 1e-13 rad into 0.1.
    """
    for start in (HOME + 0.2, HOME, HOME - 0.3):
        end = fallen(arm, start, 1.0, 2.5e-4)
        if np.abs(fallen(arm, start + 1e-12, 1.0, 2.5e-4) - end).max() < 1e-7:
            return start, end
    raise AssertionError("every fall is chaotic")


QUICK = ("iiwa14", "gen3", "made_offsets")


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name in QUICK else pytest.mark.slow) for name in BODIED]
)
def test_a_free_fall_of_one_second_is_that_of_pinocchio(name):
    arm = arms.load(name)
    plant = Plant(arm, damping=0.0, friction=0.0, joint_limits=False)
    start, end = steady_start(arm)
    plant.fall_exactly()
    plant.reset(start)
    for _ in range(4000):
        plant.step(np.zeros(7))
    assert np.abs(plant.q - start).max() > 0.3
    assert np.abs(plant.q - end).max() < 1e-6


def test_damping_and_friction_are_those_of_the_file_or_those_that_are_named():
    text = (Path(__file__).parents[1] / "robots" / "iiwa14" / "iiwa14.urdf").read_text()
    arm = srs_ik.load(re.sub(r"<limit ", '<dynamics damping="0.3" friction="0.2"/><limit ', text), tip="iiwa_link_ee")
    plant = Plant(arm)
    assert plant.damping == pytest.approx(np.full(7, 0.3))
    assert plant.friction == pytest.approx(np.full(7, 0.2))
    plant = Plant(arm, damping=0.0, friction=[0.0] * 6 + [0.1])
    assert plant.damping == pytest.approx(np.zeros(7))
    assert plant.friction == pytest.approx([0.0] * 6 + [0.1])
    plant.reset(HOME)
    hold = TorqueController(arm, [])
    for _ in range(400):
        plant.step(hold.torque(plant.q, plant.v) + 0.05 * np.eye(7)[6])
    # Free, the joint would go 0.2 rad; below its dry friction it creeps as the soft constraint gives way.
    assert abs(plant.q[6] - HOME[6]) < 0.02


@pytest.mark.parametrize("name", [name for name in ("made_near", *arms.here("sia10f")) if name in BARE])
def test_an_arm_without_inertias_is_refused(name):
    with pytest.raises(srs_ik.InvalidController, match="no inertias to simulate") as caught:
        Plant(arms.load(name))
    assert "\n" not in str(caught.value)


def test_a_moved_and_equipped_arm_is_the_same_plant():
    arm = arms.load("iiwa14")
    T = np.eye(4)
    T[:3, :3] = pin.rpy.rpyToMatrix(0.3, -0.7, 1.1)
    T[:3, 3] = 0.4, -0.2, 0.9
    tool = np.eye(4)
    tool[2, 3] = 0.2
    moved = arm.with_base(T).with_tool(tool)
    plant = Plant(moved)
    plant.reset(HOME)
    data = moved.model.createData()
    assert plant.bias == pytest.approx(pin.computeGeneralizedGravity(moved.model, data, HOME), abs=1e-9)
    plant.push("tip", [3.0, -2.0, 5.0])
    assert plant.data.qfrc_applied == pytest.approx(moved.jacobian(HOME)[:3].T @ [3.0, -2.0, 5.0], abs=1e-9)


def test_the_motors_end_at_their_efforts_and_the_joints_at_their_limits():
    arm = arms.load("iiwa14")
    plant = Plant(arm)
    plant.reset(HOME)
    plant.step(np.full(7, 1e6))
    assert plant.data.actuator_force == pytest.approx(arm.effort_limit)
    plant = Plant(arm, effort_limits=False)
    plant.reset(HOME)
    plant.step(np.full(7, 1e4))
    assert plant.data.actuator_force == pytest.approx(np.full(7, 1e4))
    plant = Plant(arm, damping=5.0)
    plant.reset(arm.upper - 0.05)
    for _ in range(4000):
        plant.step(plant.bias + 10.0)
    assert (plant.q < arm.upper + 0.05).all()


def test_gravity_alone_keeps_the_arm_where_it_is():
    arm = arms.load("iiwa14")
    plant = Plant(arm)
    plant.reset(HOME)
    record = simulate(plant, TorqueController(arm, []), 0.5)
    assert np.abs(record.q - HOME).max() < 1e-9
    assert np.ptp(record.potential + record.kinetic) < 1e-9


def test_what_is_said_of_a_state_belongs_to_its_angles_and_speeds():
    """Energies of a record, and what the plant says after a step, beside Pinocchio at the same q and v.

    A time step late, energies of this motion of 1.4 J would be off by 0.01 J, and a push by the way of a step.
    """
    arm = arms.load("iiwa14")
    plant, c, data = Plant(arm, damping=0.0), controller(arm), arm.model.createData()
    plant.reset(HOME)
    c.set_posture(HOME + 0.1)
    record = simulate(plant, c, 0.3)
    kinetic = [pin.computeKineticEnergy(arm.model, data, q, v) for q, v in zip(record.q, record.v, strict=True)]
    potential = np.array([pin.computePotentialEnergy(arm.model, data, q) for q in record.q])
    assert max(kinetic) > 0.5
    np.testing.assert_allclose(record.kinetic, kinetic, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(np.diff(record.potential), np.diff(potential), rtol=0.0, atol=1e-9)
    assert plant.energy[1] == pytest.approx(pin.computeKineticEnergy(arm.model, data, plant.q, plant.v), abs=1e-9)
    np.testing.assert_allclose(plant.bias, pin.nonLinearEffects(arm.model, data, plant.q, plant.v), atol=1e-9)
    plant.push("tip", [3.0, -2.0, 5.0])
    np.testing.assert_allclose(plant.data.qfrc_applied, arm.jacobian(plant.q)[:3].T @ [3.0, -2.0, 5.0], atol=1e-9)
    plant.fall_exactly()
    plant.step(np.zeros(7))
    assert plant.energy[1] == pytest.approx(pin.computeKineticEnergy(arm.model, data, plant.q, plant.v), abs=1e-9)


def test_energy_is_what_the_ports_put_in():
    arm = arms.load("iiwa14")
    plant, c = Plant(arm, damping=0.0), controller(arm)
    plant.reset(HOME)
    c.set_posture(HOME + 0.1)
    record = simulate(plant, c, 0.3)
    total = record.kinetic - record.kinetic[0]
    assert record.work == pytest.approx(total, abs=0.002 * total.max())
    assert record.stored[0] > record.stored[-1]


@pytest.mark.slow
@pytest.mark.parametrize(("per_axis", "damping"), [(True, 0.5), (False, 0.5), (False, 0.0)])
def test_pushed_the_arm_comes_back(per_axis, damping):
    arm = arms.load("iiwa14")
    plant, c = Plant(arm, damping=damping), controller(arm, per_axis, limits=True)
    for on in ("tip", "elbow"):
        plant.reset(HOME)
        c.set_posture(HOME)
        record = simulate(plant, c, 2.4, pushes=[Push(on, [0.0, 30.0, 0.0], 0.1, 0.3)])
        away, turned = record.errors(arm.forward_kinematics(HOME).homogeneous)
        assert away.max() > 3e-3
        assert away[-1] < 1e-3
        assert np.rad2deg(turned[-1]) < 0.5


def test_rate_and_delay_are_those_that_were_asked_for():
    arm = arms.load("iiwa14")

    class Watch:
        calls = 0

        def torque(self, q, v):
            self.calls += 1
            return np.full(7, float(self.calls))

    plant, watch = Plant(arm), Watch()
    plant.reset(HOME)
    record = simulate(plant, watch, 0.1, rate=200.0, delay=0.0125)
    assert watch.calls == 20
    assert np.diff(record.t) == pytest.approx(0.005)
    # At 0.1 s, what was asked at 0.085 s has just arrived.
    assert plant.data.ctrl == pytest.approx(np.full(7, 18.0))
    with pytest.raises(srs_ik.InvalidController, match="whole number of time steps"):
        simulate(plant, watch, 0.1, rate=1234.0)
    with pytest.raises(srs_ik.InvalidController, match="delay"):
        simulate(plant, watch, 0.1, delay=-1.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    "make",
    [
        lambda arm: OperationalSpace(arm, inverse="damped"),
        lambda arm: OperationalSpace(arm, inverse="pinv"),
        lambda arm: LinearImpedance(arm, Gains(joints=5.0)),
        lambda arm: JointImpedance(arm),
    ],
)
def test_baselines_reach_their_target(make):
    arm = arms.load("iiwa14")
    plant, c = Plant(arm), make(arm)
    plant.reset(HOME)
    T = arm.forward_kinematics(HOME + 0.15)
    c.set_target(T, seed=HOME)
    record = simulate(plant, c, 2.0)
    away, turned = record.errors(T.homogeneous)
    assert away[-1] < 1e-3
    assert np.rad2deg(turned[-1]) < 0.5


@pytest.mark.slow
def test_ten_seconds_at_4_kHz_take_few_times_the_steps_of_the_simulator_alone():
    """About 3 s of a processor whose bare steps take 0.4 s; a ratio holds on any machine (5 to 9 seen)."""
    arm = arms.load("iiwa14")
    plant, c, bare = Plant(arm), controller(arm, False, limits=True, speeds=True), Plant(arm)
    plant.reset(HOME)
    c.set_posture(HOME + 0.1)
    controlled, alone = 0.0, 0.0
    for _ in range(10):
        # Turn by turn, for machines whose speed changes meanwhile.
        begin = time.process_time()
        record = simulate(plant, c, 1.0)
        controlled += time.process_time() - begin
        assert len(record.t) == 4_000
        bare.reset(HOME)
        begin = time.process_time()
        for _ in range(4_000):
            mujoco.mj_step(bare.model, bare.data)
        alone += time.process_time() - begin
    assert controlled < 15.0 * alone
    # Static: within 0.1 mm of the target.
    assert record.errors(arm.forward_kinematics(HOME + 0.1).homogeneous)[0][-1] < 1e-4


def test_pushes_that_overlap_add_up():
    arm = arms.load("iiwa14")
    there = [Push("tip", [0.0, 30.0, 0.0], 0.0, 0.02), Push("elbow", [0.0, 0.0, 20.0], 0.0, 0.02)]

    def ends(*pushes):
        plant = Plant(arm, damping=0.5)
        plant.reset(HOME)
        return simulate(plant, TorqueController(arm, []), 0.02, pushes=pushes).v[-1]

    rest, both = ends(), ends(*there)
    alone = [ends(push) - rest for push in there]
    # After so short a time, speeds are those of the forces one by one, but for what these have moved.
    assert np.linalg.norm(both - rest - sum(alone)) < 0.01 * min(map(np.linalg.norm, alone))
    twice = ends(there[0], Push("tip", [0.0, 0.0, 0.0], 0.01, 0.005))
    np.testing.assert_allclose(twice, alone[0] + rest, rtol=1e-12, atol=1e-12)


def test_an_unstable_motion_is_an_error_and_not_another_beginning():
    class Wild:
        def torque(self, q, v):
            return 1e5 * v - 1e5 * q

    plant = Plant(arms.load("iiwa14"), effort_limits=False, joint_limits=False, damping=0.0)
    plant.reset(HOME)
    with pytest.raises(srs_ik.InvalidController, match=r"unstable at .* s.*time steps shorter than 0.00025 s"):
        simulate(plant, Wild(), 0.2)
    plant.reset(HOME)
    with pytest.raises(srs_ik.InvalidController, match="unstable"):
        plant.step(np.full(7, 1e30))
    plant.reset(HOME)
    plant.step(np.zeros(7))


def test_a_simulation_has_one_time_step_at_least():
    plant = Plant(arms.load("iiwa14"))
    assert len(simulate(plant, TorqueController(plant.arm, []), 2e-4).t) == 1
    with pytest.raises(srs_ik.InvalidController, match=r"1 to 1,000,000,000 time steps of 0\.00025 s, not 0\.4"):
        simulate(plant, TorqueController(plant.arm, []), 1e-4)


@pytest.mark.parametrize("side", ["lower", "upper"])
def test_a_joint_with_one_limit_ends_there(side):
    sign = 1.0 if side == "upper" else -1.0
    limits = {"lower": -np.inf, "upper": np.inf, side: sign * 0.2}
    arm = srs_ik.load("iiwa14", limits={"iiwa_joint_1": limits})
    plant = Plant(arm, damping=0.5)
    plant.reset(HOME)
    for _ in range(4000):
        plant.step(sign * np.array([20.0, 0, 0, 0, 0, 0, 0]))
    assert sign * plant.q[0] == pytest.approx(0.2, abs=0.02)


@pytest.mark.parametrize("make", [OperationalSpace, LinearImpedance, JointImpedance])
def test_baselines_take_the_short_way_round(make):
    arm = srs_ik.load("gen3")
    baseline, v = make(arm), np.full(7, 0.1)
    baseline.set_posture([3.0, 0.4, -3.0, 1.2, 0.2, -0.6, 0.3])
    q = np.array([-3.0, 0.3, 3.0, 1.0, 0.2, -0.5, 0.3])
    turns = np.array([1, 0, -1, 0, 2, 0, -3])
    torque = baseline.torque(q, v)
    np.testing.assert_allclose(baseline.torque(q + 2.0 * np.pi * turns, v), torque, atol=1e-9)


@pytest.mark.parametrize("rate", [4000.0, 1000.0])
@pytest.mark.parametrize("name", ["iiwa14", "gen3"])
def test_usual_brakes_take_energy_out_of_every_joint(name, rate):
    # The same effort limit for all joints, as in files whose figures are those of no motor.
    arm = arms.load(name).with_limits(velocity=np.full(7, 2.0), effort=np.full(7, 200.0))
    plant = Plant(arm, damping=0.0, friction=0.0)
    plant.reset(HOME, 1.5 * arm.velocity_limit)
    record = simulate(plant, TorqueController(arm, [], speeds=True), 0.5, rate=rate)
    assert np.diff(record.kinetic).max() < 1e-3 * record.kinetic[0]
    assert record.kinetic[-1] < 0.7 * record.kinetic[0]
    assert np.abs(record.v[-1]).max() < 0.9 * 3.0


def test_a_simulation_warns_of_brakes_that_act_too_long():
    arm = arms.load("iiwa14")
    plant, braked = Plant(arm), TorqueController(arm, [], speeds=JointSpeeds(rate=4000.0))
    with pytest.warns(UserWarning, match="brake on joint 'iiwa_joint_7' may drive it"):
        simulate(plant, braked, 0.01, rate=1000.0)
    with pytest.warns(UserWarning, match="brake on joint 'iiwa_joint_7' may drive it"):
        simulate(plant, braked, 0.01, delay=1e-3)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        simulate(plant, braked, 0.01)
