"""Files that commands write: whole or not at all."""

import errno
import os
import stat
import subprocess
import sys
import threading

import pytest
from command_line import Q, run, run_apart

from srs_ik.system.writing import write_whole


def test_content_and_permissions(tmp_path):
    path = tmp_path / "a.txt"
    mask = os.umask(0o027)
    try:
        assert write_whole(path, "é\r\n") == path
    finally:
        os.umask(mask)
    assert path.read_bytes() == b"\xc3\xa9\r\n"
    assert stat.S_IMODE(path.stat().st_mode) == 0o640
    path.chmod(0o600)
    write_whole(path, b"\x00")
    assert path.read_bytes() == b"\x00"
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert list(tmp_path.iterdir()) == [path]


def test_links_stay_links(tmp_path):
    (tmp_path / "folder").mkdir()
    target, link = tmp_path / "folder" / "target.txt", tmp_path / "link.txt"
    link.symlink_to(target)
    for text in ("one", "two"):
        write_whole(link, text)
        assert link.is_symlink()
        assert target.read_text() == text


def test_pipes_and_devices_are_written_to(tmp_path):
    fifo, found = tmp_path / "fifo", []
    os.mkfifo(fifo)
    reader = threading.Thread(target=lambda: found.append(fifo.read_text()))
    reader.start()
    write_whole(fifo, "through")
    reader.join(10)
    assert found == ["through"]
    assert stat.S_ISFIFO(fifo.stat().st_mode)
    program = (
        "from pathlib import Path; from srs_ik.system.writing import write_whole; write_whole(Path('/dev/stdout'), 'x')"
    )
    with open(tmp_path / "out", "wb") as out:
        subprocess.run([sys.executable, "-c", program], stdout=out, check=True)
    assert (tmp_path / "out").read_text() == "x"
    with pytest.raises(OSError, match="No space left") as raised:
        write_whole(type(tmp_path)("/dev/full"), "x")
    assert raised.value.errno == errno.ENOSPC


@pytest.mark.parametrize(
    ("name", "kind", "words"),
    [
        ("no/such/a.txt", FileNotFoundError, "there is no folder"),
        ("", IsADirectoryError, "it is a folder"),
        ("file/a.txt", FileNotFoundError, "there is no folder"),
        (250 * "é", OSError, "name too long"),
    ],
)
def test_the_wrong_place_is_named(tmp_path, name, kind, words):
    (tmp_path / "file").write_text("")
    path = tmp_path / name
    with pytest.raises(kind, match=words) as raised:
        write_whole(path, "x")
    assert raised.value.filename == str(path)
    assert os.listdir(tmp_path) == ["file"]


LIMITED = """
import resource
resource.setrlimit(resource.RLIMIT_FSIZE, ({size}, {size}))
from srs_ik.cli import main
main()
"""


def limited(size: int, *words: str) -> subprocess.CompletedProcess:
    """Run a command that can write files of a certain size only, as on a full disk."""
    command = [sys.executable, "-c", LIMITED.format(size=size), *words]
    return subprocess.run(command, capture_output=True, text=True, timeout=300)


@pytest.fixture
def poses(tmp_path):
    path = tmp_path / "poses.csv"
    lines = [f"0.5,{0.1 + 0.001 * i},0.6,0,1.5707963,0" for i in range(20)]
    path.write_text("\n".join(["x,y,z,roll,pitch,yaw", *lines]))
    return path


@pytest.mark.slow
@pytest.mark.parametrize("before", [None, "as it was"])
@pytest.mark.parametrize("command", ["path", "plot", "intervals", "preview", "reproduce"])
def test_commands_on_a_full_disk_leave_what_was_there(tmp_path, poses, command, before):
    folder = tmp_path / "results"
    folder.mkdir()
    file = {"path": "q.csv", "plot": "a.png", "intervals": "a.svg", "preview": "a.html", "reproduce": "lr-arms.png"}
    out = folder / file[command]
    words = {
        "path": ["path", "iiwa14", str(poses), "--out", str(out)],
        "plot": ["plot", "intervals", "iiwa14", "--q", *Q, "--output", str(out)],
        "intervals": ["intervals", "iiwa14", "--q", *Q, "--plot", str(out)],
        "preview": ["preview", "iiwa14", "--save", str(out)],
        "reproduce": ["reproduce", "lr-arms", "--out", str(folder)],
    }[command]
    assert run(*words).exit_code == 0
    assert out.stat().st_size > 1000
    for path in folder.iterdir():
        path.unlink()
    if before is not None:
        out.write_text(before)
    done = limited(1000, *words)
    assert done.returncode == 2, done.stderr
    assert done.stderr.startswith("srs-ik: ")
    assert str(out) in done.stderr
    assert "File too large" in done.stderr
    assert done.stderr.count("\n") == 1
    assert [path.name for path in folder.iterdir()] == ([] if before is None else [out.name])
    assert before is None or out.read_text() == before


@pytest.mark.slow
def test_a_full_file_system(tmp_path, poses):
    tiny = tmp_path / "tiny"
    tiny.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=4k", "none", str(tiny)], capture_output=True).returncode:
        pytest.skip("no file system can be mounted here")
    try:
        (tiny / "filling").write_bytes(bytes(4096))
        done = run_apart(["path", "iiwa14", str(poses), "--out", str(tiny / "q.csv")])
        assert (done.returncode, done.stderr.count("\n")) == (2, 1)
        assert "No space left on device" in done.stderr
        assert os.listdir(tiny) == ["filling"]
    finally:
        subprocess.run(["umount", str(tiny)], check=True)


def test_nothing_is_left_after_an_interruption(tmp_path, monkeypatch):
    def interrupted(number: int) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "fsync", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_whole(tmp_path / "a.txt", "x")
    assert not os.listdir(tmp_path)
