"""Closed forms of one S-R-S limb: its triangle, its spherical joints, its branches, its limits."""
