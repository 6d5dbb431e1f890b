"""Continuous joint paths through many poses."""
