"""Meshes are found where robot files mean them, and nowhere else."""

from pathlib import Path

import numpy as np
import pytest
import trimesh
from robot_files import example_urdf, serial_arm
from scene import Scene

import srs_ik
from srs_ik.meshes.files import MeshFinder, MeshMissing, read_mesh
from srs_ik.preview import Preview
from srs_ik.robot import zoo


@pytest.fixture
def package(tmp_path, monkeypatch) -> Path:
    """A package with meshes, its robot file in urdf/, and a mesh beside the package that does not belong to it."""
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    folder = tmp_path / "workspace" / "arm_description"
    (folder / "meshes").mkdir(parents=True)
    (folder / "urdf").mkdir()
    (folder / "package.xml").write_text("<package><name>arm_description</name></package>")
    for path in (folder / "meshes" / "link.stl", tmp_path / "secret.stl", folder / "urdf" / "own.stl"):
        trimesh.creation.box([0.1, 0.2, 0.3]).export(path)
    return folder


def finder(package: Path, *folders) -> MeshFinder:
    return MeshFinder(package / "urdf" / "arm.urdf", folders)


@pytest.mark.parametrize(
    "name",
    [
        "package://arm_description/meshes/link.stl",
        "package://arm_description/meshes/../meshes/link.stl",
        "file:///package://arm_description/meshes/link.stl",
        "model://arm_description/meshes/link.stl",
        "../meshes/link.stl",
    ],
)
def test_a_mesh_of_the_own_package_is_found(package, name):
    assert finder(package).find(name) == package / "meshes" / "link.stl"


def test_absolute_paths_are_found_inside_the_package(package):
    path = package / "meshes" / "link.stl"
    assert finder(package).find(str(path)) == path
    assert finder(package).find(path.as_uri()) == path


@pytest.mark.parametrize(
    "name",
    [
        "package://arm_description/../../secret.stl",
        "package://../secret.stl",
        "package://arm_description//{root}/secret.stl",
        "../../../secret.stl",
        "{root}/secret.stl",
        "file://{root}/secret.stl",
        "file://elsewhere/secret.stl",
        "http://127.0.0.1/secret.stl",
    ],
)
def test_a_mesh_outside_is_refused_though_it_is_there(package, tmp_path, name):
    name = name.format(root=tmp_path)
    with pytest.raises(MeshMissing) as refused:
        finder(package).find(name)
    assert "\n" not in str(refused.value)
    if "{root}/secret" in name:
        assert finder(package, tmp_path).find(name)


def test_a_given_folder_opens_it(package, tmp_path):
    assert finder(package, tmp_path).find(str(tmp_path / "secret.stl")) == tmp_path / "secret.stl"
    assert finder(package, tmp_path).find("../../../secret.stl") == tmp_path / "secret.stl"


def test_without_a_package_file_the_own_folder_is_all(package):
    (package / "package.xml").unlink()
    assert finder(package).find("own.stl") == package / "urdf" / "own.stl"
    with pytest.raises(MeshMissing, match="not inside"):
        finder(package).find("../meshes/link.stl")


def test_only_meshes_are_opened(package):
    (package / "meshes" / "notes.txt").write_text("x")
    for name in ("package://arm_description/meshes/notes.txt", "package://arm_description/package.xml"):
        with pytest.raises(MeshMissing, match="none of"):
            finder(package).find(name)


def test_packages_are_found_by_the_paths_of_ros_and_ament(package, tmp_path, monkeypatch):
    name = "package://arm_description/meshes/link.stl"
    urdf = tmp_path / "elsewhere" / "arm.urdf"
    with pytest.raises(MeshMissing, match="not found"):
        MeshFinder(urdf).find(name)
    for entry in (package, package.parent):
        monkeypatch.setenv("ROS_PACKAGE_PATH", f"/no/such:{entry}")
        assert MeshFinder(urdf).find(name) == package / "meshes" / "link.stl"
    monkeypatch.delenv("ROS_PACKAGE_PATH")
    (tmp_path / "prefix").mkdir()
    package.parent.rename(tmp_path / "prefix" / "share")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "prefix"))
    assert MeshFinder(urdf).find(name).is_file()


def test_given_folders_may_be_packages_or_hold_them(package):
    name = "package://arm_description/meshes/link.stl"
    for folder in (package, package.parent, str(package.parent)):
        assert MeshFinder(None, [folder]).find(name) == package / "meshes" / "link.stl"


def test_a_damaged_mesh_is_missing(tmp_path):
    for ending in ("stl", "obj", "dae", "ply", "glb"):
        path = tmp_path / f"broken.{ending}"
        path.write_bytes(b"\x00 no mesh \xff" * 9)
        with pytest.raises(MeshMissing):
            read_mesh(path)


@pytest.mark.parametrize("library", ["red.mtl", "../red.mtl", "{folder}/red.mtl"])
def test_materials_are_read_beside_a_mesh_and_nowhere_else(tmp_path, library):
    folder = tmp_path / "meshes"
    folder.mkdir()
    for place in (tmp_path, folder):
        (place / "red.mtl").write_text("newmtl red\nKd 1 0 0\n")
    path = folder / "box.obj"
    path.write_text(f"mtllib {library.format(folder=tmp_path)}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n")
    ((_, rgba),) = read_mesh(path)
    assert (rgba is not None and rgba[:3] == (1.0, 0.0, 0.0)) == (library == "red.mtl")


