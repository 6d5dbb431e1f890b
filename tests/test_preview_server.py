"""The page is for this machine alone, and goes when it is closed, when the program ends, and when it fails."""

import contextlib
import os
import signal
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request

import psutil
import pytest

import srs_ik
from srs_ik.preview import Preview


@pytest.fixture(scope="module")
def arm():
    return srs_ik.load("iiwa14")


def make(arm, kind: str, **options):
    if kind == "interactive":
        pytest.importorskip("viser")
        return srs_ik.preview.InteractivePreview(arm, **options)
    return Preview(arm, **options)


def listening() -> set[tuple[str, int]]:
    """Addresses and ports on which this process and its children wait for connections."""
    processes = [psutil.Process(), *psutil.Process().children(recursive=True)]
    return {
        (connection.laddr.ip, connection.laddr.port)
        for process in processes
        for connection in process.net_connections(kind="inet")
        if connection.status == psutil.CONN_LISTEN
    }


def port_of(view) -> int:
    return int(view.url.removeprefix("http://127.0.0.1:").partition("/")[0])


KINDS = pytest.mark.parametrize("kind", ["meshcat", "interactive"])


@KINDS
def test_it_listens_on_the_loopback_interface_alone_and_starts_no_process(arm, kind):
    before, children = listening(), psutil.Process().children(recursive=True)
    with make(arm, kind) as view:
        opened = listening() - before
        assert opened == {("127.0.0.1", port_of(view))}
        assert urllib.request.urlopen(view.url, timeout=300).status == 200
        assert psutil.Process().children(recursive=True) == children
    assert listening() - before == set()
    assert view.closed


@KINDS
def test_an_exception_closes_it(arm, kind):
    before = listening()
    with pytest.raises(ZeroDivisionError), make(arm, kind):
        raise ZeroDivisionError
    assert listening() == before


@KINDS
def test_one_that_nobody_holds_any_more_is_closed(arm, kind):
    before = listening()
    view = make(arm, kind)
    assert listening() != before
    if kind == "interactive":
        # Its own callbacks hold it while it is open.
        view.close()
    del view
    assert listening() == before


@KINDS
def test_a_port_can_be_chosen_and_is_free_again(arm, kind):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(srs_ik.PreviewError, match=f"port {port} of 127.0.0.1"):
            make(arm, kind, port=port)
    for _ in range(2):
        with make(arm, kind, port=port) as view:
            assert port_of(view) == port


@KINDS
@pytest.mark.parametrize("port", [70000, -5, 7.5, "7000", True, None])
def test_a_port_that_is_none_is_refused(arm, kind, port):
    with pytest.raises(srs_ik.PreviewError, match="from 0 to 65535"):
        make(arm, kind, port=port).close()


def test_after_close_every_call_is_one_clear_error(arm, tmp_path):
    view = Preview(arm)
    view.close()
    view.close()
    for call in (lambda: view.show([0.0] * 7), view.html, view.clear, lambda: view.save(tmp_path / "x.html")):
        with pytest.raises(srs_ik.PreviewError, match="is closed"):
            call()
    assert not (tmp_path / "x.html").exists()
    assert "closed" in repr(view)


def test_nothing_is_printed(arm, capfd):
    with Preview(arm) as view:
        view.show([0.1] * 7)
        with contextlib.suppress(urllib.error.HTTPError):
            urllib.request.urlopen(f"http://127.0.0.1:{port_of(view)}/favicon.ico", timeout=300)
    pytest.importorskip("viser")
    with srs_ik.preview.InteractivePreview(arm):
        pass
    assert capfd.readouterr() == ("", "")


SCRIPT = """
import sys, time, srs_ik
view = srs_ik.{maker}(srs_ik.load("iiwa14"))
print(view.url, flush=True)
{end}
"""


@KINDS
@pytest.mark.parametrize(
    ("end", "status"),
    [("", 0), ("raise RuntimeError('on purpose')", 1), ("time.sleep(600)", -signal.SIGTERM), ("sys.exit(3)", 3)],
    ids=["end", "exception", "killed", "exit"],
)
def test_nothing_is_left_of_a_program(kind, end, status):
    if kind == "interactive":
        pytest.importorskip("viser")
    maker = "preview.InteractivePreview" if kind == "interactive" else "Preview"
    script = SCRIPT.format(maker=maker, end=end)
    with subprocess.Popen(
        [sys.executable, "-c", script],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as program:
        url = program.stdout.readline().strip()
        if "sleep" in end:
            program.terminate()
        out, err = program.communicate(timeout=300)
        assert program.returncode == status, err
    assert out == ""
    assert ("on purpose" in err) == (status == 1)
    assert err == "" or status == 1
    # It led a group of its own: whatever it had started would still be in it.
    deadline = time.monotonic() + 300.0
    while any(_group(process) == program.pid for process in psutil.process_iter()):
        assert time.monotonic() < deadline
        time.sleep(0.05)
    with pytest.raises(urllib.error.URLError, match="refused"):
        urllib.request.urlopen(url, timeout=300)


def _group(process: psutil.Process) -> int:
    try:
        return os.getpgid(process.pid)
    except ProcessLookupError:
        return -1
