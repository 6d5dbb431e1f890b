"""Scenes, spheres and maps that are made to use up time, to read what they must not, or that are damaged."""

import json
import os
import random
import time

import arms
import numpy as np
import pytest

import srs_ik
from srs_ik import InvalidMap, InvalidRobot, InvalidScene, Scene
from srs_ik.collision.links.sphere_files import read_spheres

BOMB = 'a: &a ["x","x","x","x","x","x","x","x","x"]\n' + "".join(
    f"{name}: &{name} [{','.join([f'*{before}'] * 9)}]\n" for before, name in zip("abcdefgh", "bcdefghi", strict=True)
)
"""Lines of YAML that stand for 4e8 values."""


def one(**figures) -> str:
    return json.dumps({"objects": [{"name": "a", **figures}]})


SCENES = {
    "aliases.yaml": BOMB + "objects: *i\n",
    "aliases as a size.yaml": BOMB + "objects: [{name: a, box: *i}]\n",
    "aliases as a radius.yaml": BOMB + "objects: [{name: a, sphere: *i}]\n",
    "aliases as a margin.yaml": BOMB + "margin: *i\nobjects: []\n",
    "itself.yaml": "objects: &a [*a]\n",
    "itself as a name.yaml": "objects: [&a {name: *a, sphere: 1}]\n",
    "a program.yaml": 'objects: !!python/object/apply:os.mkdir ["pwned"]\n',
    "deep.yaml": "objects: " + "[" * 5000,
    "no date.yaml": "objects: [{name: 2020-99-99, sphere: 1}]\n",
    "sixty.yaml": "objects: [{name: a, sphere: 1:" + "59:" * 5000 + "1}]\n",
    "large.yaml": "objects: []\n#" + "x" * 2**18,
    "deep.json": '{"objects": ' + "[" * 100_000,
    "many.json": json.dumps({"objects": [{"name": str(k), "sphere": 1} for k in range(10_001)]}),
    "long number.json": '{"objects": [{"name": "a", "sphere": 1' + "0" * 9000 + "}]}",
    "no number.json": one(sphere=float("nan")),
    "bytes.json": b"\xff\xfe\x00",
    "scale.json": one(mesh="a.stl", scale="big"),
    "scale of names.json": one(mesh="a.stl", scale={"a": 1}),
    "nul.json": one(mesh="a\0.stl"),
    "nul of points.json": one(points="a\0.csv"),
    "pipe.json": one(points="pipe.csv"),
    "pipe of a mesh.json": one(mesh="pipe.stl"),
    "device.json": one(points="/dev/zero"),
    "other file.json": one(points="/etc/passwd"),
    "pickled.json": one(points="pickled.npy"),
    "huge.json": one(points="huge.npy"),
    "empty.json": one(points="empty.csv"),
}


@pytest.mark.slow
@pytest.mark.parametrize("case", SCENES)
def test_hostile_scenes_are_refused_in_one_line_and_in_time(case, tmp_path, monkeypatch):
    if case.endswith(".yaml"):
        pytest.importorskip("yaml")
    monkeypatch.chdir(tmp_path)
    for name in ("pipe.csv", "pipe.stl"):
        os.mkfifo(tmp_path / name)
    np.save(tmp_path / "pickled.npy", np.array([{}], dtype=object), allow_pickle=True)
    np.save(tmp_path / "huge.npy", np.zeros((3, 3)))
    content = (tmp_path / "huge.npy").read_bytes()
    (tmp_path / "huge.npy").write_bytes(content.replace(b"(3, 3), }            ", b"(300000000000, 3), } "))
    (tmp_path / "empty.csv").touch()
    text = SCENES[case]
    file = tmp_path / case
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    begin = time.process_time()
    with pytest.raises((InvalidScene, InvalidRobot)) as caught:
        Scene.from_file(file)
    assert time.process_time() - begin < 5.0
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 600
    assert not (tmp_path / "pwned").exists()


