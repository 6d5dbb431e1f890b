"""A few bytes cannot ask for gigabytes: what a preview reads and draws is bounded, and it says what it leaves out."""

import base64
import json
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh
from robot_files import robot_xml, serial_arm

import srs_ik
from srs_ik.meshes import bounds
from srs_ik.meshes.files import MeshFinder, MeshMissing, MeshShelf, read_mesh
from srs_ik.preview import Preview
from srs_ik.preview.robot import look


def arm_with(tmp_path: Path, visuals: str):
    """An arm whose last link has some visuals."""
    text = robot_xml(serial_arm(), links="").replace('<link name="l7"/>', f'<link name="l7">{visuals}</link>')
    (tmp_path / "arm.urdf").write_text(text)
    return srs_ik.load(tmp_path / "arm.urdf")


def visual(inside: str) -> str:
    return f"<visual><geometry>{inside}</geometry></visual>"


def mesh(name: str) -> str:
    return visual(f'<mesh filename="{name}"/>')


def sparse_stl(path: Path, size: int) -> None:
    """An STL of this many bytes, all holes."""
    count = (size - 84) // 50
    with open(path, "wb") as file:
        file.write(bytes(80) + struct.pack("<I", count))
        file.truncate(84 + 50 * count)


@pytest.mark.slow
def test_a_sparse_mesh_of_a_gigabyte_is_not_read(tmp_path):
    sparse_stl(tmp_path / "huge.stl", 10**9)
    arm_with(tmp_path, mesh("huge.stl"))
    code = (
        "import resource, sys, srs_ik; arm = srs_ik.load(sys.argv[1]); from srs_ik.preview.robot import look;"
        "before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss; missing = look(arm).missing;"
        "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before); print(*missing, sep='\\n')"
    )
    command = [sys.executable, "-c", code, str(tmp_path / "arm.urdf")]
    grown, *missing = subprocess.run(
        command, capture_output=True, text=True, check=True, timeout=300
    ).stdout.splitlines()
    assert int(grown) < 20_000  # KiB
    (clause,) = missing
    assert "huge.stl' has 954 MiB, more than the 32 MiB that are read of a mesh" in clause


def test_a_mesh_that_is_named_3000_times_is_read_once(tmp_path, monkeypatch):
    trimesh.creation.icosphere(subdivisions=3).export(tmp_path / "ball.stl")
    read = []
    monkeypatch.setattr(trimesh, "load_scene", lambda *a, load=trimesh.load_scene, **k: read.append(a) or load(*a, **k))
    parts, missing = look(arm_with(tmp_path, 3000 * mesh("ball.stl")))
    assert len(read) == 1
    assert sum(len(part.solid.mesh.faces) for part in parts) == 781 * 1280
    assert missing == ["2219 shapes, the first of link l7: 5,000 shapes with 1,000,000 triangles are drawn of a robot"]


@pytest.mark.slow
def test_no_more_shapes_are_drawn_than_a_browser_takes(tmp_path):
    parts, missing = look(arm_with(tmp_path, 6000 * visual('<box size="0.1 0.1 0.1"/>')))
    assert len(parts) == bounds.PIECES
    assert missing == ["1000 shapes, the first of link l7: 5,000 shapes with 1,000,000 triangles are drawn of a robot"]


