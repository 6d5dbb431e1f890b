"""Poses that leave a turn free: the posture nearest to a seed, or farthest from the limits, over all turns."""
