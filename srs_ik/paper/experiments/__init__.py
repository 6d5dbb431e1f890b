"""The five experiments of the paper, on its own limb or on any other arm: figures, and a picture of each.

C. Tiseo, S. R. Charitos, M. Mistry, Geometrical Postural Optimisation of 7-DoF Limb-Like Manipulators, section Method
Characterisation. Joint limits play no part, as they play none there.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from srs_ik.paper.experiments.arm_sphere import arm_sphere
from srs_ik.paper.experiments.c_grasp import c_grasp
from srs_ik.paper.experiments.ik_accuracy import ik_accuracy
from srs_ik.paper.experiments.lr_arms import lr_arms
from srs_ik.paper.experiments.walking import walking

if TYPE_CHECKING:
    from srs_ik.arm import Arm
    from srs_ik.paper.experiments.setting import Outcome, Progress

EXPERIMENTS: dict[str, Callable[[Arm, Progress], Outcome]] = {
    "lr-arms": lr_arms,
    "arm-sphere": arm_sphere,
    "ik-accuracy": ik_accuracy,
    "c-grasp": c_grasp,
    "walking": walking,
}
"""The experiments by name, in the order of the paper: functions of an arm and of a function that is told which share is
done. "lr-arms", "arm-sphere" and "ik-accuracy" take `count=` and `seed=`, too. The outcome has `figures` (a mapping),
`draw()`, which makes the picture, and `seed`."""
