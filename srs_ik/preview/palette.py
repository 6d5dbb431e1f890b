"""The colours of a preview; red, green and blue from 0 to 1."""

from __future__ import annotations

Rgb = tuple[float, float, float]

PLAIN = (0.74, 0.76, 0.79, 1.0)
"""Shapes that have no colour of their own."""

BONE: Rgb = (0.62, 0.65, 0.7)
JOINT: Rgb = (0.25, 0.29, 0.36)
LIMB: Rgb = (0.1, 0.1, 0.12)
GHOST: Rgb = (0.45, 0.62, 0.85)
POSTURE: Rgb = (0.55, 0.2, 0.65)
CIRCLE: Rgb = (0.55, 0.57, 0.6)

OBJECT: Rgb = (0.5, 0.45, 0.38)
TOUCHING: Rgb = (0.85, 0.1, 0.1)
CLOSE: Rgb = (0.95, 0.8, 0.15)
CLEAR: Rgb = (0.2, 0.7, 0.3)
FORBIDDEN: Rgb = (0.2, 0.05, 0.05)
"""Arm angles at which bodies meet."""

VELOCITY: Rgb = (0.1, 0.55, 0.85)
FORCE: Rgb = (0.9, 0.3, 0.2)
GRASP: Rgb = (0.2, 0.65, 0.3)
NORMAL: Rgb = (0.55, 0.3, 0.75)
PLANE: Rgb = (0.75, 0.68, 0.88)

OBSTACLE: Rgb = (0.3, 0.62, 0.42)

BRANCHES: tuple[Rgb, ...] = (
    (0.12, 0.47, 0.71),
    (1.0, 0.5, 0.05),
    (0.17, 0.63, 0.17),
    (0.84, 0.15, 0.16),
    (0.58, 0.4, 0.74),
    (0.55, 0.34, 0.29),
    (0.89, 0.47, 0.76),
    (0.09, 0.75, 0.81),
)
"""One for each branch."""

BACKGROUND_TOP: Rgb = (0.93, 0.95, 0.98)
BACKGROUND_BOTTOM: Rgb = (0.8, 0.83, 0.88)
