"""Postures for a task: the plane of the arm laid into that of velocity and force."""
