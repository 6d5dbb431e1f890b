"""The page whose target is dragged: the arm follows through the tracker, the chart and the status say how."""

import re

import numpy as np
import pytest
from browser import PATIENCE, changed, chromium, opened, pixels, settled, until

import srs_ik
from srs_ik import InvalidConfiguration, PreviewError

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
    import time

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


def centre_of_target(view, page):
    """Where the target is on the page, in pixels, by viser's own camera."""
    client = next(iter(view._server.get_clients().values()))
    camera = client.camera
    T = view._stage.R_scene_base @ view.target[:3, 3]
    from srs_ik.preview.page import rotation

    x, y, z = rotation(camera.wxyz).T @ (T - np.asarray(camera.position))
    height, width = page.viewport_size["height"], page.viewport_size["width"]
    scale = 0.5 * height / np.tan(0.5 * camera.fov)
    return 0.5 * width + scale * x / z, 0.5 * height + scale * y / z


def test_dragging_in_a_browser_moves_the_arm_and_changes_the_status(view, arm):
    with chromium() as browser:
        page = opened(browser, view.url)
        problems = []
        page.on("console", lambda m: problems.append(m.text) if m.type == "error" else None)
        page.get_by_text("reconfigure").wait_for()
        page.get_by_text(re.compile("On the target")).wait_for()
        first = settled(page)
        before = view.target
        until(page, lambda: view._server.get_clients())
        x, y = centre_of_target(view, page)
        statuses = set()
        page.mouse.move(x, y)
        page.mouse.down()
        for k in range(12):
            page.mouse.move(x + 6.0 * k, y - 4.0 * k)
            page.wait_for_timeout(30)
            statuses.add(str(view.step.status))
        page.mouse.up()
        until(page, lambda: np.abs(view.target - before).max() > 0.02)
        until(page, lambda: view.step.status in ("OK", "UNREACHABLE", "HELD"))
        until(page, lambda: changed(first, pixels(page)) > 0.003)
        assert statuses - {"OK"}
        asked = []
        view.tracker.reconfigure = asked.append
        page.get_by_role("button", name="reconfigure").click()
        until(page, lambda: asked)
        np.testing.assert_allclose(asked[0], view.target)
        assert problems == []
        assert page.faults == []
        page.close()
