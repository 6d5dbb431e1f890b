"""Torque control by superposition, measured: the paper's future work, in MuJoCo and against its rivals (extra 'sim').

Each experiment takes an arm with inertias, and has a short form for tests: a few seeds in place of many.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from srs_ik.paper.experiments.control.contact import contact
from srs_ik.paper.experiments.control.human import human
from srs_ik.paper.experiments.control.law import law
from srs_ik.paper.experiments.control.model import model
from srs_ik.paper.experiments.control.passivity import passivity
from srs_ik.paper.experiments.control.pushes import pushes
from srs_ik.paper.experiments.control.rate import rate
from srs_ik.paper.experiments.control.reaching import reaching
from srs_ik.paper.experiments.control.stretch import stretch
from srs_ik.paper.experiments.control.walking import walking_in_dynamics

if TYPE_CHECKING:
    from srs_ik.paper.experiments.setting import Outcome

CONTROL: dict[str, Callable[..., Outcome]] = {
    "control-model": model,
    "control-law": law,
    "control-passivity": passivity,
    "control-reaching": reaching,
    "control-pushes": pushes,
    "control-contact": contact,
    "control-stretch": stretch,
    "control-rate": rate,
    "control-human": human,
    "control-walking": walking_in_dynamics,
}
"""The experiments by name: functions of an arm, of one that is told the share done, and of whether to be short."""
