"""Torques by superposition: force profiles, fractal impedances, and the ports through which they act on the arm."""