@pytest.mark.slow
@pytest.mark.parametrize(
    "text",
    [
        BOMB + "collision_spheres: {l: [*i]}\n",
        BOMB + "collision_spheres: {l: [{center: *i, radius: 1}]}\n",
        "collision_spheres: &a {collision_spheres: *a}\n",
        "collision_spheres: spheres.yaml\n",
        "collision_spheres: /etc/passwd\n",
        'collision_spheres: "a\\0b"\n',
        "collision_spheres: {l: [[x, 1, 2, 3]]}\n",
        "collision_spheres: {l: [[.nan, 1, 2, 3]]}\n",
    ],
    ids=["aliases", "aliases as a centre", "itself", "its own file", "other file", "nul", "text", "no number"],
)
def test_hostile_spheres_are_refused(text, tmp_path):
    pytest.importorskip("yaml")
    file = tmp_path / "spheres.yaml"
    file.write_text(text)
    begin = time.process_time()
    with pytest.raises((InvalidScene, InvalidRobot)) as caught:
        read_spheres(file)
    assert time.process_time() - begin < 5.0
    assert "\n" not in str(caught.value)


def test_a_capsule_thinner_than_a_row_of_spheres_is_convex():
    scene = Scene()
    scene.add_capsule("wire", np.eye(4), 1e-9, 1.0)
    scene.add_capsule("thread", np.eye(4), 1e-320, 1.0)
    assert scene.names == ("wire", "thread")


# Maps


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A small map, and what its questions ask."""
    pytest.importorskip("zarr")
    arm = arms.load("human_arm")
    path = tmp_path_factory.mktemp("hostile") / "map.zarr"
    srs_ik.build_map(arm, 0.2, path, orientations=24)
    configurations = arms.configurations("human_arm", 5, 91)
    poses = np.stack([arm.forward_kinematics(q).homogeneous for q in configurations])
    return arm, path, poses


def ask(arm, path, poses):
    chart = srs_ik.open_map(path, arm)
    repr(chart)
    chart.query(poses)
    chart.share(poses[:, :3, 3])
    chart.mean("width")


SENSELESS = [None, -1, 0, 1.5, 10**9, 10**18, 2**70, "x", [], {}, [1], True, 1e308, "1e9"]


def places(tree, at=()):
    """The way to every value of a JSON tree, of long lists to the first ones."""
    if at:
        yield at
    if isinstance(tree, dict | list):
        for key in list(tree)[:8] if isinstance(tree, dict) else range(min(len(tree), 3)):
            yield from places(tree[key], (*at, key))


def test_senseless_figures_of_a_map_are_refused(whole):
    arm, path, poses = whole
    rng = random.Random(92)
    files = sorted(path.rglob("zarr.json"))
    ways = [(file, at) for file in files for at in places(json.loads(file.read_text()))]
    refused = 0
    for file, at in rng.sample(ways, 60):
        text = file.read_text()
        tree = json.loads(text)
        inner = tree
        for key in at[:-1]:
            inner = inner[key]
        inner[at[-1]] = rng.choice(SENSELESS)
        file.write_text(json.dumps(tree))
        begin = time.process_time()
        try:
            ask(arm, path, poses)
        except InvalidMap as error:
            refused += str(error).count("\n") == 0
        finally:
            file.write_text(text)
        assert time.process_time() - begin < 5.0
    assert refused > 20
    ask(arm, path, poses)


@pytest.mark.parametrize("how", ["short", "empty", "other"])
def test_damaged_cells_of_a_map_are_an_error_of_the_package(whole, how):
    arm, path, poses = whole
    (file,) = (each for each in (path / "width").rglob("*") if each.is_file() and each.name != "zarr.json")
    content = file.read_bytes()
    file.write_bytes({"short": content[: len(content) // 2], "empty": b"", "other": b"\x5a" * 300}[how])
    try:
        with pytest.raises(InvalidMap, match="is damaged: files are lost or changed; making the map again"):
            ask(arm, path, poses)
    finally:
        file.write_bytes(content)
