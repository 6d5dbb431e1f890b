"""A page answers nobody who lacks its address, no other origin and no other name, and takes no senseless word."""

import contextlib
import http.server
import itertools
import random
import socket
import threading
import time

import numpy as np
import pytest
from browser import PATIENCE, another, chromium

import srs_ik
from srs_ik.preview import Preview
from srs_ik.preview.door import Door

KINDS = pytest.mark.parametrize("kind", ["meshcat", "interactive"])


@pytest.fixture(scope="module")
def arm():
    return srs_ik.load("iiwa14")


@pytest.fixture(scope="module")
def browser():
    with chromium() as browser:
        yield browser


def interactive(arm):
    pytest.importorskip("viser")
    return srs_ik.preview.InteractivePreview(arm)


@pytest.fixture
def view(arm, kind):
    with Preview(arm) if kind == "meshcat" else interactive(arm) as view:
        yield view


def split(url: str) -> tuple[int, str]:
    """Port and path of a page."""
    port, _, path = url.removeprefix("http://127.0.0.1:").partition("/")
    return int(port), f"/{path}"


def socket_of(kind: str, path: str) -> str:
    """Path of the websocket."""
    return path + "scene" if kind == "meshcat" else path.rstrip("/")


UPGRADE = (
    "Connection: Upgrade",
    "Upgrade: websocket",
    "Sec-WebSocket-Version: 13",
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==",
)


def ask(port: int, target: str, *headers: str, method: str = "GET") -> tuple[int, bytes]:
    """Status of the answer to a request, and the whole of what came; 0 where the connection was closed without any."""
    with socket.create_connection(("127.0.0.1", port), timeout=30) as connection:
        connection.sendall("\r\n".join([f"{method} {target} HTTP/1.1", *headers, "", ""]).encode("latin-1"))
        answer = b""
        with contextlib.suppress(ConnectionError, TimeoutError):
            while chunk := connection.recv(65536):
                answer += chunk
                if b"\r\n\r\n" in answer:
                    connection.settimeout(0.3)
    return int(answer.split()[1]) if answer else 0, answer


def hosts(port: int) -> dict[str, list[str]]:
    """Host headers that are refused."""
    names = [
        "elsewhere.example",
        "127.0.0.1.elsewhere.example",
        "127.0.0.2",
        "0.0.0.0",
        "[::1]",
        "localhost.",
        "a@127.0.0.1",
    ]
    wrong = {name: [f"Host: {name}:{port}"] for name in names}
    wrong |= {
        "no port": ["Host: 127.0.0.1"],
        "other port": [f"Host: 127.0.0.1:{port - 1}"],
        "empty": ["Host: "],
        "none": [],
    }
    wrong["two"] = [f"Host: 127.0.0.1:{port}", "Host: elsewhere.example"]
    return wrong


def origins(port: int) -> dict[str, list[str]]:
    """Origin headers that are refused where the Host is 127.0.0.1."""
    own = f"http://127.0.0.1:{port}"
    wrong = ["null", "", "file://", f"http://127.0.0.1:{port - 1}", "http://127.0.0.1", f"https://127.0.0.1:{port}"]
    wrong += [
        f"http://localhost:{port}",
        f"http://elsewhere.example:{port}",
        f"{own}.elsewhere.example",
        f"{own}/",
        "*",
    ]
    refused = {origin: [f"Origin: {origin}"] for origin in wrong}
    return refused | {"two": [f"Origin: {own}", "Origin: http://elsewhere.example"]}