def test_all_meshes_together_have_a_bound(tmp_path, monkeypatch):
    monkeypatch.setattr(bounds, "ALL_BYTES", 2500)
    for k in range(4):
        trimesh.creation.box([0.1, 0.1, 0.1]).export(tmp_path / f"{k}.stl")
    assert (tmp_path / "0.stl").stat().st_size == 684
    shelf = MeshShelf(MeshFinder(tmp_path / "arm.urdf"))
    for _ in range(3):
        for k in range(3):
            assert shelf.pieces(f"{k}.stl")
        with pytest.raises(MeshMissing, match="meshes are read in all"):
            shelf.pieces("3.stl")


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    "inside",
    [
        '<box size="1e300 1 1"/>',
        '<sphere radius="2000"/>',
        '<cylinder radius="1" length="1e10"/>',
        '<mesh filename="far.obj"/>',
        '<mesh filename="nan.obj"/>',
        '<mesh filename="box.stl" scale="1e6 1 1"/>',
    ],
)
def test_shapes_that_reach_farther_than_a_robot_are_left_out(tmp_path, inside):
    trimesh.creation.box([0.1, 0.1, 0.1]).export(tmp_path / "box.stl")
    (tmp_path / "far.obj").write_text("v 0 0 0\nv 1e30 0 0\nv 0 1 0\nf 1 2 3\n")
    (tmp_path / "nan.obj").write_text("v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    arm = arm_with(tmp_path, visual(inside))
    parts, missing = look(arm)
    assert len(missing) == 1
    assert missing[0].startswith("l7: ")
    assert max(np.abs(part.solid.mesh.vertices).max() for part in parts) < 10.0
    with Preview(arm) as view:
        assert np.isfinite(view._canvas._extent.sphere()[1])


TRIANGLE = """<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="a" count="9">0 0 0 1 0 0 0 1 0
</float_array><technique_common><accessor source="#a" count="3" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count="1">
<input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles></mesh></geometry></library_geometries>"""


def collada(nodes: str, scene: str, head: str = "", first: str = '<?xml version="1.0"?>') -> str:
    return (
        f'{first}{head}<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">'
        f'<asset><unit meter="1"/><up_axis>Z_UP</up_axis></asset>{TRIANGLE}<library_nodes>{nodes}</library_nodes>'
        f'<library_visual_scenes><visual_scene id="s">{scene}</visual_scene></library_visual_scenes>'
        '<scene><instance_visual_scene url="#s"/></scene></COLLADA>'
    )


SHOWN = '<instance_geometry url="#g"/>'


def doubling(depth: int) -> str:
    twice = (
        f'<node id="n{k}">{2 * f"<instance_node url={chr(34)}#n{k - 1}{chr(34)}/>"}</node>' for k in range(1, depth)
    )
    return f'<node id="n0">{SHOWN}</node>' + "".join(twice)


def test_a_collada_file_that_shows_a_node_again_is_read(tmp_path):
    (tmp_path / "a.dae").write_text(collada(doubling(4), '<node><instance_node url="#n3"/></node>'))
    assert len(read_mesh(tmp_path / "a.dae")) == 8


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (collada(doubling(30), '<node><instance_node url="#n29"/></node>'), "over and over"),
        (
            collada('<node id="n"><instance_node url="#n"/></node>', '<node><instance_node url="#n"/></node>'),
            "over and over",
        ),
        (collada("", f"<node>{SHOWN}</node>" * 6000), "6000 times"),
        (collada("", 300 * "<node>" + SHOWN + 300 * "</node>"), "200 deep"),
        (collada("", f"<node>{SHOWN}</node>", '<!DOCTYPE x [<!ENTITY e SYSTEM "file:///etc/passwd">]>'), "DOCTYPE"),
        (collada("", f"<node>{SHOWN}</node>", first='<?xml version="1.0" encoding="UTF-7"?>'), "UTF-8"),
        (collada("", "<node>"), "cannot be read"),
    ],
    ids=["doubling", "loop", "many", "deep", "entity", "encoding", "cut short"],
)
def test_collada_files_that_ask_for_much_are_refused(tmp_path, text, words):
    (tmp_path / "a.dae").write_text(text)
    with pytest.raises(MeshMissing, match=words):
        read_mesh(tmp_path / "a.dae")


def test_a_collada_file_in_another_encoding_hides_no_entity(tmp_path):
    text = collada(
        "", f"<node>{SHOWN}</node>", '<!DOCTYPE x [<!ENTITY e "1">]>', '<?xml version="1.0" encoding="UTF-16"?>'
    )
    (tmp_path / "a.dae").write_bytes(text.encode("utf-16"))
    with pytest.raises(MeshMissing, match="UTF-8"):
        read_mesh(tmp_path / "a.dae")


def gltf(nodes: list, **changes) -> dict:
    numbers = struct.pack("<9f3H", 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 2)
    return {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": nodes,
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 36},
            {"buffer": 0, "byteOffset": 36, "byteLength": 6},
        ],
        "buffers": [{"byteLength": 42, "uri": f"data:;base64,{base64.b64encode(numbers).decode()}"}],
    } | changes


def test_gltf_files_are_read_but_not_beyond_the_bounds(tmp_path):
    path = tmp_path / "a.gltf"
    path.write_text(json.dumps(gltf([{"mesh": 0}])))
    assert sum(len(piece.faces) for piece, _ in read_mesh(path)) == 1
    zeros = [{"componentType": 5126, "count": 2 * 10**9, "type": "VEC3"}, gltf([])["accessors"][1]]
    with open(tmp_path / "big.bin", "wb") as file:
        file.truncate(10**9)
    outside = [{"byteLength": 42, "uri": "big.bin"}]
    for changes, words in (
        ({"nodes": [{"children": list(range(1, 6000))}, *([{"mesh": 0}] * 5999)]}, "6000 times"),
        ({"accessors": zeros}, "2000000003 points"),
        ({"buffers": outside}, "cannot be read"),
    ):
        path.write_text(json.dumps(gltf([{"mesh": 0}]) | changes))
        with pytest.raises(MeshMissing, match=words):
            read_mesh(path)


def test_pictures_of_meshes_are_not_opened(tmp_path):
    """A picture of 20 kB may hold half a gigabyte; the colour of its material is kept."""
    pytest.importorskip("PIL.Image").new("1", (9000, 9000)).save(tmp_path / "huge.png")
    (tmp_path / "a.mtl").write_text("newmtl m\nKd 1 0 0\nmap_Kd huge.png\n")
    (tmp_path / "a.obj").write_text("mtllib a.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n")
    ((piece, colour),) = read_mesh(tmp_path / "a.obj")
    assert colour == (1.0, 0.0, 0.0, 1.0)
    assert getattr(piece.visual.material, "image", None) is None


def test_a_mesh_that_is_no_file_is_not_waited_for(tmp_path):
    import os

    os.mkfifo(tmp_path / "pipe.stl")
    with pytest.raises(MeshMissing, match="is not found"):
        MeshFinder(tmp_path / "arm.urdf").find("pipe.stl")
