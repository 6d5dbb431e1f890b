"""`srs-ik map` makes, describes, checks, draws and exports maps; wrong input is one line."""

import json
import shutil

import numpy as np
import pytest
from command_line import Q, answer, run

import srs_ik
from srs_ik.maps import open_map

pytest.importorskip("zarr")

GRID = ("--step", "0.2", "--orientations", "72")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("maps") / "map.zarr"
    made = run("map", "make", "iiwa14", "--out", str(path), *GRID)
    assert made.exit_code == 0, made.stderr
    assert "100 % done" in made.stdout
    return str(path)


def test_info_says_what_the_map_holds(folder):
    said = answer("map", "info", folder)
    assert said["cells"] == 5 * 10 * 72
    assert said["done"] == 1.0
    assert said["reached"] == pytest.approx((open_map(folder).measure("reached") > 0).mean())
    assert "half-plane, 5 x 10 positions" in run("map", "info", folder).stdout


def test_making_it_again_changes_nothing_and_another_robot_is_refused(folder):
    assert run("map", "make", "iiwa14", "--out", folder, *GRID).exit_code == 0
    other = run("map", "make", "human_arm", "--out", folder, *GRID)
    assert other.exit_code == 2
    assert "map of another robot (iiwa14" in other.stderr


def test_query_verify_and_estimate(folder, tmp_path):
    poses = tmp_path / "poses.csv"
    poses.write_text("x,y,z,roll,pitch,yaw\n0.4,0.2,0.5,0.1,1.2,0.3\n5,5,5,0,0,0\n")
    found = run("map", "query", folder, str(poses), "--exact", "iiwa14", "--json")
    assert found.exit_code == 1
    arm = srs_ik.load("iiwa14")
    T = srs_ik.pose_from_xyz_rpy([0.4, 0.2, 0.5], [0.1, 1.2, 0.3])
    rows = json.loads(found.stdout)
    assert [row["reached"] for row in rows] == [1.0, 0.0]
    assert rows[0]["width"] == pytest.approx(sum(i.width for i in arm.intervals(T)), rel=1e-6)
    assert run("map", "query", folder, str(poses)).exit_code == 1
    for words in (("--lock", "rail:=0.2"), ("--scene", str(poses)), ("--xacro-arg", "arm:=left")):
        ignored = run("map", "query", folder, str(poses), *words)
        assert ignored.exit_code == 2
        assert "for the arm of --exact" in ignored.stderr
    checked = answer("map", "verify", folder, "iiwa14", "--count", "200")
    assert checked["right"]
    assert checked["cells"] == 200
    assert answer("map", "estimate", "iiwa14", *GRID)["cells"] == 3600


@pytest.mark.slow
def test_export_plot_and_preview(folder, tmp_path):
    for name in ("m.npz", "m.vti", "m.h5"):
        assert run("map", "export", folder, str(tmp_path / name)).exit_code == 0
        assert (tmp_path / name).stat().st_size > 1000
    with np.load(tmp_path / "m.npz") as arrays:
        assert arrays["reached"].shape == (5, 10, 72)
    assert run("map", "plot", folder, "--output", str(tmp_path / "m.png")).exit_code == 0
    assert run("map", "plot", folder, "--shell", "--out", str(tmp_path / "s.png")).exit_code == 0
    assert (tmp_path / "s.png").stat().st_size > 5000
    page = tmp_path / "m.html"
    shown = run("map", "preview", folder, "iiwa14", "--save", str(page))
    assert shown.exit_code == 0, shown.stderr
    assert "points" in shown.stdout
    assert page.stat().st_size > 100_000


@pytest.mark.slow
def test_a_scene_and_a_task_bring_their_measures(tmp_path):
    scene = tmp_path / "scene.json"
    scene.write_text(json.dumps({"objects": [{"name": "shelf", "box": [0.6, 0.1, 1.0], "xyz": [0.5, 0.35, 0.5]}]}))
    path = str(tmp_path / "box.zarr")
    box = ("--step", "0.2", "--orientations", "12", "--bounds", "0.3", "0.7", "-0.2", "0.2", "0.3", "0.5")
    task = ("--velocity", "1", "0", "0", "--force", "0", "0", "-1")
    made = run("map", "make", "iiwa14", "--out", path, *box, "--scene", str(scene), *task)
    assert made.exit_code == 0, made.stderr
    chart = open_map(path)
    free, ratio = chart.measure("free"), chart.measure("ratio")
    assert 0 < (free > 0).sum() < free.size
    assert 0 < (ratio > 0).sum() < ratio.size
    assert answer("map", "verify", path, "iiwa14", "--count", "20", "--scene", str(scene))["right"]
    without = run("map", "verify", path, "iiwa14")
    assert without.exit_code == 2
    assert "scene of the map" in without.stderr
    assert run("map", "plot", path, "--measure", "ratio", "--output", str(tmp_path / "r.png")).exit_code == 0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("make", "iiwa14", "--out", "x.zarr", "--orientations", "13"), "12 x 4^k x rolls"),
        (("make", "iiwa14", "--out", "x.zarr", "--step", "0"), "step of a map"),
        (("make", "iiwa14", "--out", "x.zarr", "--measure", "margins"), "did you mean 'margin'"),
        (("make", "iiwa14", "--out", "x.zarr", "--velocity", "1", "0", "0", "--box"), "give both"),
        (("make", "iiwa14", "--out", "x.zarr", "--velocity", "1", "0", "0", "--force", "0", "0", "1"), "map a box"),
        (("make", "iiwa14", "--out", "x.zarr", "--bounds", "0", "1"), "--bounds takes 6 numbers"),
        (("info", "nowhere.zarr"), "holds no map"),
        (("export", "nowhere.zarr", "m.txt"), ".npz, .vti or .h5"),
    ],
)
def test_wrong_input_is_one_line(words, said):
    found = run("map", *words)
    assert found.exit_code == 2
    assert said in found.stderr
    assert len(found.stderr.splitlines()) == 1


