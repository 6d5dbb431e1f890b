"""Compiled kernels where no folder can be written, where their files are damaged, and on a full disk."""

import os
import resource
import shutil
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from srs_ik.kernels import disk

PACKAGE = Path(disk.__file__).parent.parent
PROGRAM = """
from small_kernels.numbers import double, half
print(double(2.0), half(1.0), sum(sum(f.stats.cache_hits.values()) for f in (double, half)))
"""
SOURCE = """
from srs_ik.kernels.jit import entry

@entry
def double(x):
    return 2.0 * x

@entry
def half(x):
    return 0.5 * x
"""
COMPILED, READ = "4.0 0.5 0", "4.0 0.5 2"
NO_TEMPORARY = "import tempfile; tempfile.tempdir = '/proc/none'\n"


def bound_by_permissions(command: list[str]) -> list[str]:
    """The command, as a user for whom a folder without write permission is one: root too, without its privilege."""
    if os.geteuid() != 0:
        return command
    if shutil.which("setpriv") is None:
        pytest.skip("root writes everywhere, and there is no setpriv to change that")
    return ["setpriv", "--bounding-set=-dac_override,-dac_read_search", *command]


@pytest.fixture
def small(tmp_path):
    """A folder with a package of two small kernels, a home and a folder for temporary files."""
    folder = tmp_path / "site" / "small_kernels"
    folder.mkdir(parents=True)
    (folder / "__init__.py").write_text("")
    (folder / "numbers.py").write_text(SOURCE)
    (tmp_path / "home").mkdir()
    (tmp_path / "temporary").mkdir()
    yield tmp_path
    for path in tmp_path.rglob("*"):
        if path.is_dir() and not path.is_symlink():
            path.chmod(0o755)


def lock(*folders: Path) -> None:
    for folder in folders:
        folder.chmod(0o555)


