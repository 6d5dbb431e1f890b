"""A robot file is text to the pages: whatever its names look like, they are shown as they are and run nothing."""

import random
import re
from xml.sax.saxutils import escape

import numpy as np
import pytest
from browser import PATIENCE, chromium

import srs_ik
from srs_ik.preview import Preview
from srs_ik.preview.document import Caption, saved
from srs_ik.preview.words import report
from srs_ik.robot import zoo

FILES, NAMES = 20, 10
"""So many files, each with so many names that are shown: 7 joints, the robot, and the base and tip frames."""

REPORTED = '<iframe srcdoc="<script>parent.window.xss=3</script>"></iframe>'

BAITS = [
    REPORTED,
    "<script>window.xss=1</script>",
    "</script><script>window.xss=1</script>",
    "<img src=x onerror=window.xss=1>",
    "<svg/onload=window.xss=1>",
    "<svg><script>window.xss=1</script></svg>",
    "<details open ontoggle=window.xss=1>",
    "<body onload=window.xss=1>",
    "<input autofocus onfocus=window.xss=1>",
    "<style>@keyframes x{}</style><p style=animation-name:x onanimationstart=window.xss=1>",
    "<a href=javascript:window.xss=1>x</a>",
    "[x](javascript:window.xss=1)",
    '![x](x"onerror="window.xss=1)',
    "<math><mtext><table><mglyph><style><img src=x onerror=window.xss=1>",
    "<object data='javascript:window.xss=1'></object>",
    "<embed src='data:text/html,<script>window.xss=1</script>'>",
    "<form action=javascript:window.xss=1><button>x</button></form>",
    "{window.xss=1}",
    "${window.xss=1}",
    "{{constructor.constructor('window.xss=1')()}}",
    '";window.xss=1;//',
    "';window.xss=1;//",
    "</title><script>window.xss=1</script>",
    "<!--<script>window.xss=1</script>",
    "--><script>window.xss=1</script>",
    "]]><script>window.xss=1</script>",
    "&lt;script&gt;window.xss=1&lt;/script&gt;",
    "&#60;script&#62;window.xss=1&#60;/script&#62;",
    "\\u003cscript\\u003ewindow.xss=1",
    "</td></tr></table><script>window.xss=1</script>",
    "<base href=//elsewhere.example/>",
    "<meta http-equiv=refresh content='0;url=data:text/html,x'>",
    "<link rel=stylesheet href=//elsewhere.example/x.css>",
    "| a | <b onclick=window.xss=1>b</b> |",
    "`<script>window.xss=1</script>`",
    "<SCRIPT SRC=//elsewhere.example/x.js></SCRIPT>",
    "<scr<script>ipt>window.xss=1</scr</script>ipt>",
    "＜script＞window.xss=1＜/script＞",
]


def names(count: int) -> list[str]:
    """Different ones: the baits as they are, then two joined, doubled or turned, each with its number."""
    rng = random.Random(11)
    turns = [str, str.upper, str.swapcase, lambda s: s * 2, lambda s: escape(s), lambda s: s.replace("window", "top")]
    found = list(BAITS)
    while len(found) < count:
        found.append(f"{rng.choice(turns)(rng.choice(BAITS))}{rng.choice(BAITS)}{len(found)}")
    return found


def arm_with(tmp_path, texts: list[str]):
    """The iiwa14 with other names for its joints, itself and its two frames."""
    urdf = zoo.card("iiwa14").urdf.read_text()
    old = [f"iiwa_joint_{k}" for k in range(1, 8)] + ["iiwa14", "iiwa_link_0", "iiwa_link_ee"]
    for word, text in zip(old, texts, strict=True):
        urdf = re.sub(rf'"{word}"', lambda _, text=text: f'"{escape(text, {chr(34): "&quot;"})}"', urdf)
    path = tmp_path / "hostile.urdf"
    path.write_text(urdf)
    arm = srs_ik.load(path, texts[8], texts[9])
    assert (arm.joint_names, arm.base, arm.tip) == (tuple(texts[:7]), texts[8], texts[9])
    return arm


@pytest.fixture(scope="module")
def browser():
    with chromium() as browser:
        yield browser


@pytest.fixture
def page(browser):
    """A page that notes what it should not do."""
    page = browser.new_page(viewport={"width": 700, "height": 900})
    page.faults = []
    page.on("dialog", lambda dialog: (page.faults.append(dialog.message), dialog.dismiss()))
    page.on("request", lambda request: page.faults.append(request.url) if "elsewhere" in request.url else None)
    yield page
    page.close()