@pytest.mark.slow
def test_two_maps_are_compared_and_combined(tmp_path):
    box = ("--bounds", "-0.4", "0.4", "-0.4", "0.4", "0.2", "0.8")
    paths = [str(tmp_path / name) for name in ("a.zarr", "b.zarr")]
    for robot, path in zip(("iiwa14", "human_arm"), paths, strict=True):
        assert run("map", "make", robot, "--out", path, *GRID, *box).exit_code == 0
    a, b = (open_map(path).measure("reached") > 0 for path in paths)
    said = answer("map", "compare", *paths)
    assert said["first"] == pytest.approx((a & ~b).mean())
    both = str(tmp_path / "both.zarr")
    assert run("map", "combine", *paths, "--out", both).exit_code == 0
    np.testing.assert_array_equal(open_map(both).measure("reached") > 0, a | b)


@pytest.mark.slow
def test_a_map_of_an_arm_with_a_tool_and_a_mount_is_asked_with_its_adapter(tmp_path):
    adapter = tmp_path / "welder.toml"
    adapter.write_text(
        f'name = "welder"\nurdf = "{srs_ik.load("iiwa14").drawing.file}"\n'
        '[frames]\nbase = "iiwa_link_0"\ntip = "iiwa_link_ee"\n'
        '[tool]\nxyz = [0.0, 0.0, 0.1]\n[mount]\nxyz = [0.0, 0.0, 0.7]\nname = "table"\n'
    )
    path, poses = str(tmp_path / "welder.zarr"), tmp_path / "poses.csv"
    assert run("fk", str(adapter), "--q", *Q, "--out", str(poses)).exit_code == 0
    assert run("map", "make", str(adapter), "--out", path, "--step", "0.3", "--orientations", "12").exit_code == 0
    assert answer("map", "verify", path, str(adapter), "--count", "50")["right"]
    assert answer("map", "query", path, str(poses), "--exact", str(adapter))[0]["reached"] == 1
    page = tmp_path / "welder.html"
    assert run("map", "preview", path, str(adapter), "--save", str(page)).exit_code == 0
    other = run("map", "verify", path, "gen3")
    assert other.exit_code == 2
    assert "is a map of welder, base table, tip tool: gen3 has no such frames" in other.stderr


def test_counts_are_whole_numbers(folder, tmp_path):
    poses = tmp_path / "poses.csv"
    poses.write_text("x,y,z,roll,pitch,yaw\n" + 41 * "0.5,0.1,0.6,0,1.5707963,0\n")
    said = answer("map", "query", folder, str(poses))
    assert [type(said[0][name]) for name in ("reached", "branches", "pieces", "width")] == [int, int, int, float]
    lines = run("map", "query", folder, str(poses)).stdout.splitlines()
    assert lines[2].split()[:4] == ["2", "1", str(said[0]["branches"]), str(said[0]["pieces"])]
    assert lines[-1] == "1 lines are not shown"


def test_a_map_that_has_lost_files_is_told_and_mended(folder, tmp_path):
    path, poses = tmp_path / "map.zarr", tmp_path / "poses.csv"
    shutil.copytree(folder, path)
    poses.write_text("x,y,z,roll,pitch,yaw\n0.5,0.1,0.6,0,1.5707963,0\n")
    assert run("map", "query", str(path), str(poses)).exit_code == 0
    shutil.rmtree(path / "reached" / "c")
    for words in (("query", str(path), str(poses)), ("info", str(path))):
        said = run("map", *words)
        assert said.exit_code == 2
        assert f"{path} is damaged: files are lost or changed" in said.stderr
    said = run("map", "verify", str(path), "iiwa14")
    assert said.exit_code == 1
    assert "the same 'srs-ik map make' mends it" in said.stderr
    with pytest.warns(UserWarning, match="tasks that were done are damaged, and made again"):
        assert run("map", "make", "iiwa14", "--out", str(path), *GRID).exit_code == 0
    assert run("map", "query", str(path), str(poses)).exit_code == 0
    assert run("map", "verify", str(path), "iiwa14").exit_code == 0
    shutil.rmtree(path / "done" / "c")
    assert answer("map", "info", str(path))["reached"] == 0.0


def test_what_is_left_to_make_is_said(tmp_path):
    def stop(done, total):
        if done < total:
            raise KeyboardInterrupt

    path, poses = tmp_path / "half.zarr", tmp_path / "poses.csv"
    with pytest.raises(KeyboardInterrupt):
        srs_ik.build_map(srs_ik.load("iiwa14"), 0.1, path, orientations=12, box=True, threads=1, progress=stop)
    poses.write_text("x,y,z,roll,pitch,yaw\n0.5,0.1,0.6,0,1.5707963,0\n")
    assert "left to make count as not reached" in run("map", "info", str(path)).stdout
    asked = run("map", "query", str(path), str(poses))
    assert asked.exit_code == 1
    assert f"{path} is {100 * open_map(path).done:.0f} % done" in asked.stderr
