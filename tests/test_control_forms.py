"""The two forms of a fractal impedance in three dimensions, against the laws written once more."""

import arms
import numpy as np
import pinocchio as pin
import pytest

from srs_ik.control import ForceProfile, FractalImpedance, TorqueController

TIP, TURN = ForceProfile.tanh(1000.0, 60.0), ForceProfile.tanh(60.0, 12.0)


def tanh(stiffness, largest):
    return lambda x: largest * np.tanh(stiffness * x / largest)


class Axis:
    """Law A on one axis, as the papers have it."""

    def __init__(self, peak=None):
        self.peak, self.last = peak or 0.0, peak

    def __call__(self, force, error, velocity):
        size, converging = abs(error), self.last is not None and error * velocity > 0.0
        self.peak = max(size, self.peak) if converging else size
        self.last = size
        pull = force(self.peak) * (2.0 * size / self.peak - 1.0) if converging else force(size)
        return np.copysign(1.0, error) * float(pull)


class Radial:
    """The radial form: axes along the error and the velocity at each peak of the distance."""

    def __init__(self):
        self.phase, self.last = "leaving", None

    def __call__(self, force, error, velocity):
        size = np.linalg.norm(error)
        n = error / size
        growing = self.last is None or n @ velocity <= 0.0
        if growing and self.phase == "back":
            self.phase = "again"
        if not growing and self.phase != "back":
            across = velocity - (n @ velocity) * n
            across /= np.linalg.norm(across)
            self.axes = np.array([n, across, np.cross(n, across)])
            self.laws = [Axis(max(size, self.last)), Axis(), Axis()]
            self.phase = "back"
        self.last = size
        if self.phase == "leaving":
            return n * force(size)
        pulls = zip(self.laws, self.axes @ error, self.axes @ velocity, strict=True)
        return self.axes.T @ [law(force, e, v) for law, e, v in pulls]


class PerAxis:
    def __init__(self):
        self.laws = [Axis(), Axis(), Axis()]

    def __call__(self, force, error, velocity):
        return np.array([law(force, e, v) for law, e, v in zip(self.laws, error, velocity, strict=True)])


@pytest.mark.parametrize(("per_axis", "form"), [(False, Radial), (True, PerAxis)])
def test_the_force_along_a_motion_is_that_of_the_law_written_once_more(per_axis, form):
    arm, rng = arms.load("iiwa14"), arms.generator("iiwa14", 31)
    back = 0
    for _ in range(8):
        target = rng.uniform(-1.0, 1.0, 7)
        c = TorqueController(arm, [FractalImpedance("tip", TIP, per_axis=per_axis)], gravity=False)
        c.set_posture(target)
        place, law = arm.forward_kinematics(target).translation, form()
        swing, rate, phase = rng.uniform(0.05, 0.4, 7), rng.uniform(2.0, 6.0, 7), rng.uniform(0.0, 6.0, 7)
        # The first tick counts the target as one that has moved, for which the size of the error decides.
        for k in range(200):
            t = 0.005 * k
            q, v = target + swing * np.sin(rate * t + phase), swing * rate * np.cos(rate * t + phase)
            tau = c.torque(q, v)
            J = arm.jacobian(q)[:3]
            error = place - arm.forward_kinematics(q).translation
            h = law(tanh(1000.0, 60.0), error, J @ v)
            # A tick on which a rounding error decides between growing and shrinking would compare nothing.
            assert c.readings[0].force == pytest.approx(h, abs=1e-7)
            assert tau == pytest.approx(J.T @ h, abs=1e-6)
            back += bool(c.readings[0].converging[0])
    assert 300 < back < 1300


