"""Obstacles without a volume: sheets, lines and points, as meshes."""

import numpy as np
import pytest
from oracles import distance

import srs_ik

FLAT = {
    "wall": ([[0.0, 0.3, 0.0], [1.0, 0.3, 0.0], [1.0, 0.3, 1.0], [0.0, 0.3, 1.0]], [[0, 1, 2], [0, 2, 3]]),
    "triangle": ([[0.0, 0.3, 0.0], [1.0, 0.3, 0.0], [1.0, 0.3, 1.0]], [[0, 1, 2]]),
    "line": ([[0.0, 0.3, 0.0], [1.0, 0.3, 0.0], [0.5, 0.3, 0.0]], [[0, 1, 2]]),
    "point": ([[0.0, 0.3, 0.0]] * 3, [[0, 1, 2]]),
}


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize("name", FLAT)
def test_flat_meshes_stand_in_the_way_as_thin_boxes_do(name, exact):
    corners, faces = FLAT[name]
    arm = srs_ik.load("iiwa14")
    pose = arm.forward_kinematics([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    flat, boxed = srs_ik.Scene(exact=exact), srs_ik.Scene(exact=exact)
    flat.add_triangles("flat", np.eye(4), corners, faces)
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    if exact and name != "triangle":
        boxed.add_box("flat", srs_ik.pose_from_xyz_rpy(0.5 * (low + high), [0, 0, 0]), np.maximum(high - low, 1e-5))
        free, expected = (arm.intervals(pose, scene=scene) for scene in (flat, boxed))
        assert sum(i.width for i in free) == pytest.approx(sum(i.width for i in expected), rel=0.02)
    found = arm.solve(pose, scene=flat)
    assert found
    assert max(distance(pose, arm.forward_kinematics(found.q))) < 1e-9