FOREIGN = "iframe, frame, object, embed, base, form[action], meta[http-equiv=refresh], img[src=x], a[href^=javascript]"
HANDLERS = "[onerror], [onload], [ontoggle], [onfocus], [onclick], [onanimationstart]"


def nothing_ran(page) -> None:
    page.wait_for_timeout(20)
    assert page.faults == []
    assert len(page.frames) == 1
    assert page.evaluate("[window.xss, parent.xss, top.xss].every(x => x === undefined)")
    assert page.locator(f"{FOREIGN}, {HANDLERS}").count() == 0
    assert page.locator("script").evaluate_all("all => all.filter(x => /^window.xss/.test(x.textContent)).length") == 0


@pytest.mark.slow
@pytest.mark.parametrize("batch", [0, NAMES])
def test_a_file_of_hostile_names_is_text_to_the_page_with_sliders(page, tmp_path, batch):
    pytest.importorskip("viser")
    texts = names(FILES * NAMES)[batch : batch + NAMES]
    arm = arm_with(tmp_path, texts)
    with srs_ik.preview.InteractivePreview(arm) as view:
        page.goto(view.url)
        cells = page.locator("td:first-child")
        cells.first.wait_for(timeout=PATIENCE)
        assert cells.all_text_contents() == texts[:7]
        nothing_ran(page)
        # A message that names a joint: a pose that only this joint beyond its limit reaches.
        q = np.zeros(7)
        q[3] = 1.05 * arm.upper[3]
        message = view.show(arm.forward_kinematics(q)).message
        assert texts[3] in message
        page.get_by_text(message).wait_for(timeout=PATIENCE)
        nothing_ran(page)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["served", "saved"])
@pytest.mark.parametrize("batch", [0, NAMES])
def test_a_file_of_hostile_names_is_text_to_meshcats_page(page, tmp_path, batch, kind):
    arm = arm_with(tmp_path, names(FILES * NAMES)[batch : batch + NAMES])
    expected = f"{arm.name}, {arm.base} to {arm.tip}"
    with Preview(arm) as view:
        page.goto(view.url if kind == "served" else view.save(tmp_path / "scene.html").as_uri())
        title = page.locator("#title")
        title.filter(has_text=" to ").wait_for(timeout=PATIENCE)
        assert title.text_content() == expected
        assert page.title() == " ".join(expected.split())
        nothing_ran(page)


@pytest.mark.slow
def test_200_names_are_text_to_the_page_with_sliders(page):
    """In its own browser page, in the words that it would show for as many robots."""
    pytest.importorskip("viser")
    arm, texts = srs_ik.load("iiwa14"), names(FILES * NAMES)
    assert len(set(texts)) == 200
    with srs_ik.preview.InteractivePreview(arm) as view:
        page.goto(view.url)
        page.locator("td").first.wait_for(timeout=PATIENCE)
        for k in range(0, 200, 7):
            batch = (texts[k:] + texts)[:7]
            view._text.content = report(Posture(batch), [])
            page.get_by_text(f"number {batch[0]}").wait_for(timeout=PATIENCE)
            assert page.locator("td:first-child").all_text_contents() == batch
            nothing_ran(page)


class Posture:
    """What a report asks of a posture."""

    def __init__(self, texts: list[str]) -> None:
        self.texts, self.message = texts, f"number {texts[0]}"

    def as_dict(self) -> dict[str, float]:
        return dict.fromkeys(self.texts, 0.5)


@pytest.mark.slow
def test_200_names_are_text_to_meshcats_page(page):
    with Preview(srs_ik.load("iiwa14")) as view:
        page.goto(view.url)
        for text in names(FILES * NAMES):
            view._canvas.tell(Caption(text, [f"line {text}"], [((0.1, 0.2, 0.3), f"legend {text}")]))
            page.locator("#lines").filter(has_text=f"line {text}").wait_for(timeout=PATIENCE)
            assert page.locator("#title").text_content() == text
            assert page.locator("#legend").text_content() == f"legend {text}"
            nothing_ran(page)


def test_a_caption_leaves_no_script(tmp_path):
    """Of every bait, in every place that takes text."""
    for bait in names(200):
        text = saved(Caption(bait, [bait], [((0.1, 0.2, 0.3), bait)]), "0", [b"x"])
        bare = saved(Caption("", [""], [((0.1, 0.2, 0.3), "")]), "0", [b"x"])
        assert text.count("<") == bare.count("<")
        assert text.count("<script") == text.count("</script>") == 2