@pytest.mark.slow
@KINDS
def test_a_raw_request_is_refused_for_each_reason_alone(view, kind):
    port, path = split(view.url)
    own, script = [f"Host: 127.0.0.1:{port}"], path + "main.min.js" if kind == "meshcat" else path + "index.html"
    targets = {path: (), script: (), socket_of(kind, path): UPGRADE}
    wanted = dict(zip(targets, (200, 200, 101), strict=True))
    for target, headers in targets.items():
        for name in ("127.0.0.1", "localhost"):
            both = [f"Host: {name}:{port}"], [f"Host: {name}:{port}", f"Origin: http://{name}:{port}"]
            assert [ask(port, target, *good, *headers)[0] for good in both] == 2 * [wanted[target]]
        refused = {
            **{f"host {name}": ask(port, target, *wrong, *headers) for name, wrong in hosts(port).items()},
            **{f"origin {name}": ask(port, target, *own, *wrong, *headers) for name, wrong in origins(port).items()},
        }
        token = path.strip("/")
        swapped = [
            "",
            "x" * len(token),
            token[:-1],
            token + "x",
            token.swapcase(),
            f"./{token}",
            "é",
            "%00",
            f"?{token}",
        ]
        for wrong in swapped:
            refused[f"token {wrong}"] = ask(port, target.replace(token, wrong), *own, *headers)
        # 400 is the answer of a server that does not take such a request for one.
        assert {name: status for name, (status, _) in refused.items() if status not in (403, 400)} == {}
        assert sum(status == 403 for status, _ in refused.values()) >= len(refused) - 5
        assert all(token.encode() not in answer and len(answer) < 1000 for _, answer in refused.values())


@pytest.mark.slow
@KINDS
def test_what_is_not_there_is_refused_without_the_address_too(view, kind):
    port, path = split(view.url)
    host = f"Host: 127.0.0.1:{port}"
    for target in (
        "/",
        "/static/",
        "/static/main.min.js",
        "/index.html",
        "/scene",
        "//",
        "*",
        f"http://127.0.0.1:{port}/",
    ):
        assert ask(port, target, host)[0] in (400, 403), target
        assert ask(port, target, host, *UPGRADE)[0] in (400, 403), target
    for inside in ("nothing", "../visualizer.py", "..%2f..%2fvisualizer.py", "%2e%2e/%2e%2e/setup.py", "main.js"):
        assert ask(port, path + inside, host)[0] in (403, 404), inside
    for method in ("POST", "PUT", "OPTIONS", "DELETE"):
        status, answer = ask(port, path, host, method=method)
        assert status in (0, 400, 405)
        assert b"Access-Control" not in answer


@KINDS
def test_the_answer_keeps_the_address_to_itself(view, kind):
    port, path = split(view.url)
    head = ask(port, path, f"Host: 127.0.0.1:{port}")[1].partition(b"\r\n\r\n")[0].decode().lower()
    for header in (
        "cache-control: no-store",
        "referrer-policy: no-referrer",
        "content-security-policy: default-src 'none'",
    ):
        assert header in head
    assert "access-control" not in head
    assert "set-cookie" not in head


def test_every_page_has_a_secret_of_its_own():
    secrets = {split(Door().url)[1] for _ in range(1000)}
    assert len(secrets) == 1000
    # 24 bytes in base 64: nobody tries 2^192.
    assert {len(secret) for secret in secrets} == {34}


# A real browser ------------------------------------------------------------------------------------------------------

ATTACK = """async ([pages, sockets, protocol]) => {
  const seen = {};
  for (const url of pages) {
    for (const mode of ["cors", "no-cors"]) {
      try {
        const answer = await fetch(url, {mode, credentials: "include"});
        seen[`fetch ${mode} ${url}`] = answer.type === "opaque" ? "" : await answer.text();
      } catch (error) { seen[`fetch ${mode} ${url}`] = ""; }
    }
    seen[`script ${url}`] = await new Promise(done => {
      const script = document.createElement("script");
      script.src = url + "main.min.js";
      script.onload = () => done(typeof MeshCat === "undefined" ? "" : "ran");
      script.onerror = () => done("");
      document.head.append(script);
    });
  }
  for (const url of sockets) {
    seen[`socket ${url}`] = await new Promise(done => {
      const socket = new WebSocket(url, protocol ? [protocol] : []);
      socket.onmessage = () => done("read");
      socket.onopen = () => done("opened");
      socket.onerror = () => done("");
      setTimeout(() => done(""), 200000);
    });
  }
  return seen;
}"""


@contextlib.contextmanager
def foreign_page(folder, origin: str):
    """Address of a page of another origin."""
    (folder / "foreign.html").write_text("<!DOCTYPE html><title>foreign</title><p>elsewhere")
    if origin == "file":
        yield (folder / "foreign.html").as_uri()
        return

    class Quiet(http.server.SimpleHTTPRequestHandler):
        def __init__(self, *arguments) -> None:
            super().__init__(*arguments, directory=str(folder))

        def log_message(self, *arguments) -> None:
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Quiet) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/foreign.html"
        server.shutdown()


