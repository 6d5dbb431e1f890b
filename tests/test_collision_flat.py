"""Obstacles without a volume: sheets, lines and points, as meshes."""

from pathlib import Path

import numpy as np
import pytest
import trimesh
from oracles import distance

import srs_ik

ROBOTS = Path(__file__).parent.parent / "robots"

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
    # A sheet through the wrist is in the way of all.
    across = srs_ik.Scene(exact=exact)
    across.add_triangles(
        "across", np.eye(4), [[-1, -1, 0.6], [1, -1, 0.6], [1, 1, 0.6], [-1, 1, 0.6]], [[0, 1, 2], [0, 2, 3]]
    )
    assert arm.solve(pose, scene=across).status is srs_ik.Status.COLLISION
    assert max(distance(pose, arm.forward_kinematics(found.q))) < 1e-9


def test_a_link_whose_mesh_is_flat(tmp_path):
    sheet = trimesh.Trimesh([[0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0], [0, 0.1, 0]], [[0, 1, 2], [0, 2, 3]])
    sheet.export(tmp_path / "flat.stl")
    text = (ROBOTS / "iiwa14" / "iiwa14.urdf").read_text()
    start = text.index("<collision", text.index('<link name="iiwa_link_5"'))
    end = text.rindex("</collision>", start, text.index("</link>", start)) + len("</collision>")
    shape = '<collision><geometry><mesh filename="flat.stl"/></geometry></collision>'
    (tmp_path / "flat.urdf").write_text(text[:start] + shape + text[end:])
    arm = srs_ik.load(tmp_path / "flat.urdf")
    pose = arm.forward_kinematics([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
    assert arm.intervals(pose, scene=srs_ik.Scene(exact=True))
    pytest.importorskip("mujoco")
    from srs_ik.sim import Peg, Plant, World

    assert Plant(arm, World(pegs=(Peg([1, 0, 0], [1, 0, 1], 0.02),)))
