"""Files that are made to use up time and memory, each in a process of its own, and made-up files in great number."""

import subprocess
import sys
import time

import pytest
from fuzz_grammar import Watched, verdict_of
from grammar import BOMB, made
from robot_files import joint_xml, robot_xml, serial_arm

import srs_ik
from srs_ik import InvalidRobot
from srs_ik.errors import did_you_mean, listed, quoted
from srs_ik.loading.adapter import write_adapter
from srs_ik.system import bounds

ARM = f'<robot name="small">{serial_arm()}</robot>'
LONG = "x" * 900

MEASURE = """
import resource, sys, time
import srs_ik
from srs_ik.robot.description import load_model
def peak(): return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
try: srs_ik.load("nothing.urdf")
except srs_ik.InvalidRobot: pass
before, start = peak(), time.process_time()
try: srs_ik.find_limbs(sys.argv[1]); said = ""
except srs_ik.InvalidRobot as error: said = str(error)
print(time.process_time() - start, (peak() - before) / 1024, said)
"""

GREEDY = {
    "a dotted key.toml": ("a." * 30_000 + "a = 1", "a key of more than 8 parts"),
    "a quoted dotted key.toml": ('"a"."b".' * 8_000 + "a = 1", "a key of more than 8 parts"),
    "a text without end.toml": ('name = "' + '\\"' * 30_000, "is not valid TOML"),
    "a bomb.urdf": (BOMB + f']><robot name="&l;{"&k;" * 100_000}"/>', "<!DOCTYPE>"),
    "a bomb after a comment.urdf": (
        f"<!--{'x' * 6_000_000}-->" + BOMB + f']><robot name="&l;{"&k;" * 100_000}"/>',
        "<!DOCTYPE>",
    ),
    "a bomb.xml": (BOMB + f']><mujoco model="&l;{"&k;" * 100_000}"/>', "<!DOCTYPE>"),
    "many bodies.xml": ("<mujoco><worldbody>" + "<body/>" * 60_000 + "</worldbody></mujoco>", "bodies that are read"),
    "a long name.urdf": (robot_xml(links=f"a {'b' * 8_000_000}"), "a name of 8000000"),
    "names that are nearly known.urdf": (
        robot_xml(
            *(joint_xml(f"j{k}", "l0", f"{LONG}{k}") for k in range(150)),
            joint_xml("j", "l0", LONG),
            links=" ".join(["l0", *(f"{LONG}{k}" for k in range(1500))]),
        ),
        "is no link",
    ),
    "attributes.urdf": (
        "<robot " + " ".join(f'a{k}=""' for k in range(600_000)) + "/>",
        "an element of 1000 attributes or more",
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("case", GREEDY)
def test_greedy_files_are_refused_in_time_and_memory(case, tmp_path):
    text, says = GREEDY[case]
    path = tmp_path / case
    path.write_text(text)
    result = subprocess.run([sys.executable, "-c", MEASURE, str(path)], capture_output=True, text=True, timeout=600)
    seconds, megabytes, said = result.stdout.split(" ", 2)
    assert says in said
    assert len(said) < 2500
    assert float(megabytes) < 300
    assert float(seconds) < 2


@pytest.mark.parametrize("first", range(0, 300, 50))
def test_made_up_files_are_refused_or_solved(first, tmp_path):
    for seed in range(first, first + 50):
        assert verdict_of(made(seed), tmp_path) in ("refused", "no limb", "solved", "read"), f"seed {seed}"


@pytest.mark.slow
def test_made_up_files_come_far_and_depend_on_the_number_alone(tmp_path):
    files = [made(seed) for seed in range(200)]
    assert files == [made(seed) for seed in range(200)]
    assert {file.suffix for file in files} == {".urdf", ".xml", ".toml", ".srdf", ".xacro.urdf"}
    verdicts = [verdict_of(file, tmp_path) for file in files[:100]]
    assert verdicts.count("solved") > 15
    assert verdicts.count("refused") > 15


@pytest.mark.slow
def test_the_end_of_the_watched_process_would_be_noticed():
    watched = Watched(0, 5)
    assert watched.line(600.0).startswith("0 ")
    watched.process.kill()
    start = time.monotonic()
    while watched.line(30.0):
        assert time.monotonic() - start < 300
    watched.process.wait()


# Messages and arguments


def test_names_in_messages_are_cut_short():
    assert quoted("a" * 1000) == repr("a" * 77 + "...")
    assert len(quoted(["a" * 1000] * 1000)) <= bounds.SHOWN
    assert quoted(10**5000) == "an object of type int"
    assert len(listed(["a" * 1000] * 1000)) < 4000
    assert did_you_mean("a" * 1000, ["a" * 999]) == ""
    assert len(str(InvalidRobot("a" * 10**6))) <= 2000


class Odd:
    __hash__ = None

    def __repr__(self):
        raise RuntimeError

    def __eq__(self, other):
        raise RuntimeError


HUGE = 10**400


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"limb": 5}, "limb is text, not 5"),
        ({"base": 5}, "base is text, not 5"),
        ({"tip": Odd()}, "tip is text, not <Odd instance at"),
        ({"name": HUGE}, "name is text, not 1000"),
        ({"limits": 5}, "limits are given as {joint: {limit: figure}}, not as 5"),
        ({"limits": {5: {}}}, "limits are given for 5; the joints are j1, j2"),
        ({"limits": {"j1": {5: 5}}}, "joint 'j1' has no limit 5"),
        ({"limits": {"j1": {"lower": HUGE}}}, "lower of joint 'j1' must be a number, not 1000"),
        ({"limits": {"j1": {"lower": Odd()}}}, "lower of joint 'j1' must be a number, not <Odd instance at"),
        ({"srdf": 5}, "srdf is a path or text, not 5"),
        ({"srdf": b"x"}, "srdf is a path or text, not b'x'"),
        ({"xacro_args": 5}, "xacro_args are given as {name: text}, not as 5"),
        ({"xacro_args": {"a": 5}}, "xacro_args are given as {name: text}, not as {'a': 5}"),
    ],
)
def test_arguments_of_a_wrong_kind_are_refused_in_one_line(arguments, says):
    with pytest.raises(InvalidRobot) as raised:
        srs_ik.load(ARM, **arguments)
    assert says in str(raised.value)
    assert len(str(raised.value).splitlines()) == 1