@pytest.mark.slow
@KINDS
@pytest.mark.parametrize("origin", ["port", "file"])
@pytest.mark.parametrize("address", ["unknown", "known"])
def test_a_page_of_another_origin_reads_and_writes_nothing(browser, view, kind, origin, address, tmp_path):
    """Not even one that has got hold of the address."""
    port, path = split(view.url)
    token = path.strip("/") if address == "known" else "x"
    pages = [f"http://{name}:{port}/{token}/" for name in ("127.0.0.1", "localhost")] + [f"http://127.0.0.1:{port}/"]
    sockets = [socket_of(kind, page.replace("http", "ws")) for page in pages]
    with foreign_page(tmp_path, origin) as url:
        page = browser.new_page()
        page.set_default_timeout(PATIENCE)
        page.goto(url)
        protocol = viser_protocol() if kind == "interactive" else ""
        seen = page.evaluate(ATTACK, [pages, sockets, protocol])
        page.close()
    scripts = {name for name, found in seen.items() if name.startswith("script") and found}
    # A script that is no secret may be loaded by whoever knows the address, as any file of the library.
    assert scripts <= {f"script {page}" for page in pages if address == "known" and kind == "meshcat"}
    assert {name: found for name, found in seen.items() if found and name not in scripts} == {}
    assert len(seen) == 3 * len(pages) + len(sockets)


@pytest.mark.slow
@KINDS
def test_a_name_that_resolves_to_this_machine_opens_nothing(browser, view, kind):
    """What a page does whose own name is made to point to this machine after it was loaded."""
    port, path = split(view.url)
    protocol = viser_protocol() if kind == "interactive" else ""
    with another(browser, "--host-resolver-rules=MAP rebound.example 127.0.0.1") as misled:
        page = misled.new_page()
        for target in (path, "/"):
            answer = page.goto(f"http://rebound.example:{port}{target}")
            assert answer.status == 403
            url = f"ws://rebound.example:{port}{socket_of(kind, target)}"
            assert page.evaluate(ATTACK, [[], [url], protocol]) == {f"socket {url}": ""}
        page.close()


@pytest.mark.slow
@KINDS
def test_the_right_address_opens_under_both_names(browser, view, kind):
    port, path = split(view.url)
    for name in ("127.0.0.1", "localhost"):
        page = browser.new_page()
        page.goto(f"http://{name}:{port}{path}")
        page.get_by_text("iiwa14, iiwa_link_0 to iiwa_link_ee").first.wait_for(timeout=PATIENCE)
        page.close()


def viser_protocol() -> str:
    viser = pytest.importorskip("viser")
    return f"viser-v{viser.__version__}"


# What is said to the page with sliders -------------------------------------------------------------------------------


@contextlib.contextmanager
def connected(view):
    """A connection of a program that has the address."""
    client = pytest.importorskip("websockets.sync.client")
    with client.connect(view.url.replace("http", "ws").rstrip("/"), subprotocols=[viser_protocol()]) as connection:
        yield connection


def packed(**fields) -> bytes:
    import msgspec

    return msgspec.msgpack.encode(fields)


CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": [1.0, 0.0, 0.0, 0.0],
    "position": [1.0, 1.0, 1.0],
    "fov": 1.0,
    "near": 0.01,
    "far": 1000.0,
    "image_height": 480,
    "image_width": 640,
    "look_at": [0.0, 0.0, 0.0],
    "up_direction": [0.0, 0.0, 1.0],
}
POSE = {"type": "TransformControlsUpdateMessage", "name": "/scene/target", "owner": ""}
LEVEL = [1.0, 0.0, 0.0, 0.0]
WRONG = [float("nan"), float("inf"), -float("inf"), 1e308, -1e308, 1001.0, None, "0", True, [], {}, 2**63]


def wait_until(condition, seconds: float = 300.0) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.02)


def ends(connection, seconds: float = 300.0) -> int:
    """The code with which the page ends a connection."""
    from websockets.exceptions import ConnectionClosed

    try:
        while True:
            connection.recv(timeout=seconds)
    except ConnectionClosed as closed:
        return closed.rcvd.code


