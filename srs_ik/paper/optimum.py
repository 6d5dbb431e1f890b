"""The paper's postural optimisation as it is printed: a numerical optimisation over the seven joint angles.

This is the baseline that `Arm.optimise` is measured against, and shares nothing with it but the objective's formula:
kinematics and Jacobian are Pinocchio's, the optimiser is SciPy's SLSQP from many random starts. It finds local
optima, as any such method does; how often they are the global one is a matter of the starts. Nobody should need it to
solve a pose.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from srs_ik.errors import InvalidConfiguration, InvalidTask, quoted
from srs_ik.inputs.angles import as_joint_vector
from srs_ik.inputs.numbers import as_flag, as_positive, real_array
from srs_ik.inputs.poses import PoseLike, as_rigid_matrix
from srs_ik.kinematics import check_arm
from srs_ik.solve.objectives import Objective
from srs_ik.system.arrays import Array

if TYPE_CHECKING:
    from srs_ik.arm import Arm

DEFAULT_LAMBDA = 1e-6
"""The paper's task accuracy, metres and radians."""

MOST_ITERATIONS = 200

PRECISION = 1e-12
"""A step that changes the objective by less ends the optimisation."""

DIFFERENCE = 6e-6
"""Step of the central differences, rad: the cube root of the rounding of a float."""

KEPT = 1.0 + 1e-3
"""A result counts if its pose error is below the accuracy times this: the optimiser keeps constraints to rounding."""


@dataclass(frozen=True, eq=False)
class PrintedOptimum:
    """The best result of all starts.

    Attributes:
        q: (7,) joint angles, rad; where no start kept the constraint, those that came closest.
        value: the objective there, in its own sign and unit.
        second_value: the second objective of a lexicographic one, else None.
        position_error: distance from the pose, metres.
        orientation_error: angle from the pose, rad.
        reached: how many results kept the constraint.
        values: (reached,) value of each of those, best posture first.
    """

    q: Array
    value: float
    second_value: float | None
    position_error: float
    orientation_error: float
    reached: int
    values: Array

    def __bool__(self) -> bool:
        return self.reached > 0


def printed_optimum(
    arm: Arm,
    pose: PoseLike,
    objective: str | Callable[[Array], float] | Objective,
    accuracy: float = DEFAULT_LAMBDA,
    constraint: Literal["pose", "position"] = "pose",
    starts: int | ArrayLike = 20,
    seed: int = 0,
    respect_limits: bool = True,
    **parameters: Any,
) -> PrintedOptimum:
    """Optimise an objective over q, subject to ||K(q) - x_d|| <= lambda, by SciPy from many starts.

    The ball of radius lambda around the pose is replaced by the cube inscribed in it, whose sides are smooth
    constraints; with "pose", position (m) and rotation vector (rad) have a cube each. A lexicographic objective is
    optimised in two stages: the second one under the added constraint that the first stays within the tolerance of its
    best value. (The print writes the second stage as an arg max inside the constraints; which of the two terms comes
    first follows the paper's text.)

    Args:
        arm: the arm.
        pose: wanted pose of the tip frame in the base frame.
        objective: as for `Arm.optimise`.
        accuracy: lambda, metres and radians.
        constraint: whether "pose" or only "position" of the tip is wanted.
        starts: number of random starts, or (n, 7) joint angles to start from, rad.
        seed: of the random starts.
        respect_limits: whether q has to keep the joint limits.
        **parameters: what the objective takes.

    Raises:
        InvalidPose: the pose is no finite rigid transform.
        InvalidTask: a wrong objective or parameter, an accuracy that is not positive, an unknown constraint, no start,
            or a seed that is no whole number, or negative.
        InvalidConfiguration: a given start is not 7 finite angles, or respect_limits no truth value.

    Source: C. Tiseo, S. R. Charitos, M. Mistry, Geometrical Postural Optimisation of 7-DoF Limb-Like Manipulators,
    equations NumOptimisation, NumOptimisationB, TwistOptimisation and WrenchOptimisation.
    """
    check_arm(arm)
    if not isinstance(objective, Objective):
        objective = Objective(objective, **parameters)
    if not (isinstance(constraint, str) and constraint in ("pose", "position")):
        raise InvalidTask(f"constraint must be 'pose' or 'position', not {quoted(constraint)}")
    accuracy = as_positive(accuracy, "accuracy", "metres and radians", InvalidTask)
    respect = as_flag(respect_limits, "respect_limits")
    problem = _Problem(arm, pin.SE3(as_rigid_matrix(pose)), objective, accuracy, constraint == "pose", respect)
    return problem.best(problem.starts(starts, seed))


