"""The loop: a controller that samples the plant, acts late, and is pushed."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from srs_ik.arm import Arm
from srs_ik.control.impedance import JointSpeeds
from srs_ik.errors import InvalidController, quoted
from srs_ik.inputs.control import called, count, not_negative, one_of, positive, thing, things, torques, vector
from srs_ik.robot.limb import Vector
from srs_ik.sim.plant import PLACES, Plant
from srs_ik.sim.record import Record

ALIKE = 0.01
"""Lengths of upper arm and forearm, m, by which a controller's model of an arm may be off."""

MOST_STEPS = 1_000_000_000
"""Time steps of a simulation: days of computing."""


class Controller(Protocol):
    """Anything that makes torques of joint angles and speeds."""

    def torque(self, q: Vector, v: Vector) -> Vector:
        """(7,) N m."""


class Push(NamedTuple):
    """A force for a while."""

    on: str
    """ "tip" or "elbow"."""
    force: ArrayLike
    """(3,) N, base axes."""
    start: float
    """s, from the beginning of the simulation."""
    duration: float
    """s."""


def simulate(
    plant: Plant,
    controller: Controller,
    duration: float,
    *,
    rate: float = 4000.0,
    delay: float = 0.0,
    pushes: Sequence[Push] = (),
    target: Callable[[float], None] | None = None,
    every: int = 1,
    stop: Callable[[Plant], bool] | None = None,
) -> Record:
    """Run a controller on a plant from where that is. Brakes that are too strong for rate and delay get a warning.

    Args:
        plant: where the motion begins; afterwards, where it has ended.
        controller: asked once a period.
        duration: s.
        rate: how often the controller is asked, Hz; a period is a whole number of time steps.
        delay: from a sample to the torque that follows from it, s; rounded to time steps.
        pushes: forces on tip or elbow that begin before the simulation ends; those that act at one time add up.
        target: called before each tick with the time, to move the controller's target.
        every: record one of so many ticks.
        stop: ends the motion where it is true, asked once a tick.

    Raises:
        InvalidController: a thing of another class, a rate, delay or duration that is none, a period that is no whole
            number of time steps, a push that begins before or after the simulation, a controller of another arm or
            whose torques are not 7 finite figures, or a motion that is unstable.
    """
    dt = thing(plant, Plant, "plant").timestep
    pushes = _checked(pushes, positive(duration, "duration"))
    every, rate, delay = count(every, "every"), positive(rate, "rate"), not_negative(delay, "delay")
    if not callable(getattr(controller, "torque", None)):
        raise InvalidController(f"the controller has to have a function torque(q, v), unlike {quoted(controller)}")
    _refuse_other_arm(plant.arm, getattr(controller, "arm", None))
    for function, what in ((target, "target"), (stop, "stop")):
        if function is not None:
            called(function, what)
    steps = duration / dt
    period = round(1.0 / (rate * dt))
    if period < 1 or abs(period * dt * rate - 1.0) > 1e-6:
        raise InvalidController(f"a period is a whole number of time steps of {dt:g} s, unlike that of {rate:g} Hz")
    if not 0.5 < steps <= MOST_STEPS:
        raise InvalidController(f"a simulation has 1 to {MOST_STEPS:,} time steps of {dt:g} s, not {steps:.3g}")
    brakes = getattr(controller, "speeds", None)
    if isinstance(brakes, JointSpeeds):
        brakes.warn_of_period(plant.arm, 1.0 / rate + delay)
    log = _Log(plant, controller, math.ceil(steps / (period * every)))
    # Torques on their way, each with the step at which it arrives.
    coming: deque[tuple[int, Vector]] = deque()
    late, torque = round(delay / dt), np.zeros(7)
    begin, acting = plant.data.time, False
    for k in range(round(steps)):
        t = plant.data.time - begin
        if k % period == 0:
            if target is not None:
                target(t)
            asked = torques(controller.torque(plant.q, plant.v))
            coming.append((k + late, asked))
            if k % (period * every) == 0:
                log.note(t, asked)
            if stop is not None and stop(plant):
                break
        while coming and coming[0][0] <= k:
            torque = coming.popleft()[1]
        if pushes:
            acting = _press(plant, pushes, t, acting)
        plant.step(torque)
    return log.record()


def _refuse_other_arm(arm: Arm, other: Any) -> None:
    """Raise InvalidController where a controller has an arm with other joints or lengths than the plant's."""
    if not isinstance(other, Arm):
        return
    off = max(abs(arm.limb.upper_arm - other.limb.upper_arm), abs(arm.limb.forearm - other.limb.forearm))
    if arm.joint_names != other.joint_names or off > ALIKE:
        raise InvalidController(
            f"the plant is {quoted(arm.name)} and the controller is of {quoted(other.name)}, another robot"
        )


def _checked(pushes: Any, duration: float) -> tuple[Push, ...]:
    """The pushes of a simulation; raises InvalidController where one never begins, or a figure in it is none."""
    found = things(pushes, Push, "pushes")
    for push in found:
        one_of(push.on, PLACES, "a push is on")
        vector(push.force, "force of a push")
        if not_negative(push.start, "start of a push") >= duration:
            raise InvalidController(f"a push begins at {push.start:g} s, when the simulation of {duration:g} s is over")
        not_negative(push.duration, "duration of a push")
    return found


def _press(plant: Plant, pushes: Sequence[Push], t: float, acting: bool) -> bool:
    """Apply the pushes of a moment; whether there are any, as there were (`acting`) in the last one."""
    now = [(push.on, push.force) for push in pushes if push.start <= t < push.start + push.duration]
    if now or acting:
        plant.push_all(now)
    return bool(now)


class _Log:
    """Rows of a record while it is made."""

    def __init__(self, plant: Plant, controller: Any, rows: int) -> None:
        self._plant, self._controller = plant, controller
        self._ported = hasattr(controller, "gravity_torque")
        self._n = 0
        self._table = np.zeros((rows, 35))

    def note(self, t: float, torque: Vector) -> None:
        """One sample."""
        plant, row = self._plant, self._table[self._n]
        row[0] = t
        row[1:8], row[8:15], row[15:22] = plant.q, plant.v, torque
        if self._ported:
            row[22:29] = self._controller.gravity_torque
            row[31] = self._controller.energy
        row[29:31] = plant.data.energy
        if plant.data.ncon:
            row[32:35] = plant.contact_force()
        self._n += 1

    def record(self) -> Record:
        """All samples."""
        columns = np.split(self._table[: self._n], [1, 8, 15, 22, 29, 30, 31, 32], axis=1)
        t, q, v, torque, weight, potential, kinetic, stored, contact = (np.ascontiguousarray(c) for c in columns)
        energies = potential[:, 0], kinetic[:, 0], stored[:, 0]
        return Record(self._plant.arm, t[:, 0], q, v, torque, weight, *energies, contact, self._plant.world)