@pytest.mark.slow
def test_the_pages_own_messages_move_the_target(arm):
    pytest.importorskip("viser")
    with interactive(arm) as view, connected(view) as connection:
        connection.send(packed(**CAMERA))
        connection.send(packed(**POSE, wxyz=LEVEL, position=[0.5, 0.1, 0.6]))
        wait_until(lambda: np.allclose(view.target[:3, 3], [0.5, 0.1, 0.6]) and view.solution)
        # What was read when the page was opened is the scene.
        assert b"iiwa14" in connection.recv() or len(connection.recv()) > 1000


def hostile(view) -> dict[str, object]:
    """Messages of which none may have an effect."""
    slider, xyz, rpy, intervals = (handle._impl.uuid for handle in (view._slider, view._xyz, view._rpy, view._list))
    found: dict[str, object] = {"text": "hello", "empty": b"", "rubbish": bytes(range(256)), "long": b"\x00" * 100_000}
    for wrong in WRONG:
        for k in range(3):
            position = [0.1, 0.2, 0.3]
            position[k] = wrong
            found[f"position {k} {wrong}"] = packed(**POSE, wxyz=LEVEL, position=position)
            found[f"xyz {k} {wrong}"] = packed(type="GuiUpdateMessage", uuid=xyz, updates={"value": position})
        found[f"turn {wrong}"] = packed(**POSE, wxyz=[wrong, 0.0, 0.0, 0.0], position=[0.1, 0.2, 0.3])
        if wrong != 1001.0:
            found[f"rpy {wrong}"] = packed(type="GuiUpdateMessage", uuid=rpy, updates={"value": [0.0, wrong, 0.0]})
            found[f"slider {wrong}"] = packed(type="GuiUpdateMessage", uuid=slider, updates={"value": wrong})
            found[f"camera {wrong}"] = packed(**{**CAMERA, "fov": wrong})
    for turn in ([0.0] * 4, [2.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 0.5, 0.5, 0.4]):
        found[f"turn {turn}"] = packed(**POSE, wxyz=turn, position=[0.1, 0.2, 0.3])
    found |= {
        "short": packed(**POSE, wxyz=LEVEL, position=[0.1, 0.2]),
        "other name": packed(**{**POSE, "name": "/scene"}, wxyz=LEVEL, position=[0.1, 0.2, 0.3]),
        "name of a list": packed(**{**POSE, "name": []}, wxyz=LEVEL, position=[0.1, 0.2, 0.3]),
        "other owner": packed(**{**POSE, "owner": "7"}, wxyz=LEVEL, position=[0.1, 0.2, 0.3]),
        "more fields": packed(**POSE, wxyz=LEVEL, position=[0.1, 0.2, 0.3], excluded_self_client=1),
        "unknown interval": packed(type="GuiUpdateMessage", uuid=intervals, updates={"value": "branch 9"}),
        "interval of a number": packed(type="GuiUpdateMessage", uuid=intervals, updates={"value": 1}),
        "another property": packed(type="GuiUpdateMessage", uuid=slider, updates={"value": 1.0, "visible": False}),
        "unknown control": packed(type="GuiUpdateMessage", uuid="x", updates={"value": 1.0}),
        "text of the page": packed(type="GuiUpdateMessage", uuid=view._text._impl.uuid, updates={"content": "<b>"}),
        "share": packed(type="ShareUrlRequest"),
        "upload": packed(
            type="FileTransferStartUpload",
            source_component_uuid="x",
            transfer_uuid="x",
            filename="x",
            mime_type="x",
            part_count=1,
            size_bytes=1,
        ),
        "script": packed(type="RunJavascriptMessage", source="window.xss = 1"),
        "unknown type": packed(type="Message"),
        "no type": packed(name="x"),
        "type of a list": packed(type=[]),
        "a list": b"\x93\x01\x02\x03",
        "deep": b"\x91" * 4000,
        "keys of numbers": b"\x81\x01\x02",
    }
    return found


