"""A scene in the preview: objects where they are, bodies in the colour of their clearance, arcs of forbidden angles."""

import json

import numpy as np
import pytest
from browser import chromium, settled
from collision_oracle import clearance
from command_line import run
from scene import Scene as Drawn

import srs_ik
from srs_ik.preview import Preview, palette
from srs_ik.preview.surroundings import AMPLE, colour_of, forbidden

Q = np.array([0.3, 0.7, -0.4, -1.2, 0.5, 0.8, -0.2])


@pytest.fixture(scope="module")
def arm():
    return srs_ik.load("iiwa14")


@pytest.fixture
def scene(arm):
    made = srs_ik.Scene()
    made.add_box("table", srs_ik.pose_from_xyz_rpy([0.6, 0.0, 0.1], [0, 0, 0.3]), [0.6, 0.8, 0.05])
    made.add_sphere("lamp", arm.joint_frames(Q)[4, :3, 3] + [0.0, 0.17, 0.05], 0.06)
    made.add_points("dust", np.array([[0.4, -0.5, 0.6], [0.4, -0.6, 0.6]]), 0.01)
    made.add_half_space("floor", [0, 0, 0], [0, 0, 1])
    return made


@pytest.mark.slow
def test_objects_are_drawn_where_they_are(arm, scene):
    with Preview(arm) as view:
        view.show(Q)
        view.show_scene(scene)
        drawn = Drawn(view)
        assert drawn.names("scene") >= {"table", "lamp", "dust"}
        (table,) = drawn.vertices("scene/table")
        T = srs_ik.pose_from_xyz_rpy([0.6, 0.0, 0.1], [0, 0, 0.3]).homogeneous
        local = (table - T[:3, 3]) @ T[:3, :3]
        assert np.allclose(np.abs(local), [0.3, 0.4, 0.025], atol=1e-5)
        view.clear()
        assert not drawn.names() & {"scene", "bodies"} or not drawn.names("scene")


def test_bodies_have_the_colour_of_their_clearance(arm, scene):
    assert colour_of(-1.0) == palette.TOUCHING
    assert colour_of(AMPLE) == pytest.approx(palette.CLEAR)
    assert colour_of(0.5 * AMPLE) == pytest.approx(palette.CLOSE)
    from srs_ik.collision.clearances import clearances

    found = clearances(arm.tables(scene), arm.joint_frames(Q), arm.joint_frames(np.zeros(7)))
    only_balls = srs_ik.Scene()
    only_balls.add_sphere("lamp", arm.joint_frames(Q)[4, :3, 3] + [0.0, 0.17, 0.05], 0.06)
    least = clearances(arm.tables(only_balls), arm.joint_frames(Q), arm.joint_frames(np.zeros(7)))
    assert least.min() == pytest.approx(clearance(arm, arm.tables(only_balls), Q), abs=1e-12)
    assert (found[: len(arm.bodies)] <= least[: len(arm.bodies)] + 1e-12).all()


@pytest.mark.slow
def test_forbidden_arcs_and_free_ones_make_up_the_limits(arm, scene):
    T = arm.forward_kinematics(Q)
    all_of_them, free = arm.intervals(T), arm.intervals(T, scene=scene)
    taken = forbidden(all_of_them, free)
    assert taken
    rng = np.random.default_rng(0)
    for each in all_of_them:
        for psi in rng.uniform(each.lower, each.upper, 50):
            is_free = any(i.branch == each.branch and psi in i for i in free)
            is_taken = any(i.branch == each.branch and psi in i for i in taken)
            assert is_free != is_taken
    with Preview(arm) as view:
        view.show(Q)
        assert view.show_intervals(T, scene=scene) == free
        arcs = sum(len(Drawn(view).vertices(f"intervals/branch {b}")) for b in {i.branch for i in (*free, *taken)})
        assert arcs == len(free) + len(taken)


@pytest.mark.slow
def test_the_command_saves_a_page(tmp_path):
    (tmp_path / "scene.json").write_text(
        json.dumps({"objects": [{"name": "lamp", "sphere": 0.1, "xyz": [0.4, 0.4, 0.8]}]})
    )
    page = tmp_path / "scene.html"
    words = [str(x) for x in Q]
    told = run("preview", "iiwa14", "--q", *words, "--scene", str(tmp_path / "scene.json"), "--save", str(page))
    assert told.exit_code == 0, told.stderr
    assert page.stat().st_size > 10_000
    assert run("preview", "iiwa14", "--margin", "0.1").exit_code == 2


@pytest.mark.slow
@pytest.mark.browser
def test_the_picture_shows_red_where_bodies_meet(arm, scene):
    near = srs_ik.Scene()
    near.add_sphere("ball", arm.joint_frames(Q)[4, :3, 3] + [0.0, 0.1, 0.0], 0.08)
    with chromium() as browser, Preview(arm) as view:
        view.show(Q)
        page = browser.new_page(viewport={"width": 560, "height": 460})
        page.goto(view.url)
        view.show_scene(srs_ik.Scene())
        calm = settled(page)
        view.show_scene(near)
        hit = settled(page)
        assert reddish(hit) > reddish(calm) + 0.005


def reddish(picture):
    r, g, b = (picture[..., k].astype(float) for k in range(3))
    return float(((r > 1.6 * g) & (r > 1.6 * b) & (r > 60)).mean())
