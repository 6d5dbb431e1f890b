"""What an object in the hand weighs: mass, centre and inertia of a solid of one density."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin

from srs_ik.collision.forms import Form, surface
from srs_ik.errors import InvalidScene, quoted
from srs_ik.inputs.numbers import real_number
from srs_ik.system import bounds


def inertia_of(form: Form, mass: Any, name: str) -> pin.Inertia:
    """The `pinocchio.Inertia`, in the frame of the form's carrier, of an object of some mass, kg.

    A mesh that does not close counts as its convex hull.

    Raises:
        InvalidScene: the mass is no positive number, or a mesh encloses no volume.
    """
    m = real_number(mass)
    if not 0.0 < m <= bounds.HEAVIEST:
        raise InvalidScene(f"the mass of {quoted(name)} is a positive number, kg, not {quoted(mass)}")
    placement = pin.SE3(form.T[:3, :3].copy(), form.T[:3, 3].copy())
    if form.kind == "box":
        return placement.act(pin.Inertia.FromBox(m, *form.size))
    if form.kind == "sphere":
        return placement.act(pin.Inertia.FromSphere(m, *form.size))
    if form.kind == "cylinder":
        return placement.act(pin.Inertia.FromCylinder(m, *form.size))
    import trimesh
    from scipy.spatial import QhullError

    mesh = trimesh.Trimesh(*surface(form))
    try:
        solid = mesh if mesh.is_volume else mesh.convex_hull
    except (ValueError, QhullError):
        raise InvalidScene(f"{quoted(name)} encloses no volume: what has a mass is a solid") from None
    if not (np.isfinite(solid.mass) and solid.mass > 0.0 and np.isfinite(solid.moment_inertia).all()):
        raise InvalidScene(f"{quoted(name)} encloses no volume: what has a mass is a solid")
    return pin.Inertia(m, np.array(solid.center_mass), np.array(solid.moment_inertia) * (m / solid.mass))
