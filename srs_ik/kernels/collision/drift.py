"""How far the bodies of a near limb may be from those of its nearest exact limb: a bound for one pose.

At the same joint angles, the links of both have the same orientation, and are no farther apart than twice the misses of
the axes that carry them: the drift. So the true posture is one of the exact limb whose wrist is off by the drift at
most. That turns its line shoulder-wrist, bends its elbow, and with these moves its links by no more than is summed up
here.
"""

import math

from srs_ik.kernels.algebra.vectors import across, load3, norm, sub
from srs_ik.kernels.jit import kernel
from srs_ik.kernels.layout.collision import DRIFT, REACH_FORE, REACH_UPPER
from srs_ik.kernels.layout.limb import AXES, ELBOW_CENTRE, FAR, FOREARM, NEAR, SHOULDER_CENTRE
from srs_ik.kernels.limb.triangle import elbow_at, elbow_bend, shoulder_to_wrist


@kernel
def bend_between(P, d, other):
    """Difference of the bends at two distances shoulder-wrist, as far as the limb reaches, rad."""
    c, s, _ = elbow_bend(P, d)
    c2, s2, _ = elbow_bend(P, min(max(other, P[NEAR]), P[FAR]))
    return abs(math.atan2(s, c) - math.atan2(s2, c2))


@kernel
def drifted(P, target, slack):
    """How far the links turning with the arm angle may be off, m, and the arm angle, rad: half a turn where by any."""
    drift = slack[DRIFT]
    if drift == 0.0:
        return 0.0, 0.0
    d = norm(shoulder_to_wrist(P, target.R, target.p))
    least = max(d - drift, P[NEAR])
    if drift >= d or least <= 0.0:
        return math.inf, math.pi
    bent = max(bend_between(P, d, d - drift), bend_between(P, d, d + drift))
    forearm = norm(across(load3(P, FOREARM), load3(P, AXES + 9)))
    turned = math.asin(drift / d) + bent * forearm / least
    reach = sub(load3(P, ELBOW_CENTRE), load3(P, SHOULDER_CENTRE))
    upper = norm(reach)
    off = max(slack[REACH_UPPER] * turned, (upper + slack[REACH_FORE]) * turned + slack[REACH_FORE] * bent) + drift
    elbow = upper * turned + drift
    from_line = elbow_from_line(P, target.place)
    return off, (math.asin(elbow / from_line) if elbow < from_line else math.pi)


@kernel
def elbow_from_line(P, place_):
    """Distance of the elbow centre from the line shoulder-wrist, the smaller of both elbows."""
    reach = sub(load3(P, ELBOW_CENTRE), load3(P, SHOULDER_CENTRE))
    least = math.inf
    for elbow in range(2):
        t = elbow_at(P, place_, elbow)[2][0]
        least = min(least, norm(across(reach, t)))
    return least
