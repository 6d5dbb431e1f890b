"""The preview as a person sees it: in a headless browser, by its pixels."""

import numpy as np
import pytest
from browser import changed, chromium, opened, orange, pixels, settled, until

import srs_ik
from srs_ik.preview import Preview

Q = np.array([0.3, 0.7, -0.4, -1.2, 0.5, 0.8, -0.2])


@pytest.fixture(scope="module")
def browser():
    with chromium() as browser:
        yield browser


@pytest.fixture(scope="module")
def arm():
    return srs_ik.load("iiwa14")


def test_the_page_shows_the_arm_and_follows_it(browser, arm):
    with Preview(arm) as view:
        view.show(Q)
        page = opened(browser, view.url)
        first = settled(page)
        assert orange(first) > 0.003
        view.show(-Q)
        second = settled(page)
        assert orange(second) > 0.001
        assert changed(first, second) > 0.01
        view.show(Q)
        assert changed(first, settled(page)) < 0.001
        assert page.faults == []
    page.close()


def test_everything_that_can_be_shown_changes_the_picture(browser, arm):
    pose = arm.forward_kinematics(Q)
    with Preview(arm) as view:
        view.show(Q)
        page = opened(browser, view.url)
        bare = settled(page)
        shows = {
            "target": lambda: view.show_target(arm.forward_kinematics(Q + 0.3)),
            "intervals": lambda: view.show_intervals(pose),
            "ghosts": lambda: view.show_ghosts(pose),
            "ellipsoids": lambda: view.show_ellipsoids(Q),
            "polytopes": lambda: view.show_polytopes(Q),
        }
        for name, show in shows.items():
            show()
            assert changed(bare, settled(page)) > 0.0005, name
            view.clear()
            assert changed(bare, settled(page)) < 0.0001, name
        assert page.faults == []
    page.close()


def test_a_saved_scene_looks_the_same_without_server_and_network(browser, arm, tmp_path):
    path = tmp_path / "scene.html"
    with Preview(arm) as view:
        view.show(Q)
        view.show_intervals(arm.forward_kinematics(Q))
        page = opened(browser, view.url)
        live = settled(page)
        page.close()
        view.save(path)
    page = opened(browser, path.as_uri(), offline=True)
    saved = settled(page)
    assert orange(saved) > 0.003
    assert changed(live, saved) < 0.005
    assert page.title() == "iiwa14, iiwa_link_0 to iiwa_link_ee"
    assert page.faults == []
    page.close()


def test_all_of_a_stretched_arm_is_seen_in_a_narrow_window(browser):
    """As on a phone: what has the colours of an arm ends before the sides of the picture."""
    with Preview(srs_ik.load("human_arm")) as view:
        view.show([0.0, 0.0, 0.0, 0.3, 0.0, 0.0, 0.0])
        page = opened(browser, view.url)
        page.set_viewport_size({"width": 390, "height": 700})
        coloured = np.ptp(settled(page), axis=2) > 60
        assert coloured.mean() > 0.01
        assert not coloured[:, :4].any()
        assert not coloured[:, -4:].any()
    page.close()


def test_a_saved_self_motion_moves(browser, arm, tmp_path):
    with Preview(arm) as view:
        assert view.show_self_motion(arm.forward_kinematics(Q))
        view.save(tmp_path / "motion.html")
    page = opened(browser, (tmp_path / "motion.html").as_uri(), offline=True)
    # The picture is drawn once what it is made of is there, and then it moves.
    until(page, lambda: orange(pixels(page)) > 0.001)
    pictures = [pixels(page)]
    until(page, lambda: pictures.append(pixels(page)) or changed(pictures[0], pictures[-1]) > 0.01)
    assert min(orange(picture) for picture in pictures) > 0.001
    assert max(changed(pictures[0], picture) for picture in pictures[1:]) > 0.01
    assert page.faults == []
    page.close()


def test_a_motion_ends_where_the_arm_is_shown(browser, arm):
    with Preview(arm) as view:
        view.show(Q)
        page = opened(browser, view.url)
        still = settled(page)
        view.animate(np.linspace(Q, -Q, 20), 0.05)
        view.clear()
        view.show(Q)
        assert changed(still, settled(page)) < 0.001
    page.close()


def test_the_slider_turns_the_elbow_and_leaves_the_tip(browser, arm):
    pytest.importorskip("viser")
    from srs_ik.preview.live.interactive import InteractivePreview

    with InteractivePreview(arm, Q) as view:
        before, target = view.solution, view.target
        page = opened(browser, view.url)
        slider = page.get_by_role("slider")
        slider.wait_for()
        first = settled(page)
        slider.focus()
        for _ in range(40):
            page.keyboard.press("ArrowRight")
        until(page, lambda: view.solution.arm_angle - before.arm_angle > 0.2)
        after = view.solution
        assert after
        assert after.branch == before.branch
        assert after.arm_angle - before.arm_angle > 0.2
        assert (arm.lower <= after.q).all()
        assert (after.q <= arm.upper).all()
        assert max(arm.verify(target, after.q)) < 1e-9
        until(page, lambda: changed(first, pixels(page)) > 0.01)
        assert page.faults == []
    page.close()
