"""What makes one posture better than another: the built-in objectives by name, and functions of one's own."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from srs_ik.analysis.gravity import gravity_torque, require_masses, torque_scales
from srs_ik.errors import InvalidTask, did_you_mean, listed, quoted
from srs_ik.inputs.angles import as_joint_vector, refuse_bad_angles
from srs_ik.inputs.numbers import as_flag, real_number, vector_of
from srs_ik.kernels.layout import objectives as kinds
from srs_ik.kernels.layout.limb import SMALLEST_RANGE
from srs_ik.kinematics import check_arm
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.kinematics import ChainKinematics

DEFAULT_TOLERANCE = 0.01
"""Share of the first objective that a lexicographic one gives away for the second."""

LARGEST_TOLERANCE = 1e3

NO_MASSES = "objective 'gravity_torque' needs them"


class _Definition(NamedTuple):
    """A built-in objective."""

    vectors: dict[str, int]
    """Parameters that are directions, and how many entries each has."""
    maximise: bool
    unit: str
    kind: int
    """Number of the kernel that computes it."""
    second: int = -1
    """The kernel that decides among the postures best by the first one."""


_TASK = {"force": 3, "velocity": 3}
_DEFINITIONS = {
    "force_velocity_ratio": _Definition(_TASK, False, "1", kinds.RATIO),
    "force_then_velocity": _Definition(_TASK, False, "m^2", kinds.FORCE, kinds.VELOCITY),
    "velocity_then_force": _Definition(_TASK, True, "m^2", kinds.VELOCITY, kinds.FORCE),
    "twist": _Definition({"twist": 6}, True, "mixed", kinds.TWIST),
    "wrench": _Definition({"wrench": 6}, False, "mixed", kinds.WRENCH),
    "manipulability": _Definition({}, True, "m^3", kinds.MANIPULABILITY),
    "limit_margin": _Definition({}, True, "1", kinds.LIMIT_MARGIN),
    "reference_posture": _Definition({"reference": 7}, False, "rad^2", kinds.REFERENCE),
    "gravity_torque": _Definition({}, False, "1 or (N m)^2", kinds.GRAVITY),
}

OBJECTIVES = tuple(_DEFINITIONS)
"""Names of the built-in objectives."""


CLEARANCE = "clearance"
"""An objective of `Arm.optimise` that is asked of a scene, and not of a posture alone."""


class Objective:
    """What a posture is judged by; given to `Arm.optimise`.

    With J the Jacobian (6, 7) of the tip point in base axes, linear rows first, and Jp its linear rows; f, v, t and w
    are the given directions, scaled to length 1 (a twist or wrench as a vector of six, linear part first, metres and
    radians mixed):

    | name | parameters | value | sense |
    |---|---|---|---|
    | `force_velocity_ratio` | `force`, `velocity` | (f'JpJp'f) / (v'JpJp'v), the paper's C | minimised |
    | `force_then_velocity` | `force`, `velocity`, `tolerance` | f'JpJp'f; then v'JpJp'v, m^2 | minimised; maximised |
    | `velocity_then_force` | `force`, `velocity`, `tolerance` | v'JpJp'v; then f'JpJp'f, m^2 | maximised; minimised |
    | `twist` | `twist` | t'JJ't | maximised |
    | `wrench` | `wrench` | w'JJ'w | minimised |
    | `manipulability` | | sqrt(det JJ'), m^3 | maximised |
    | `limit_margin` | | smallest distance from a limit over half of the joint's range | maximised |
    | `reference_posture` | `reference` | sum of squared differences from seven angles, rad^2 | minimised |
    | `gravity_torque` | | sum of squared gravity torques, relative to the effort limits if all are given | minimised |

    A lexicographic objective takes, among all postures whose first value is within `tolerance` (relative, 0.01 if not
    given) of the best, the one best by the second.

    Args:
        objective: a name, or a function of the seven joint angles (7,), rad, that returns a finite number.
        maximise: whether a function of one's own is to be maximised; built-in objectives know their sense.
        **parameters: those of the table.

    Attributes:
        name: name of the objective, or of the function.
        maximise: whether higher values are better.
        unit: unit of the value; empty for a function.

    Raises:
        InvalidTask: unknown name, missing or unknown parameter, or a vector of wrong shape, not finite, or zero.

    Source: C. Tiseo, S. R. Charitos, M. Mistry, Geometrical Postural Optimisation of 7-DoF Limb-Like Manipulators,
    equations NumOptimisation, NumOptimisationB, TwistOptimisation, WrenchOptimisation and C.
    """

    def __init__(
        self, objective: str | Callable[[Array], float], maximise: bool | None = None, **parameters: Any
    ) -> None:
        self.function: Callable[[Array], float] | None = None
        self.parameters: dict[str, Array] = {}
        self.tolerance = DEFAULT_TOLERANCE
        sense = None if maximise is None else as_flag(maximise, "maximise", InvalidTask)
        if callable(objective):
            if parameters:
                raise InvalidTask(f"an objective of one's own takes no parameter {next(iter(parameters))!r}")
            self.function = objective
            self.name = str(getattr(objective, "__name__", "function"))
            self.maximise = sense or False
            self.unit = ""
            self._definition = None
            return
        definition = _defined(objective)
        if sense is not None and sense != definition.maximise:
            raise InvalidTask(f"objective {objective!r} is always {_sense(definition.maximise)}")
        self.name = objective
        self.maximise = definition.maximise
        self.unit = definition.unit
        self._definition = definition
        if definition.second >= 0:
            self.tolerance = _tolerance(parameters.pop("tolerance", DEFAULT_TOLERANCE))
        self.parameters = _vectors(objective, definition, parameters)

    @property
    def kind(self) -> int | None:
        """Number of the kernel that computes it, if one does."""
        return self._definition.kind if self._definition else None

    @property
    def second(self) -> int:
        """Number of the kernel that decides among the postures best by the first one, or -1."""
        return self._definition.second if self._definition else -1

    def packed(self, arm: ChainKinematics, weights: Array, respect_limits: bool) -> Array:
        """(PARAMS,) parameters as the kernels read them.

        Args:
            arm: the arm.
            weights: its packed masses.
            respect_limits: whether turns have to keep the limits.

        Raises:
            InvalidTask: gravity is asked for, and the arm's description has no masses.
        """
        values = np.zeros(kinds.PARAMS)
        if self.kind == kinds.GRAVITY:
            require_masses(arm, NO_MASSES)
            values[kinds.WEIGHT :] = weights
        flat = np.concatenate([*self.parameters.values(), np.empty(0)])
        values[: flat.size] = flat
        values[kinds.RESPECT] = respect_limits
        return values

    def value(self, arm: ChainKinematics, q: ArrayLike) -> float:
        """Value of a posture of an arm, in the objective's own sign and unit.

        Computed by NumPy and Pinocchio, without the kernels.

        Args:
            arm: the arm.
            q: (7,) joint angles, rad.

        Raises:
            InvalidConfiguration: not 7 finite angles.
            InvalidTask: a function of one's own gave no finite number, or the arm's description has no masses.
        """
        return self.values(arm, q)[0]

    def values(self, arm: ChainKinematics, q: ArrayLike) -> tuple[float, ...]:
        """The value at (7,) joint angles, rad, and that of the second objective of a lexicographic one; see `value`."""
        check_arm(arm)
        q = as_joint_vector(q)
        if self.kind in (None, kinds.LIMIT_MARGIN, kinds.REFERENCE, kinds.GRAVITY):
            return (self.evaluator(arm)(q),)
        J = arm.jacobian(q)
        if self.kind == kinds.MANIPULABILITY:
            return (float(np.prod(np.linalg.svd(J, compute_uv=False))),)
        if self.kind in (kinds.TWIST, kinds.WRENCH):
            (direction,) = self.parameters.values()
            return (float(np.sum((direction @ J) ** 2)),)
        force, velocity = (float(np.sum((self.parameters[name] @ J[:3]) ** 2)) for name in ("force", "velocity"))
        if self.kind == kinds.RATIO:
            return (force / max(velocity, kinds.SMALLEST),)
        return (force, velocity) if self.kind == kinds.FORCE else (velocity, force)

    def evaluator(self, arm: ChainKinematics) -> Callable[[Array], float]:
        """The function of seven joint angles (7,) that computes the value, for objectives that no kernel computes."""
        if self.function is not None:
            return _checked(self.function, self.name)
        if self.name == "limit_margin":
            return lambda q: _limit_margin(arm, q)
        if self.name == "reference_posture":
            reference = self.parameters["reference"]
            return lambda q: float(np.sum((q - reference) ** 2))
        if self.name == "gravity_torque":
            return _squared_torque(arm)
        return lambda q: self.value(arm, q)

    def __repr__(self) -> str:
        return f"<Objective {self.name}, {_sense(self.maximise)}>"


def _defined(name: Any) -> _Definition:
    """The objective of a name; raises InvalidTask where there is none."""
    if not isinstance(name, str):
        raise InvalidTask(
            f"an objective is a name, a function of 7 joint angles or an Objective, not {type(name).__name__}"
        )
    if name == CLEARANCE:
        raise InvalidTask(
            "objective 'clearance' needs a scene, and is given to optimise by its name: "
            "scene=srs_ik.Scene() is the arm alone"
        )
    if name not in _DEFINITIONS:
        raise InvalidTask(
            f"there is no objective {quoted(name)}{did_you_mean(name, OBJECTIVES)}; known are {listed(OBJECTIVES)}"
        )
    return _DEFINITIONS[name]


def _vectors(name: str, definition: _Definition, given: dict[str, Any]) -> dict[str, Array]:
    """The parameters of an objective by their names; raises InvalidTask for one that is missing, unknown or wrong."""
    for parameter in given:
        if parameter not in definition.vectors:
            takes = listed([*definition.vectors, *(["tolerance"] if definition.second >= 0 else [])])
            raise InvalidTask(f"objective {name!r} takes no parameter {parameter!r}; it takes {takes or 'none'}")
    found = {}
    for parameter, size in definition.vectors.items():
        if parameter not in given:
            raise InvalidTask(f"objective {name!r} needs {parameter}=, {size} numbers")
        if parameter == "reference":
            found[parameter] = as_joint_vector(given[parameter], parameter)
            refuse_bad_angles(found[parameter], parameter)
        else:
            found[parameter] = _direction(given[parameter], size, parameter)
    return found


def as_objective(objective: str | Callable[[Array], float] | Objective, parameters: dict[str, Any]) -> Objective:
    """An objective as `Arm.optimise` is given it, with parameters by their names.

    Raises:
        InvalidTask: see `Objective`; or an Objective, which has its parameters already, is given others.
    """
    if not isinstance(objective, Objective):
        return Objective(objective, **parameters)
    if parameters:
        raise InvalidTask(
            f"an Objective has its parameters already; {next(iter(parameters))!r} belongs to its constructor"
        )
    return objective


def _sense(maximise: bool) -> str:
    return "maximised" if maximise else "minimised"


def _tolerance(value: Any) -> float:
    tolerance = real_number(value)
    if not 0.0 <= tolerance <= LARGEST_TOLERANCE:
        raise InvalidTask(f"tolerance must be a number from 0 to {LARGEST_TOLERANCE:g}, not {quoted(value)}")
    return tolerance


def _direction(value: Any, size: int, what: str) -> Array:
    """A vector of any length, scaled to length 1."""
    vector = vector_of(value, size, what, InvalidTask)
    if not np.isfinite(vector).all():
        raise InvalidTask(f"{what} has entries that are not finite numbers")
    largest = np.abs(vector).max()
    if largest == 0.0:
        raise InvalidTask(f"{what} must not be zero: it gives a direction")
    vector /= largest
    return vector / np.linalg.norm(vector)


def _checked(function: Callable[[Array], float], name: str) -> Callable[[Array], float]:
    """The function, with every answer that is not one finite number refused."""

    def checked(q: Array) -> float:
        # What the search goes on with is not the function's to change.
        view = q.view()
        view.flags.writeable = False
        answer = function(view)
        value = real_number(answer)
        if np.isnan(value) and not isinstance(answer, float | np.floating):
            raise InvalidTask(f"objective {name!r} must return a number, not {type(answer).__name__}")
        if not np.isfinite(value):
            raise InvalidTask(
                f"objective {name!r} must return a finite number, not {value} as at q = {q.tolist()}; "
                "where a posture is not allowed, a large one"
            )
        return value

    return checked


def _limit_margin(arm: ChainKinematics, q: Array) -> float:
    limited = np.isfinite(arm.upper) & np.isfinite(arm.lower)
    lower, upper = arm.lower[limited], arm.upper[limited]
    middle, half = 0.5 * (lower + upper), 0.5 * np.maximum(upper - lower, SMALLEST_RANGE)
    return float(np.min(1.0 - np.abs(q[limited] - middle) / half, initial=1.0))


def _squared_torque(arm: ChainKinematics) -> Callable[[Array], float]:
    torque, scales = gravity_torque(arm, NO_MASSES), torque_scales(arm)
    return lambda q: float(np.sum((torque(q) * scales) ** 2))
