"""Objectives, and the search for the best posture."""
