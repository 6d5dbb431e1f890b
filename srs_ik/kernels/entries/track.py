"""Entry points: one period of a tracker."""

from srs_ik.kernels.algebra.pointers import row
from srs_ik.kernels.jit import entry
from srs_ik.kernels.layout.answer import GOOD_POSE
from srs_ik.kernels.layout.limb import LIMITED
from srs_ik.kernels.layout.track import BAND, KNOTS, SETTINGS
from srs_ik.kernels.limb.poses import read_pose
from srs_ik.kernels.track.advance import advance


@entry
def update(family, state, settings, T, given, work, out):
    """Take a tracker a period on.

    Args:
        family: (4, SIZE) packed limb.
        state: (STATE,) changed in place.
        settings: (SETTINGS + n,) with the parameters of the elbow's objective behind.
        T: (4, 4) the target, read only if there is one.
        given: 1 with a target, 0 without.
        work: (8, 16, 9) work space.
        out: (STEP,) output.
    """
    R, p, verdict = read_pose(row(T, 0))
    has = given
    if given == 1 and verdict != GOOD_POSE:
        has = -1
    B = work[2:].reshape(-1)[: 7 * KNOTS * (BAND + 2)].reshape((7 * KNOTS, BAND + 2))
    J = work[0].reshape(144)[:42].reshape((6, 7))
    desk = J, work[1], B, settings[SETTINGS:]
    advance(row(family, LIMITED), row(state, 0), settings, (has, R, p), desk, row(out, 0))