class _Problem:
    """One pose and one objective, put to SciPy."""

    def __init__(
        self, arm: Arm, target: pin.SE3, objective: Objective, accuracy: float, whole_pose: bool, respect_limits: bool
    ) -> None:
        self.arm = arm
        self.target = target
        self.objective = objective
        self.accuracy = accuracy
        self.whole_pose = whole_pose
        self.bounds = list(zip(arm.lower, arm.upper, strict=True)) if respect_limits else None
        self.sign = -1.0 if objective.maximise else 1.0

    def starts(self, starts: int | ArrayLike, seed: int) -> list[Array]:
        if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
            raise InvalidTask(f"seed must be a whole number from 0, not {quoted(seed)}")
        if isinstance(starts, int | np.integer) and not isinstance(starts, bool):
            if starts < 1:
                raise InvalidTask(f"at least one start is needed, not {starts}")
            limited = np.isfinite(self.arm.lower) & np.isfinite(self.arm.upper)
            lower, upper = np.where(limited, self.arm.lower, -np.pi), np.where(limited, self.arm.upper, np.pi)
            return list(np.random.default_rng(seed).uniform(lower, upper, (int(starts), 7)))
        try:
            given = np.atleast_2d(real_array(starts))
        except (TypeError, ValueError):
            raise InvalidConfiguration(
                f"starts are a number of them or (n, 7) joint angles, not {quoted(starts)}"
            ) from None
        if not given.size:
            raise InvalidTask("at least one start is needed, not an array without any")
        return [as_joint_vector(q, "a start") for q in given]

    def error(self, q: Array) -> Array:
        """(3,) or (6,): position error in base axes, rotation vector from the wanted orientation in tip axes."""
        T_base_tip = self.arm.forward_kinematics(q)
        position = T_base_tip.translation - self.target.translation
        if not self.whole_pose:
            return position
        return np.concatenate([position, pin.log3(self.target.rotation.T @ T_base_tip.rotation)])

    def error_jacobian(self, q: Array) -> Array:
        J = self.arm.jacobian(q)
        if not self.whole_pose:
            return J[:3]
        R = self.arm.forward_kinematics(q).rotation
        return np.vstack([J[:3], pin.Jlog3(self.target.rotation.T @ R) @ R.T @ J[3:]])

    def cube(self) -> dict[str, Any]:
        """The cube inscribed in the ball, as constraints that have to be positive; in units of the accuracy."""
        half = 1.0 / np.sqrt(3.0)
        scale = 1.0 / self.accuracy

        def inside(q: Array) -> Array:
            error = scale * self.error(q)
            return np.concatenate([half - error, half + error])

        def slope(q: Array) -> Array:
            J = scale * self.error_jacobian(q)
            return np.vstack([-J, J])

        return {"type": "ineq", "fun": inside, "jac": slope}

    def minimise(self, function: Callable[[Array], float], q: Array, constraints: Sequence[dict[str, Any]]) -> Array:
        from scipy.optimize import minimize

        result = minimize(
            function,
            q,
            jac=lambda x: _gradient(function, x),
            bounds=self.bounds,
            constraints=constraints,
            method="SLSQP",
            options={"maxiter": MOST_ITERATIONS, "ftol": PRECISION},
        )
        q = np.asarray(result.x)
        return np.clip(q, self.arm.lower, self.arm.upper) if self.bounds else q

    def stage(self, index: int) -> Callable[[Array], float]:
        """First or second objective, to be minimised."""
        sign = self.sign if index == 0 else -self.sign
        return lambda q: sign * self.objective.values(self.arm, q)[index]

    def keeps(self, q: Array) -> bool:
        error = self.error(q)
        return bool(max(np.linalg.norm(error[:3]), np.linalg.norm(error[3:])) <= KEPT * self.accuracy)

    def best(self, starts: Sequence[Array]) -> PrintedOptimum:
        cube = self.cube()
        first, second = self.stage(0), self.stage(1)
        ends = [self.minimise(first, q, [cube]) for q in starts]
        good = [q for q in ends if self.keeps(q)]
        if good and self.objective.second >= 0:
            lowest = min(first(q) for q in good)
            room = self.objective.tolerance * abs(lowest)
            again = [self.minimise(second, q, [cube, _below(first, lowest + room, max(room, PRECISION))]) for q in good]
            limit = lowest + KEPT * room + PRECISION
            good = sorted((q for q in [*good, *again] if self.keeps(q) and first(q) <= limit), key=second)
        else:
            good.sort(key=first)
        q = good[0] if good else min(ends, key=lambda x: float(np.linalg.norm(self.error(x))))
        values = self.objective.values(self.arm, q)
        error = self.arm.verify(self.target, q)
        return PrintedOptimum(
            q=q,
            value=values[0],
            second_value=values[1] if len(values) > 1 else None,
            position_error=error.position,
            orientation_error=error.orientation,
            reached=len(good),
            values=np.array([self.objective.value(self.arm, x) for x in good]),
        )


def _below(function: Callable[[Array], float], limit: float, scale: float) -> dict[str, Any]:
    """A function's upper limit as a constraint that has to be positive."""
    return {
        "type": "ineq",
        "fun": lambda q: (limit - function(q)) / scale,
        "jac": lambda q: -_gradient(function, q) / scale,
    }


def _gradient(function: Callable[[Array], float], q: Array) -> Array:
    """Gradient (7,) by central differences."""
    gradient = np.empty(7)
    for joint in range(7):
        step = np.zeros(7)
        step[joint] = DIFFERENCE
        gradient[joint] = (function(q + step) - function(q - step)) / (2.0 * DIFFERENCE)
    return gradient
