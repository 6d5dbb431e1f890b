"""One pose, either kind of limb: a posture, the intervals, the nearest to a seed."""
