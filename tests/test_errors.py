import copy
import json
import os
import pickle
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import srs_ik
from srs_ik import errors

ROOT = Path(__file__).resolve().parents[1]

EVERY_ERROR = [
    (errors.SrsIkError("something is wrong"), {}),
    (errors.InvalidRobot("arm.urdf: it is empty", source="arm.urdf"), {"source": "arm.urdf"}),
    (
        errors.FrameNotFound("tool", ["base", "tool0"], robot="arm"),
        {"frame": "tool", "available": ("base", "tool0")},
    ),
    (
        errors.NotAnSrsLimb("no limb", joint_names=["a", "b"], misses_mm=[0.0, 1.5], allowed_mm=1),
        {"joint_names": ("a", "b"), "misses_mm": (0.0, 1.5), "allowed_mm": 1.0},
    ),
    (
        errors.AmbiguousLimb("two arms", candidates=[("l0", "l7"), ("r0", "r7")]),
        {"candidates": (("l0", "l7"), ("r0", "r7"))},
    ),
    (errors.MissingExtra("robots", "the robot 'human_left'"), {"extra": "robots"}),
    (errors.MissingLimits("effort", ["j1", "j3"], "arm"), {"kind": "effort", "joints": ("j1", "j3")}),
    (errors.InvalidPose("a pose is 4x4"), {}),
    (errors.InvalidConfiguration("q has 7 angles"), {}),
    (errors.InvalidController("law A is not passive"), {}),
    (errors.InvalidTask("a direction has no length"), {}),
    (errors.InvalidMap("the store is of another robot"), {}),
    (errors.InvalidScene("a box has no size"), {}),
    (errors.NoBodies("the description has no shapes"), {}),
    (errors.PreviewError("the preview is closed"), {}),
]


def test_every_error_of_the_module_is_in_this_test():
    declared = {cls for cls in vars(errors).values() if isinstance(cls, type) and issubclass(cls, Exception)}
    assert {type(error) for error, _ in EVERY_ERROR} == declared


@pytest.mark.parametrize(("error", "fields"), EVERY_ERROR, ids=lambda value: type(value).__name__)
def test_errors_carry_their_fields_and_survive_pickle_and_copy(error, fields):
    for again in (error, pickle.loads(pickle.dumps(error)), copy.copy(error)):
        assert type(again) is type(error)
        assert isinstance(again, errors.SrsIkError)
        assert str(again) == str(error)
        assert vars(again) == fields


@pytest.mark.parametrize(("error", "fields"), EVERY_ERROR, ids=lambda value: type(value).__name__)
def test_messages_are_one_line(error, fields):
    assert "\n" not in str(error)


@pytest.mark.parametrize(
    "cls", [errors.InvalidPose, errors.InvalidConfiguration, errors.InvalidScene, errors.InvalidTask]
)
def test_malformed_input_is_also_a_value_error(cls):
    with pytest.raises(ValueError, match="wrong shape"):
        raise cls("wrong shape")


def test_frame_not_found_offers_the_frame_that_was_meant_and_lists_the_others():
    message = str(errors.FrameNotFound("Tool_O", ["base_link", "tool_0", "camera"], robot="arm"))
    assert "'Tool_O' in robot 'arm' (did you mean 'tool_0'?)" in message
    assert "base_link, tool_0, camera" in message


@pytest.mark.parametrize(
    ("asked", "offered"),
    [
        ("base_link", ""),  # as like to 'iiwa_link_7' as to 'iiwa_link_0'
        ("ee_link", ""),
        ("link", ""),
        ("link_7", " (did you mean 'iiwa_link_7'?)"),
        ("tool0", " (did you mean 'tool0_joint'?)"),
        ("tol0_joint", " (did you mean 'tool0_joint'?)"),
    ],
)
def test_frames_are_offered_only_where_their_own_part_of_the_name_is_alike(asked, offered):
    names = [*(f"iiwa_link_{k}" for k in range(8)), "iiwa_link_ee", "tool0_joint"]
    assert str(errors.FrameNotFound(asked, names)).startswith(f"there is no frame {asked!r}{offered};")


def test_a_long_list_of_frames_is_cut_in_the_message_but_whole_in_the_field():
    names = [f"frame_{i}" for i in range(500)]
    error = errors.FrameNotFound("zzz", names)
    assert error.available == tuple(names)
    assert "frame_39" in str(error)
    assert "frame_40" not in str(error)
    assert "460 more" in str(error)


