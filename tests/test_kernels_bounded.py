"""Steps between bounds, against SciPy's bounded least squares."""

import numpy as np
import pytest
from numba import njit
from scipy.optimize import lsq_linear

from srs_ik.kernels.layout.track import SETTINGS, SPEED
from srs_ik.kernels.track.closest import bounded_step


@njit
def step(C, e, wish, box, J, A):
    return bounded_step(C, e, wish, box, (J, A))


def cost(J, e, d, liked, damping, care):
    return ((J @ d - e) ** 2).sum() + damping * (d**2).sum() + care * ((d - liked) ** 2).sum()


@pytest.mark.parametrize("damping", [0.0, 0.1])
def test_a_bounded_step_is_the_best_within_its_bounds(damping):
    """With joints that were held once for all, steps were not, and a goal went around in circles."""
    rng = np.random.default_rng(4)
    C = np.zeros(SETTINGS)
    C[SPEED : SPEED + 7] = 1.0
    care, eye = 1e-6, np.eye(7)
    for k in range(600):
        J, e, liked = rng.normal(size=(6, 7)), 0.3 * rng.normal(size=6), 0.05 * rng.normal(size=7)
        if k % 2:
            # Two joints that do almost the same.
            J[:, 2] = J[:, 0] + 1e-3 * J[:, 2]
        low, high = -rng.uniform(0.0, 0.1, 7), rng.uniform(0.0, 0.1, 7)
        # Joints on a limit.
        low[rng.uniform(size=7) < 0.3] = 0.0
        found = np.array(
            step(C, tuple(e), (tuple(liked), damping, care), (tuple(low), tuple(high)), J.copy(), np.zeros((16, 9)))
        )
        assert (found >= low).all()
        assert (found <= high).all()
        rows = np.vstack([J, np.sqrt(damping) * eye, np.sqrt(care) * eye])
        best = lsq_linear(rows, np.concatenate([e, np.zeros(7), np.sqrt(care) * liked]), (low - 1e-15, high + 1e-15))
        of_best = cost(J, e, best.x, liked, damping, care)
        assert cost(J, e, found, liked, damping, care) < of_best * (1.0 + 1e-6) + 1e-12