def test_collada_files_are_read_in_their_own_unit(tmp_path):
    pytest.importorskip("collada")
    path = tmp_path / "box.dae"
    trimesh.creation.box([100.0, 200.0, 300.0]).export(path)
    text = path.read_text()
    assert "<unit" not in text or "meter=" in text
    asset = "<asset>" if "<asset>" in text else "<asset/>"
    path.write_text(text.replace(asset, '<asset><unit name="millimeter" meter="0.001"/>', 1))
    (piece,) = [mesh for mesh, _ in read_mesh(path)]
    assert np.abs(np.sort(piece.extents) - [0.1, 0.2, 0.3]).max() < 1e-9


def with_mesh(filename: str, collision: str = "") -> str:
    visual = f'<visual><geometry><mesh filename="{filename}" scale="2 1 1"/></geometry></visual>'
    return f'<robot name="arm">{serial_arm()}</robot>'.replace(
        '<link name="l4"/>', f'<link name="l4">{visual}{collision}</link>'
    )


def test_a_mesh_is_drawn_where_its_link_is(package):
    urdf = package / "urdf" / "arm.urdf"
    urdf.write_text(with_mesh("package://arm_description/meshes/link.stl"))
    arm = srs_ik.load(urdf)
    q = np.linspace(0.1, 0.7, 7)
    with Preview(arm) as view:
        view.show(q)
        assert view.missing == []
        (points,) = Scene(view).solids("robot")
    # The frames of this robot's links are those of its joints.
    T = arm.joint_frames(q)[4]
    local = (points - T[:3, 3]) @ T[:3, :3]
    assert np.abs(np.ptp(local, axis=0) - [0.2, 0.2, 0.3]).max() < 1e-6


def test_a_missing_mesh_is_said_and_its_collision_shape_drawn(package):
    urdf = package / "urdf" / "arm.urdf"
    urdf.write_text(
        with_mesh(
            "package://arm_description/meshes/gone.stl",
            '<collision><geometry><sphere radius="0.05"/></geometry></collision>',
        )
    )
    with Preview(srs_ik.load(urdf)) as view:
        assert len(view.missing) == 1
        assert "l4" in view.missing[0]
        assert "gone.stl" in view.missing[0]
        (points,) = Scene(view).solids("robot")
        assert np.abs(np.ptp(points, axis=0) - 0.1).max() < 1e-3


def test_without_any_shape_there_is_a_skeleton(package):
    urdf = package / "urdf" / "arm.urdf"
    urdf.write_text(with_mesh("../../../secret.stl"))
    with Preview(srs_ik.load(urdf)) as view:
        assert "not inside" in view.missing[0]
        assert len(Scene(view).solids("robot")) > 7


def test_folders_are_one_or_several_and_there(package, tmp_path):
    urdf = package / "urdf" / "arm.urdf"
    urdf.write_text(with_mesh("package://models/link.stl"))
    (tmp_path / "models").mkdir()
    trimesh.creation.box([0.1, 0.2, 0.3]).export(tmp_path / "models" / "link.stl")
    arm = srs_ik.load(urdf)
    for folders in (str(tmp_path / "models"), tmp_path / "models", [str(tmp_path / "models")]):
        with Preview(arm, package_dirs=folders) as view:
            assert view.missing == []
        assert arm.with_bodies(folders).plan.folders == (str(tmp_path / "models"),)
    for wrong in ("/nope", ["/nope"], [str(tmp_path), urdf]):
        for take in (arm.with_bodies, lambda folders: Preview(arm, package_dirs=folders)):
            with pytest.raises(
                srs_ik.InvalidRobot, match=r"there is no folder '.*(nope|arm\.urdf)' to search for meshes"
            ):
                take(wrong)
    for wrong in (7, [7], None):
        with pytest.raises(srs_ik.InvalidRobot, match="a path or a list of paths, not "):
            arm.with_bodies(wrong)


def test_faulty_shapes_are_left_out_and_said():
    shapes = (
        '<visual><geometry><box size="1 2"/></geometry></visual>'
        '<visual><geometry><cylinder radius="-1" length="1"/></geometry></visual>'
        "<visual><geometry/></visual><visual/>"
        '<visual><origin xyz="0 0 nan"/><geometry><sphere radius="1"/></geometry></visual>'
        '<visual><geometry><box size="0.1 0.1 0.1"/></geometry></visual>'
    )
    text = f'<robot name="arm">{serial_arm()}</robot>'.replace('<link name="l4"/>', f'<link name="l4">{shapes}</link>')
    with Preview(srs_ik.load(text)) as view:
        assert view.missing == ["5 shapes have no size or an unknown form"]
        assert len(Scene(view).solids("robot")) == 1


@pytest.mark.slow
def test_a_yourdfpy_robot_is_drawn_like_its_file():
    yourdfpy = pytest.importorskip("yourdfpy")
    path = str(zoo.card("iiwa14").urdf)
    drawn = []
    for source in (path, yourdfpy.URDF.load(path, load_meshes=False)):
        with Preview(srs_ik.load(source, base="iiwa_link_0", tip="iiwa_link_ee")) as view:
            drawn.append(np.concatenate(Scene(view).solids("robot")))
    assert np.abs(drawn[0] - drawn[1]).max() < 1e-5


@pytest.mark.slow
def test_the_meshes_of_a_real_robot_are_found():
    example_urdf("human")
    with Preview(srs_ik.load("human_left")) as view:
        assert view.missing == []
        assert len(Scene(view).solids("robot")) > 8


def test_a_robot_whose_file_is_gone_is_one_clear_error(tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text(f'<robot name="arm">{serial_arm()}</robot>')
    arm = srs_ik.load(path)
    path.unlink()
    with pytest.raises(srs_ik.InvalidRobot, match="there is no file"):
        Preview(arm)