@pytest.mark.parametrize("argument", ["path", "source"])
def test_an_adapter_is_written_to_a_path(argument, tmp_path):
    arm = srs_ik.load("iiwa14")
    given = {"path": tmp_path / "robot.toml", "source": "iiwa14", argument: 5}
    with pytest.raises(InvalidRobot, match=f"{argument} is a path or text, not 5"):
        write_adapter(given["path"], given["source"], arm)


@pytest.mark.parametrize("figure", ["1" + "0" * 400, "0x" + "F" * 4000])
@pytest.mark.parametrize("line", ["[tool]\nxyz = [0, 0, {}]", "[limits]\nj1 = {{ upper = {} }}"])
def test_whole_numbers_beyond_those_of_the_machine(figure, line, tmp_path):
    path = tmp_path / "robot.toml"
    (tmp_path / "arm.urdf").write_text(ARM)
    path.write_text(f'name = "a"\nurdf = "arm.urdf"\n[frames]\nbase = "l0"\ntip = "l7"\n{line.format(figure)}\n')
    with pytest.raises(InvalidRobot, match="is larger than numbers of the machine"):
        srs_ik.load(path)


@pytest.mark.parametrize("table", ["tool", "mount"])
def test_a_tool_out_of_any_reach(table, tmp_path):
    path = tmp_path / "robot.toml"
    (tmp_path / "arm.urdf").write_text(ARM)
    head = 'name = "a"\nurdf = "arm.urdf"\n[frames]\nbase = "l0"\ntip = "l7"\n'
    path.write_text(f"{head}[{table}]\nxyz = [0, 0, 2e6]\n")
    with pytest.raises(InvalidRobot, match=rf"\[{table}\] are metres and rad, and none is beyond 1e\+06"):
        srs_ik.load(path)


def test_an_adapter_is_whole_or_not_there(tmp_path, monkeypatch):
    """A disk that fills while it is written leaves nothing, and a file that is there stays as it is."""
    import os

    arm, path = srs_ik.load("iiwa14"), tmp_path / "robot.toml"

    def full(file):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", full)
        with pytest.raises(InvalidRobot, match=r"cannot write .*robot.toml: No space left on device"):
            write_adapter(path, "iiwa14", arm)
    assert list(tmp_path.iterdir()) == []
    write_adapter(path, "iiwa14", arm)
    written = path.read_text()
    with pytest.raises(InvalidRobot, match="exists already"):
        write_adapter(path, "iiwa14", srs_ik.load("gen3"))
    assert path.read_text() == written
    path.unlink()

    def without_links(source, target):
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(os, "link", without_links)
    write_adapter(path, "iiwa14", arm)
    with pytest.raises(InvalidRobot, match="exists already"):
        write_adapter(path, "iiwa14", arm)
    assert path.read_text() == written
    assert list(tmp_path.iterdir()) == [path]
