"""Force profiles: how hard a controller pulls at a distance, and how much energy it can give back."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from srs_ik.errors import InvalidController
from srs_ik.inputs.control import distances, not_negative, one_of, positive
from srs_ik.kernels.entries import control as entries
from srs_ik.kernels.layout import control as at
from srs_ik.system.arrays import Array

Law = Literal["A", "B", "spring"]
Shape = Literal["tanh", "saturated", "published"]

LAWS: dict[str, float] = {"A": at.LAW_A, "B": at.LAW_B, "spring": at.SPRING}
_SHAPES = {"tanh": at.TANH, "saturated": at.SATURATED, "published": at.PUBLISHED}

_PEAKS = 400
_SIZES = 801
"""Grid of peaks and of errors below each, on which injected energy is sought."""

_STEPS_OF_THE_KNEE = 20.0
"""The published profile rises by one e-fold in this part of the distance between its two errors."""


@dataclass(frozen=True)
class ForceProfile:
    """A force that grows with the distance from the target and never passes a largest one.

    Made by `tanh`, `saturated` or `published`. Units are those of a point (m, N) or of a turn (rad, N m).

    Attributes:
        shape: "tanh", "saturated" or "published".
        stiffness: slope at zero, N/m or N m/rad.
        largest: the force is never larger, N or N m.
        knee: error at which the published profile leaves its spring, m or rad; 0 for the others.
        width: distance over which it rises by one e-fold from there; 0 for the others.
    """

    shape: Shape
    stiffness: float
    largest: float
    knee: float = 0.0
    width: float = 0.0

    def __post_init__(self) -> None:
        one_of(self.shape, _SHAPES, "the shape of a profile is")
        positive(self.stiffness, "stiffness")
        positive(self.largest, "largest force")
        check = positive if self.shape == "published" else not_negative
        check(self.knee, "first error")
        check(self.width, "width")

    @classmethod
    def tanh(cls, stiffness: float, largest: float) -> ForceProfile:
        """A force that saturates smoothly: that of a hyperbolic tangent, which is concave, so that law A is passive.

        Raises:
            InvalidController: a figure is not positive and finite.
        """
        return cls("tanh", positive(stiffness, "stiffness"), positive(largest, "largest force"))

    @classmethod
    def saturated(cls, stiffness: float, largest: float) -> ForceProfile:
        """A linear spring up to its largest force.

        Raises:
            InvalidController: a figure is not positive and finite.
        """
        return cls("saturated", positive(stiffness, "stiffness"), positive(largest, "largest force"))

    @classmethod
    def published(cls, stiffness: float, largest: float, first: float, second: float) -> ForceProfile:
        """The profile of the papers, for comparison: a spring up to `first`, then a rise that is over at `second`.

        F = K e up to e0; beyond, K e0 + (Fmax - K e0) (1 - exp(-(e - e0)/b)) with b = (e_b - e0)/20. Where the largest
        force is above K e0, its force over distance grows behind e0, and law A injects energy.

        Raises:
            InvalidController: a figure is not positive and finite, or the errors are not in order.

        Source: C. Tiseo et al., arXiv 2003.01466 and 2011.00390.
        """
        knee, end = positive(first, "first error"), positive(second, "second error")
        if end <= knee:
            raise InvalidController(f"the second error, {end}, has to be larger than the first, {knee}")
        width = (end - knee) / _STEPS_OF_THE_KNEE
        stiffness, largest = positive(stiffness, "stiffness"), positive(largest, "largest force")
        if largest < stiffness * knee:
            raise InvalidController(
                f"the largest force, {largest}, is below that of the spring at the first error, {stiffness * knee:g}"
            )
        return cls("published", stiffness, largest, knee, width)

    def force(self, error: ArrayLike) -> Array:
        """Force at distances of any shape, N or N m; errors below zero count as zero.

        Raises:
            InvalidController: an error is no finite number.
        """
        return self._values(error)[0]

    def energy(self, error: ArrayLike) -> Array:
        """Energy that it takes to go to distances of any shape, J: the integral of the force.

        Raises:
            InvalidController: an error is no finite number.
        """
        return self._values(error)[1]

    def converging_force(self, peak: float, error: ArrayLike, law: Law = "A") -> Array:
        """Force, N or N m, towards the target at errors, m or rad, that shrink from a peak; negative where it brakes.

        Errors may have any shape.

        Raises:
            InvalidController: peak or error are no finite numbers, or an unknown law.
        """
        sizes = distances(error, "the error")
        forces = np.empty(sizes.size)
        entries.converging_force(self.row(law), not_negative(peak, "peak"), sizes.ravel(), forces)
        return forces.reshape(sizes.shape)

    def injection(self, law: Law = "A") -> float:
        """Largest energy that a law gives back beyond what the profile took, as a share of that at the peak.

        Zero for a passive law. From the peak down to an error x, a law returns the integral of its force from x to the
        peak, and may return U(peak) - U(x); the largest difference over all peaks and x is divided by U(peak).

        Raises:
            InvalidController: an unknown law.
        """
        checked_law(law)
        return 0.0 if law == "spring" else _injection(self, law)

    @property
    def steepest(self) -> float:
        """Steepest slope of the force, N/m or N m/rad: what decides how fast a controller has to be."""
        return max(self.stiffness, (self.largest - self.stiffness * self.knee) / self.width if self.width else 0.0)

    def row(self, law: Law = "A", damping: float = 0.0) -> Array:
        """(PORT,) what kernels read of a port with this profile, its kind and target still empty.

        Raises:
            InvalidController: an unknown law, or no damping.
        """
        port = np.zeros(at.PORT)
        port[at.LAW], port[at.PROFILE], port[at.SWITCH] = LAWS[checked_law(law)], _SHAPES[self.shape], 0.0
        port[at.STIFFNESS], port[at.LARGEST] = self.stiffness, self.largest
        port[at.DAMPING] = not_negative(damping, "damping")
        port[at.KNEE], port[at.WIDTH] = self.knee, self.width
        return port

    def _values(self, error: ArrayLike) -> tuple[Array, Array]:
        sizes = np.maximum(distances(error, "the error"), 0.0)
        forces, energies = np.empty(sizes.size), np.empty(sizes.size)
        entries.profile_values(self.row(), sizes.ravel(), forces, energies)
        return forces.reshape(sizes.shape), energies.reshape(sizes.shape)


@lru_cache(maxsize=256)
def _injection(profile: ForceProfile, law: Law) -> float:
    """See `ForceProfile.injection`."""
    soft = profile.largest / profile.stiffness
    # From far below the first bend of the force to far above the last one; densely around a knee.
    around = profile.knee + profile.width * np.geomspace(0.01, 100.0, _PEAKS) if profile.width else np.empty(0)
    worst = 0.0
    for peak in [*np.geomspace(0.01 * soft, 10.0 * soft, _PEAKS).tolist(), *around.tolist()]:
        sizes = np.linspace(0.0, peak, _SIZES)
        released = _from_the_end(profile.converging_force(peak, sizes, law), sizes[1])
        stored = profile.energy(sizes)
        worst = max(worst, float(np.max(released - (stored[-1] - stored)) / stored[-1]))
    # The rule of the trapezium leaves errors of this size.
    return worst if worst > 1e-4 else 0.0


def _from_the_end(values: Array, step: float) -> Array:
    """Integral of samples from each to the last one."""
    pieces = 0.5 * step * (values[1:] + values[:-1])
    return np.append(np.cumsum(pieces[::-1])[::-1], 0.0)


def checked_law(law: str) -> str:
    """The name of a law of convergence; raises InvalidController for any other."""
    return one_of(law, LAWS, "a law is")
