"""The page whose target is dragged: the arm follows through the tracker, the chart and the status say how."""

import re
import time

import numpy as np
import pytest
from browser import PATIENCE, changed, chromium, opened, orange, pixels, until

import srs_ik
from srs_ik import InvalidConfiguration, PreviewError
from srs_ik.preview.live.page import rotation
from srs_ik.preview.robot import reach

Q = np.array([0.3, 0.7, -0.4, -1.2, 0.5, 0.8, -0.2])


@pytest.fixture(scope="module")
def arm():
    pytest.importorskip("viser")
    return srs_ik.load("iiwa14")


@pytest.fixture
def view(arm):
    with srs_ik.preview.FollowingPreview(arm, Q) as view:
        yield view


def wait(condition):
    deadline = time.monotonic() + 1e-3 * PATIENCE
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.02)


def test_the_arm_follows_the_target_within_its_limits(view, arm):
    goal = Q + np.array([0.3, 0.1, -0.2, 0.1, 0.2, -0.1, 0.2])
    seen = []
    view.tracker.update, update = (lambda T: seen.append(update(T)) or seen[-1]), view.tracker.update
    view.show(arm.forward_kinematics(goal))
    wait(lambda: len(seen) > 5 and seen[-1].status == "OK" and max(arm.verify(view.target, seen[-1].q)) < 1e-6)
    assert any(step.status == "LIMITED" for step in seen)
    q = np.array([step.q for step in seen])
    assert (np.abs(np.diff(q, axis=0)) <= arm.velocity_limit * view.tracker.dt + 1e-9).all()
    wait(lambda: "On the target." in view._text.content)
    assert np.abs(np.array(view._chart.data[1:])).max() <= 1.0 + 1e-9


def test_a_closed_page_is_over_and_wrong_input_is_named(arm):
    view = srs_ik.preview.FollowingPreview(arm, Q)
    view.close()
    view.close()
    assert view.closed
    assert not view._thread.is_alive()
    with pytest.raises(PreviewError, match="closed"):
        view.show(np.eye(4))
    with pytest.raises(InvalidConfiguration, match="dt"):
        srs_ik.preview.FollowingPreview(arm, Q, dt=-1.0)


def on_page(view, page, point):
    """Where a point of the base frame is on the page, in pixels, by the camera that viser tells of."""
    camera = next(iter(view._server.get_clients().values())).camera
    x, y, z = rotation(camera.wxyz).T @ (view._stage.R_scene_base @ point - np.asarray(camera.position))
    height, width = page.viewport_size["height"], page.viewport_size["width"]
    scale = 0.5 * height / np.tan(0.5 * camera.fov)
    return np.array([0.5 * width + scale * x / z, 0.5 * height + scale * y / z])


def test_dragging_in_a_browser_moves_the_arm_and_changes_the_status(view):
    with chromium() as browser:
        page = opened(browser, view.url)
        problems = []
        page.on("console", lambda m: problems.append(m.text) if m.type == "error" else None)
        # The panel of a smaller page is in front of the target.
        page.set_viewport_size({"width": 1100, "height": 760})
        page.get_by_text("reconfigure").wait_for()
        page.get_by_text(re.compile("On the target")).wait_for()
        until(page, lambda: orange(pixels(page)) > 0.003)
        first = pixels(page)
        before, q, length = view.target, view.step.q.copy(), 0.3 * reach(view.arm)
        # The handle's arrow along x, and half of its length on.
        start, end = (on_page(view, page, before[:3, 3] + part * length * before[:3, 0]) for part in (0.6, 1.1))
        said = []
        view.tracker.update, update = (lambda T: said.append(update(T)) or said[-1]), view.tracker.update
        page.mouse.move(*start)
        page.wait_for_timeout(500)
        page.mouse.down()
        # At once, faster than the arm may follow.
        page.mouse.move(*(start + 0.1 * (end - start)))
        page.mouse.move(*end)
        page.mouse.up()
        until(page, lambda: np.abs(view.target - before).max() > 0.02)
        until(page, lambda: view.step.status == "OK" and max(view.arm.verify(view.target, view.step.q)) < 1e-6)
        assert np.abs(view.step.q - q).max() > 0.01
        assert {"OK", "LIMITED"} <= {str(step.status) for step in said}
        until(page, lambda: changed(first, pixels(page)) > 0.003)
        asked = []
        view.tracker.reconfigure = asked.append
        page.get_by_role("button", name="reconfigure").click()
        until(page, lambda: asked)
        np.testing.assert_allclose(asked[0], view.target)
        assert problems == []
        assert page.faults == []
        page.close()


def test_the_arm_on_the_page_stops_before_a_scene(arm):
    scene = srs_ik.Scene()
    T = arm.forward_kinematics(Q).homogeneous
    plate = np.eye(4)
    plate[:3, 3] = T[:3, 3] - [0.0, 0.0, 0.25]
    scene.add_box("plate", plate, [0.4, 0.4, 0.04])
    with srs_ik.preview.FollowingPreview(arm, Q, scene=scene) as page:
        assert page._server.scene.get_handle_by_name("/scene/scene/plate/0") is not None
        page.show(plate)
        wait(lambda: page.step.status == "HELD")
        assert page.step.collision.second == "plate"
        assert arm.collision(page.step.q, scene) is None