def run(small: Path, program: str = PROGRAM, **environment: str) -> tuple[str, str]:
    """What a process prints on standard output and on standard error."""
    fresh = {name: value for name, value in os.environ.items() if name not in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME")}
    command = bound_by_permissions([sys.executable, "-c", program])
    done = subprocess.run(
        command,
        cwd=small / "site",
        capture_output=True,
        text=True,
        timeout=300,
        env={
            **fresh,
            "PYTHONPATH": f"{small / 'site'}{os.pathsep}{PACKAGE.parent}",
            "PYTHONDONTWRITEBYTECODE": "1",
            "HOME": str(small / "home"),
            "TMPDIR": str(small / "temporary"),
            "SRS_IK_JIT": "1",
            **environment,
        },
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip(), done.stderr


def files(folder: Path) -> list[Path]:
    return sorted(folder.rglob("*.nbc"))


def warnings_in(said: str) -> int:
    assert "Traceback" not in said
    return said.count("RuntimeWarning")


def test_kernels_are_kept_beside_their_source(small):
    assert run(small) == (COMPILED, "")
    assert len(files(small / "site")) == len(files(small)) == 2
    assert run(small) == (READ, "")


def test_kernels_are_kept_at_home_where_the_package_cannot_be_written(small):
    lock(small / "site" / "small_kernels")
    assert run(small) == (COMPILED, "")
    assert len(files(small / "home")) == len(files(small)) == 2
    assert run(small) == (READ, "")


def test_a_folder_of_ones_own_among_the_temporary_ones_is_the_last_resort(small):
    lock(small / "site" / "small_kernels", small / "home")
    answer, said = run(small)
    assert (answer, warnings_in(said)) == (COMPILED, 1)
    (aside,) = (small / "temporary").iterdir()
    assert str(aside) in said
    assert "NUMBA_CACHE_DIR" in said
    assert stat.S_IMODE(aside.stat().st_mode) == 0o700
    assert len(files(aside)) == 2
    assert run(small) == (READ, "")


def plant(temporary: Path, how: str) -> Path:
    """Put what an attacker could where the temporary folder is to be."""
    aside = temporary / f"srs_ik-{os.geteuid()}"
    aside.mkdir()
    if how == "written by all":
        aside.chmod(0o777)
    elif how == "read by all":
        aside.chmod(0o755)
    elif how == "a link":
        aside.rename(temporary / "elsewhere")
        aside.symlink_to(temporary / "elsewhere")
        (temporary / "elsewhere").chmod(0o700)
    elif how == "among others":
        aside.chmod(0o700)
        temporary.chmod(0o777)
    elif how == "another's":
        os.chown(aside, 12345, 12345)
        aside.chmod(0o777)
    return aside


@pytest.mark.parametrize("how", ["written by all", "read by all", "a link", "among others", "another's"])
def test_machine_code_is_not_read_from_a_folder_that_others_may_write(small, how):
    if how == "another's" and os.geteuid() != 0:
        pytest.skip("only root can give a folder away")
    lock(small / "site" / "small_kernels", small / "home")
    plant(small / "temporary", how)
    for _ in range(2):
        answer, said = run(small)
        assert (answer, warnings_in(said)) == (COMPILED, 1)
    assert not files(small)


@pytest.mark.parametrize("home", ["locked", "missing", "unset"])
def test_nothing_can_be_written_at_all(small, home):
    lock(small / "site" / "small_kernels", small / "site", small / "home")
    where = {"locked": str(small / "home"), "missing": "/proc/none", "unset": ""}[home]
    program = NO_TEMPORARY + ("import os; del os.environ['HOME']\n" if home == "unset" else "") + PROGRAM
    if home == "unset":
        # The home that the list of users knows is another machine's matter.
        program = f"import pwd; pwd.getpwuid = lambda user: {{}}[user]\n{program}"
    for _ in range(2):
        answer, said = run(small, program, HOME=where)
        assert (answer, warnings_in(said)) == (COMPILED, 1)
        assert "each start compiles them again" in said
    assert not files(small)


def test_a_named_folder_is_the_only_one(small):
    assert run(small, NUMBA_CACHE_DIR=str(small / "named" / "below")) == (COMPILED, "")
    assert len(files(small / "named")) == len(files(small)) == 2
    assert run(small) == (COMPILED, "")
    assert run(small, NUMBA_CACHE_DIR=str(small / "named" / "below")) == (READ, "")


@pytest.mark.parametrize("named", ["site", "named"])
def test_what_was_compiled_before_is_read_where_nothing_can_be_written(small, named):
    """As in a container: compiled in a layer of the image, which is then read-only."""
    environment = {"NUMBA_CACHE_DIR": str(small / "named")} if named == "named" else {}
    assert run(small, **environment) == (COMPILED, "")
    lock(*(path for path in small.rglob("*") if path.is_dir()))
    assert run(small, NO_TEMPORARY + PROGRAM, **environment) == (READ, "")


DAMAGES = {
    "empty": lambda content: b"",
    "one byte": lambda content: content[:1],
    "cut at the sum": lambda content: content[:32],
    "half": lambda content: content[: len(content) // 2],
    "one byte short": lambda content: content[:-1],
    "one byte long": lambda content: content + b"\0",
    "zeros": lambda content: bytes(len(content)),
    "zeros at the end": lambda content: content[:-4096] + bytes(4096),
    "one bit": lambda content: content[:900] + bytes([content[900] ^ 1]) + content[901:],
    "text": lambda content: b"no machine code",
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_damaged_files_are_written_again(small, damage):
    assert run(small) == (COMPILED, "")
    whole = {path: path.read_bytes() for path in files(small)}
    for path, content in whole.items():
        path.write_bytes(DAMAGES[damage](content))
    assert run(small) == (COMPILED, "")
    assert run(small) == (READ, "")


def test_files_that_are_exchanged_are_noticed(small):
    """Numba numbers its files, so two processes at once could leave one function's code under another's name."""
    run(small)
    one, other = files(small)
    content = one.read_bytes()
    one.write_bytes(other.read_bytes())
    other.write_bytes(content)
    assert run(small) == (COMPILED, "")
    assert run(small) == (READ, "")


def test_a_folder_in_a_files_place_is_passed_over(small):
    run(small)
    for path in files(small):
        path.unlink()
        path.mkdir()
    answer, said = run(small)
    assert answer == COMPILED
    assert "Traceback" not in said


def test_a_changed_source_leaves_no_old_files(small):
    run(small)
    before = files(small)
    source = small / "site" / "small_kernels" / "numbers.py"
    source.write_text(source.read_text() + "\n# changed\n")
    assert run(small) == (COMPILED, "")
    assert len(files(small)) == 2
    assert not set(files(small)) & set(before)


def limited_files(size: int) -> str:
    return f"import resource; resource.setrlimit(resource.RLIMIT_FSIZE, ({size}, {size}))\n"


def test_files_cannot_grow(small):
    """A quota, as the system tells it: a file is cut short while it is written."""
    assert resource.RLIM_INFINITY
    answer, said = run(small, limited_files(2000) + PROGRAM)
    assert (answer, warnings_in(said)) == (COMPILED, 1)
    assert "File too large" in said
    assert not [path for path in small.rglob("*") if path.is_file() and path.suffix != ".py"]
    assert run(small) == (COMPILED, "")


def test_a_full_disk(small):
    """A file system of 4 KiB, really full."""
    tiny = small / "tiny"
    tiny.mkdir()
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=4k", "none", str(tiny)], capture_output=True)
    if mounted.returncode:
        pytest.skip("no file system can be mounted here")
    try:
        for _ in range(2):
            answer, said = run(small, NUMBA_CACHE_DIR=str(tiny))
            assert (answer, warnings_in(said)) == (COMPILED, 1)
            assert "No space left on device" in said
        assert not [path for path in tiny.rglob("*") if path.is_file()]
    finally:
        subprocess.run(["umount", str(tiny)], check=True)


@pytest.fixture
def installed(small):
    """A read-only copy of the whole package."""
    copied = small / "installed"
    shutil.copytree(PACKAGE, copied / "srs_ik", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(PACKAGE.parent / "robots", copied / "srs_ik" / "robots")
    lock(*(path for path in (copied, *copied.rglob("*")) if path.is_dir()), small / "home", small / "site")
    return copied


def test_the_command_line_works_where_nothing_may_be_written(small, installed):
    program = NO_TEMPORARY + "import sys; sys.argv[1:] = ['inspect', 'iiwa14']\nfrom srs_ik.cli import main\nmain()"
    printed, said = run(small, program, PYTHONPATH=str(installed), MPLCONFIGDIR=str(small / "temporary"))
    assert "iiwa" in printed
    assert said.startswith("srs-ik: compiled kernels cannot be kept")
    assert said.count("\n") == 1