def test_the_radial_form_is_the_same_in_every_frame():
    arm = arms.load("iiwa14")
    T = np.eye(4)
    T[:3, :3] = pin.rpy.rpyToMatrix(0.4, -0.7, 1.2)
    turned = arm.with_base(T)
    start = np.array([0.1, 0.5, 0.0, -1.2, 0.2, 0.7, 0.0])
    largest = {}
    for per_axis in (False, True):
        ports = [FractalImpedance(on, TIP, per_axis=per_axis) for on in ("tip", "orientation", "elbow")]
        pair = [TorqueController(one, ports, gravity=False, max_torque=1e9) for one in (arm, turned)]
        for c in pair:
            c.set_posture(start)
        largest[per_axis] = 0.0
        for k in range(200):
            q = start + 0.2 * np.sin(0.03 * k + np.arange(7.0))
            v = 0.2 * 30.0 * np.cos(0.03 * k + np.arange(7.0))
            torques = [c.torque(q, v) for c in pair]
            largest[per_axis] = max(largest[per_axis], np.abs(torques[0] - torques[1]).max())
    assert largest[False] < 1e-6
    assert largest[True] > 1.0


def test_new_axes_add_no_energy():
    rng = np.random.default_rng(5)
    for profile in (TIP, ForceProfile.tanh(3.0, 200.0), ForceProfile.saturated(1000.0, 50.0)):
        e = rng.normal(size=(2000, 3)) * 10.0 ** rng.uniform(-4.0, 1.0, (2000, 1))
        along_one = profile.energy(np.linalg.norm(e, axis=1))
        assert (along_one <= profile.energy(np.abs(e)).sum(axis=1) * (1.0 + 1e-9)).all()


def moved(law, mass, error, velocity, seconds, dt=1e-3):
    """Distance of a mass from its target under a law in three dimensions, after some seconds."""
    away, v, inverse = error.copy(), velocity.copy(), np.linalg.inv(mass)
    for _ in range(round(seconds / dt)):
        a = inverse @ law(tanh(1000.0, 60.0), away, v)
        away, v = away - dt * v - 0.5 * dt**2 * a, v + dt * a
    return np.linalg.norm(away)


class Central(Axis):
    """Law A by the distance alone: a force towards the target, which keeps the angular momentum about it."""

    def __call__(self, force, error, velocity):
        size = np.linalg.norm(error)
        return super().__call__(force, size, error @ velocity / size) * error / size


def test_a_mass_that_passes_sideways_comes_to_rest_in_both_forms_and_not_under_a_central_force():
    rng = np.random.default_rng(7)
    ends = {form: [] for form in (PerAxis, Radial, Central)}
    for _ in range(4):
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        mass = turn @ np.diag(rng.uniform(1.0, 8.0, 3)) @ turn.T
        error, velocity = rng.normal(0.0, 0.08, 3), rng.normal(0.0, 0.5, 3)
        for form, found in ends.items():
            found.append(moved(form(), mass, error, velocity, 2.0))
    assert max(ends[PerAxis]) < 1e-3
    assert max(ends[Radial]) < 1e-3
    assert min(ends[Central]) > 1e-3


@pytest.mark.parametrize(("form", "share"), [(PerAxis, 0.03), (Radial, 0.003)])
def test_large_turns_inject_little(form, share):
    # The rate of a rotation vector is not the velocity of the turn, so that the law is passive for small ones alone.
    force, inertia, dt = tanh(60.0, 12.0), 0.01, 5e-4

    def stored(law, error):
        if form is PerAxis:
            return float(TURN.energy(np.abs(error)).sum())
        along = law.axes @ error if law.phase != "leaving" else np.array([np.linalg.norm(error)])
        return float(TURN.energy(np.abs(along)).sum())

    worst, ends, rng = 0.0, [], np.random.default_rng(3)
    for _ in range(4):
        turn = rng.normal(size=3)
        R, velocity, law, first = pin.exp3(turn / np.linalg.norm(turn)), 8.0 * rng.normal(size=3), form(), None
        for _ in range(1000):
            error = pin.log3(R.T)
            h = law(force, error, velocity)
            energy = 0.5 * inertia * velocity @ velocity + stored(law, error)
            first = first or energy
            worst = max(worst, energy / first - 1.0)
            velocity = velocity + dt * h / inertia
            R = pin.exp3(dt * velocity) @ R
        ends.append(np.linalg.norm(error))
    assert worst < share
    assert max(ends) < 1e-3