@pytest.mark.slow
def test_a_senseless_message_ends_its_connection_and_moves_nothing(arm, capfd):
    pytest.importorskip("viser")
    with interactive(arm) as view:
        target, q = view.target, view.solution.q.copy()
        codes = {}
        for name, message in hostile(view).items():
            with connected(view) as connection:
                connection.send(packed(**CAMERA))
                connection.send(message)
                # What is sent behind it is not heard either.
                with contextlib.suppress(Exception):
                    connection.send(packed(**POSE, wxyz=LEVEL, position=[0.1, 0.2, 0.3]))
                codes[name] = ends(connection)
        # 1008: not a message of the page; 1009: too long to be read at all.
        assert {name: code for name, code in codes.items() if code != 1008} == {"long": 1009}
        assert len(codes) > 120
        assert (view.target == target).all()
        assert (view.solution.q == q).all()
        # It still listens to those who speak its language.
        with connected(view) as connection:
            connection.send(packed(**CAMERA))
            connection.send(packed(**POSE, wxyz=LEVEL, position=[0.5, 0.1, 0.6]))
            wait_until(lambda: np.allclose(view.target[:3, 3], [0.5, 0.1, 0.6]))
    assert capfd.readouterr() == ("", "")


@pytest.mark.slow
def test_no_made_message_is_taken_that_is_not_finite(arm):
    """50,000 messages: whatever is taken can be read by viser, and holds numbers of a reasonable size alone."""
    viser = pytest.importorskip("viser")
    rng = random.Random(5)
    with interactive(arm) as view:
        uuids = [handle._impl.uuid for handle in (view._slider, view._xyz, view._rpy, view._list)]
        leaves = [*WRONG, 0, 1, 0.5, -2.0, "", "/scene/target", view._list.value, 1e-300, LEVEL, [0.1, 0.2, 0.3]]
        kinds = ["GuiUpdateMessage", "TransformControlsUpdateMessage", "ViewerCameraMessage", "ShareUrlRequest"]
        taken = 0
        for _ in range(50_000):
            kind = rng.choice(kinds)
            fields: dict[str, object] = {"type": kind}
            if kind == "ViewerCameraMessage":
                fields |= CAMERA
            elif kind == "GuiUpdateMessage":
                fields |= {"uuid": rng.choice(uuids), "updates": {"value": rng.choice(leaves)}}
            else:
                fields |= {**POSE, "type": kind, "wxyz": LEVEL, "position": [rng.uniform(-2e3, 2e3), 0.0, 0.5]}
            for _ in range(rng.choice([0, 0, 1, 2])):
                fields[rng.choice([*fields, "x"])] = rng.choice(leaves)
            message = packed(**fields)
            if rng.random() < 0.2:
                place = rng.randrange(len(message))
                message = message[:place] + bytes([rng.randrange(256)]) + message[place + 1 :]
            if view._inbox.accepts(message):
                taken += 1
                read = viser._messages.Message.deserialize(message)
                numbers = list(figures(vars(read)))
                assert all(np.isfinite(x) and abs(x) <= 1e6 for x in numbers), vars(read)
        assert 3000 < taken < 40_000


def figures(value):
    if isinstance(value, dict):
        yield from itertools.chain.from_iterable(map(figures, value.values()))
    elif isinstance(value, list | tuple):
        yield from itertools.chain.from_iterable(map(figures, value))
    elif isinstance(value, int | float):
        yield float(value)


def test_a_page_whose_guard_does_not_stand_is_not_served(arm, monkeypatch):
    """Should viser come to listen in another way."""
    page = pytest.importorskip("srs_ik.preview.live.page")
    guard = pytest.importorskip("srs_ik.preview.live.guard")
    monkeypatch.setattr(guard, "guarding", contextlib.nullcontext)
    before = threading.active_count()
    with pytest.raises(srs_ik.PreviewError, match="cannot be kept to this machine"):
        page.serve(0, "x")
    wait_until(lambda: threading.active_count() <= before)


@pytest.mark.slow
def test_another_server_of_viser_is_left_as_it_is(arm):
    viser = pytest.importorskip("viser")
    with interactive(arm) as view:
        assert view.url.count("/") == 4
        other = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
        try:
            assert ask(other.get_port(), "/", "Host: elsewhere")[0] == 200
        finally:
            other.stop()