def test_what_a_message_quotes_does_not_break_its_line():
    assert str(errors.SrsIkError("not [[0]\n [1]]")) == "not [[0] [1]]"


def test_nothing_is_offered_where_nothing_is_close():
    assert errors.did_you_mean("qqq", ["base_link"]) == ""


def test_missing_extra_gives_the_command_that_brings_it_to_the_checkout():
    error = errors.MissingExtra("robots", "this robot")
    assert str(error) == f"this robot needs an optional part of srs_ik: {error.command}"
    *command, requirement = shlex.split(error.command)
    assert command == ["pip", "install", "-e"]
    assert requirement == f"{ROOT}[robots]"


WITHOUT_KERNELS = "import sys; sys.modules['numba'] = None\n"


@pytest.mark.parametrize("terminal", [False, True])
@pytest.mark.parametrize("words", ["solve iiwa14 --xyz .5 .1 .6 --rpy 0 1.57 0", "warm"])
def test_without_kernels_and_numba_the_command_line_names_what_is_missing(words, terminal):
    """One line and exit status 2: 1 would say that the pose has no solution."""
    words = ["srs-ik", *words.split()]
    program = f"sys.argv = {words!r}\nsys.stderr.isatty = lambda: {terminal}\nfrom srs_ik.cli import main\nmain()"
    done = without_kernels(program)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("srs-ik: srs_ik has no compiled kernels here, and no Numba to compile them")
    assert done.stderr.endswith(f": {errors.install_command('jit')}\n")
    assert done.stderr.count("\n") == 1


def test_without_kernels_and_numba_python_raises_missing_extra():
    program = """
import srs_ik
for kind in (srs_ik.MissingExtra, ImportError):
    try:
        srs_ik.load("iiwa14")
    except kind as error:
        print(error.extra)
"""
    done = without_kernels(program)
    assert (done.stdout, done.stderr) == ("jit\njit\n", "")


def without_kernels(program):
    """A program in this checkout whose compiled kernels are left out, and that finds no Numba."""
    environment = {**os.environ, "SRS_IK_JIT": "1", "PYTHONPATH": str(ROOT)}
    environment.pop("NUMBA_DISABLE_JIT", None)
    command = [sys.executable, "-c", WITHOUT_KERNELS + program]
    return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=60)


def test_every_extra_that_is_asked_for_is_one_of_the_project():
    asked = {
        extra
        for path in (ROOT / "srs_ik").rglob("*.py")
        for extra in re.findall(r'MissingExtra\("(\w+)"', path.read_text())
    }
    known = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    assert len(asked) >= 4
    assert asked <= set(known)


@pytest.mark.parametrize(
    ("record", "expected"),
    [
        (None, "pip install 'srs-ik[plot]'"),
        ("no JSON", "pip install 'srs-ik[plot]'"),
        ({"url": "https://example.org/srs_ik.whl", "archive_info": {}}, "pip install 'srs-ik[plot]'"),
        ({"url": "FOLDER/gone", "dir_info": {}}, "pip install 'srs-ik[plot]'"),
        ({"url": "FOLDER/a%20checkout", "dir_info": {}}, "pip install 'FOLDER/a checkout[plot]'"),
    ],
)
def test_the_command_is_that_of_the_folder_it_was_installed_from(tmp_path, monkeypatch, record, expected):
    site = tmp_path / "site"
    (site / "srs_ik-9.dist-info").mkdir(parents=True)
    (site / "srs_ik-9.dist-info" / "METADATA").write_text("Metadata-Version: 2.1\nName: srs-ik\nVersion: 9\n")
    (tmp_path / "a checkout").mkdir()
    (tmp_path / "a checkout" / "pyproject.toml").touch()
    if record is not None:
        text = record if isinstance(record, str) else json.dumps(record).replace("FOLDER", tmp_path.as_uri())
        (site / "srs_ik-9.dist-info" / "direct_url.json").write_text(text)
    monkeypatch.syspath_prepend(site)
    assert errors.install_command("plot", site / "srs_ik") == expected.replace("FOLDER", str(tmp_path))


@pytest.mark.parametrize(("name", "home"), [("plot_intervals", "plots"), ("FollowingPreview", "preview")])
def test_a_name_of_another_room_is_told_where_it_is(name, home):
    with pytest.raises(AttributeError, match=f"it is srs_ik.{home}.{name}$"):
        getattr(srs_ik, name)
