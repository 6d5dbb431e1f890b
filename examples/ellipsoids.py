"""What the tip of an arm can do: ellipsoids and polytopes of velocity and force, and a picture of them.

Run: python examples/ellipsoids.py
"""

import tempfile
from pathlib import Path

import numpy as np

import srs_ik

arm = srs_ik.load("iiwa14")
q = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
J = arm.jacobian(q)

# How fast the tip moves with the joints up to their velocity limits, and how much it holds up to their torque limits.
velocity = srs_ik.velocity_ellipsoid(J, arm.velocity_limit)
force = srs_ik.force_ellipsoid(J, arm.effort_limit)
for ellipsoid in (velocity, force):
    print(f"{ellipsoid.kind}, semi-axes in {ellipsoid.unit} and their directions in the base frame:")
    for radius, axis in zip(ellipsoid.radii, ellipsoid.axes.T, strict=True):
        print(f"  {radius:8.3f}  along {np.round(axis, 3)}")
print(f"straight up: {velocity.radius_along([0, 0, 1]):.3f} m/s, {force.radius_along([0, 0, 1]):.1f} N")
print(f"manipulability {srs_ik.manipulability(J):.4f} m^3, isotropy {srs_ik.analysis.isotropy(J):.3f}")

# The joint velocities behind the first axis, and where Pinocchio says that they take the tip in a microsecond.
rate = arm.velocity_limit**2 * (velocity.axes[:, 0] @ J[:3]) / velocity.radii[0]
step = 1e-6
before, after = (arm.forward_kinematics(q + sign * 0.5 * step * rate).translation for sign in (-1.0, 1.0))
miss = np.linalg.norm(after - before - step * velocity.radii[0] * velocity.axes[:, 0])
print(f"the tip moved by Pinocchio is off by {miss:.1e} m")

# Stretched, the tip cannot move along the arm at all; the structure carries any force there without a torque.
stretched = arm.jacobian([0.3, 0.7, 0.2, 0.0, 0.4, 0.0, -0.2])
print(srs_ik.velocity_ellipsoid(stretched))
print(srs_ik.force_ellipsoid(stretched))

# Polytopes have the corners that the limits really leave, and the weight of the arm (extra "polytopes").
try:
    strong = srs_ik.force_polytope(arm, q)
    up, down = strong.radius_along([0, 0, 1]), strong.radius_along([0, 0, -1])
    print(f"the tip lifts with {up:.0f} N and pushes down with {down:.0f} N, without a force sideways")
    print(f"with one, its upward component reaches {strong.extent_along([0, 0, 1]):.0f} N")
except srs_ik.MissingExtra as missing:
    print(missing)

# A picture, here into a folder that is gone afterwards (extra "plot").
with tempfile.TemporaryDirectory() as folder:
    try:
        picture = Path(folder) / "ellipsoids.png"
        srs_ik.plots.plot_ellipsoids(arm, q, limits=True).savefig(picture)
        print(f"{picture.name}: {picture.stat().st_size} bytes")
    except srs_ik.MissingExtra as missing:
        print(missing)
