"""What a torque controller is made of: impedances on points and turns of the arm, repelling joint limits, brakes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from srs_ik.analysis.inertia import least_inertias
from srs_ik.arm import Arm
from srs_ik.control.profile import ForceProfile, Law, checked_law
from srs_ik.errors import InvalidController, quoted, warn_caller
from srs_ik.inputs.control import flag, not_negative, one_of, positive, seven_positive, thing
from srs_ik.kernels.layout import control as at
from srs_ik.system.arrays import Array

Place = Literal["tip", "orientation", "elbow", "arm_angle"]

SHARE = 0.6
"""Part of the damping that a period allows a joint by itself. Joints whose axes come into line share an inertia: all
seven together come to 1.6 at most of the 2 beyond which brakes put energy in (28,000 configurations of 7 arms)."""

_KINDS = {"tip": at.TIP, "orientation": at.ORIENTATION, "elbow": at.ELBOW, "arm_angle": at.ARM_ANGLE}


@dataclass(frozen=True)
class FractalImpedance:
    """A Fractal Impedance Controller at one place of the arm: a spring on the way out, a harmonic on the way back.

    While the error grows, the force is that of the profile. From its peak e_M on, it follows a law of convergence that
    accelerates over the first half of the way and brakes over the second one, so that what was stored is spent on
    arrival. Law A: F(e_M)/e_M (2 e - e_M); law B: U(e_M)/(e_M/2)^2 (e - e_M/2), clipped at the largest force; "spring":
    F(e) both ways, which is a bare spring and no fractal impedance.

    Attributes:
        on: "tip" (its point, m), "orientation" (of the tip, rad), "elbow" (its centre, m) or "arm_angle" (rad).
        profile: force against distance, N on points and N m on turns.
        law: "A", "B" or "spring".
        per_axis: whether the law acts along the base axes, as published. Else, the radial form, it acts along axes that
            the motion chooses, the same in every frame: towards the target on the way out; on the way back along the
            error at its last peak, and along the velocity there. A turn is its rotation vector in base axes.
        damping: N s/m or N m s/rad, against the velocity of the place; none as published.
        switch: speed (m/s, rad/s) at which the error has to shrink to count as shrinking, by the velocity of the place;
            0.01 m/s as published. In a tick whose target has moved the size of the error itself decides; "error" for
            that in every tick, where no velocity is to be trusted: it tells the turning point one period late.
        may_inject: whether a profile and law that inject energy are let through, for comparison.

    Raises:
        InvalidController: an unknown place or law, figures that are none, or a law that injects energy.
    """

    on: Place
    profile: ForceProfile
    law: Law = "A"
    per_axis: bool = False
    damping: float = 0.0
    switch: float | Literal["error"] = 0.0
    may_inject: bool = False

    def __post_init__(self) -> None:
        one_of(self.on, _KINDS, "an impedance is on")
        flag(self.per_axis, "per_axis")
        check_law(self.profile, self.law, flag(self.may_inject, "may_inject"))
        not_negative(self.damping, "damping")
        if not (isinstance(self.switch, str) and self.switch == "error"):
            not_negative(self.switch, "speed of the switch")

    def row(self) -> Array:
        """(PORT,) the port as kernels read it, its target still empty."""
        port = self.profile.row(self.law, float(self.damping))
        port[at.KIND], port[at.PER_AXIS] = _KINDS[self.on], float(self.per_axis or self.on == "arm_angle")
        port[at.SWITCH] = -1.0 if self.switch == "error" else float(self.switch)
        return port


@dataclass(frozen=True)
class JointLimits:
    """Impedances that push every joint out of a zone before its limits: saturation as a force, not as a cut.

    Attributes:
        margin: width of the zone, rad; at most a quarter of the joint's range.
        profile: torque against depth in the zone.
        law: see `FractalImpedance`.
        damping: N m s/rad, within the zones alone.

    Raises:
        InvalidController: no margin, or a law that is not passive with its profile.
    """

    margin: float = 0.1
    profile: ForceProfile = field(default_factory=lambda: ForceProfile.tanh(300.0, 40.0))
    law: Law = "A"
    damping: float = 0.0

    def __post_init__(self) -> None:
        positive(self.margin, "margin")
        check_law(self.profile, self.law, False)
        not_negative(self.damping, "damping")

    def rows(self, lower: Array, upper: Array) -> list[Array]:
        """A port for each joint with limits, (PORT,) each."""
        rows = []
        for joint in range(7):
            if not (np.isfinite(lower[joint]) or np.isfinite(upper[joint])):
                continue
            margin = min(self.margin, 0.25 * (upper[joint] - lower[joint]))
            port = self.profile.row(self.law, float(self.damping))
            port[at.KIND], port[at.JOINT], port[at.PER_AXIS] = at.JOINT_LIMIT, joint, 1.0
            port[at.TARGET : at.TARGET + 2] = lower[joint] + margin, upper[joint] - margin
            rows.append(port)
        return rows


@dataclass(frozen=True)
class JointSpeeds:
    """Brakes on joints that are too fast: they take energy out alone, and nothing below the speed where they begin.

    A brake that acts on for too long drives its joint: with the period T (s), damping T has to stay below the least
    inertia of the joint, kg m^2. A damping beyond this gets a warning.

    Attributes:
        begin: speed, rad/s, at which each brake begins, one or (7,); None for the velocity limits of the arm.
        damping: torque over the speed beyond, N m s/rad, one or (7,); None for a twentieth of the arm's effort limits
            per rad/s, or where that is less, 0.6 of what the period allows.
        largest: torque of a brake, N m, one or (7,); None for the arm's effort limits.
        rate: how often torques are asked at least, Hz.

    Raises:
        InvalidController: a figure that is none; or, when a controller is made, a limit that the arm does not have, or
            no inertias that tell the damping.
    """

    begin: ArrayLike | None = None
    damping: ArrayLike | None = None
    largest: ArrayLike | None = None
    rate: float = 1000.0

    def __post_init__(self) -> None:
        for name in ("begin", "damping", "largest"):
            if getattr(self, name) is not None:
                seven_positive(getattr(self, name), f"{name} of the joint speeds")
        positive(self.rate, "rate of the joint speeds")

    def rows(self, arm: Arm) -> list[Array]:
        """A port for each joint, (PORT,) each."""
        begin = self._figures("begin", arm.velocity_limit, "velocity limits")
        largest = self._figures("largest", arm.effort_limit, "effort limits")
        least = least_inertias(arm)
        damping = self._damping(arm, least)
        _warn_of_period(arm, damping, least, 1.0 / self.rate)
        rows = []
        for joint in range(7):
            port = ForceProfile.saturated(damping[joint], largest[joint]).row()
            port[at.KIND], port[at.JOINT], port[at.PER_AXIS] = at.JOINT_SPEED, joint, 1.0
            port[at.TARGET] = begin[joint]
            rows.append(port)
        return rows

    def warn_of_period(self, arm: Arm, period: float) -> None:
        """Warn of brakes that may drive their joint where a torque acts until a period, s, after the speed was read."""
        least = least_inertias(arm)
        _warn_of_period(arm, self._damping(arm, least), least, period)

    def _damping(self, arm: Arm, least: Array) -> list[float]:
        """N m s/rad of each joint, of the least inertia of each, kg m^2."""
        if self.damping is None and not least.all():
            raise InvalidController(
                f"the description of {quoted(arm.name)} has no inertias that tell it: name damping of the joint speeds"
            )
        usual = np.minimum(0.05 * arm.effort_limit, SHARE * self.rate * least)
        return self._figures("damping", usual, "effort limits")

    def _figures(self, name: str, own: Array, what: str) -> list[float]:
        given = getattr(self, name)
        values = own if given is None else seven_positive(given, name)
        if not np.isfinite(values).all():
            raise InvalidController(f"the arm has no {what} on all joints: name {name} of the joint speeds")
        return [float(value) for value in values]


def _warn_of_period(arm: Arm, damping: list[float], least: Array, period: float) -> None:
    spent = np.array(damping) * period
    joint = int((spent - least).argmax())
    if spent[joint] > least[joint] > 0.0:
        warn_caller(
            f"the brake on joint {arm.joint_names[joint]!r} may drive it: at its damping of {damping[joint]:.3g} "
            f"N m s/rad a torque may act {1e3 * least[joint] / damping[joint]:.3g} ms, not {1e3 * period:.3g}: "
            "name a smaller damping, or the rate, of the joint speeds"
        )


def check_law(profile: ForceProfile, law: str, may_inject: bool) -> None:
    """Raise InvalidController for an unknown law, and for one that injects energy with this profile."""
    thing(profile, ForceProfile, "profile", "ForceProfile.tanh")
    checked_law(law)
    share = 0.0 if may_inject else profile.injection(law)  # type: ignore[arg-type]
    if share > 0.0:
        reason = (
            "its force over distance grows with the distance"
            if law == "A"
            else "its parabola gives back more than the profile took"
        )
        raise InvalidController(
            f"law {law} is not passive with a {profile.shape} profile: {reason}, and a reversal injects up to "
            f"{100.0 * share:.3g} % of the stored energy; take a tanh profile with law A, or allow it: may_inject=True"
        )
