"""Kernels compiled ahead of time: their table, and what is made of it, against Numba and a C compiler."""

import ast
import ctypes
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import srs_ik
from srs_ik.bench import exercise
from srs_ik.kernels import entries, native, sources
from srs_ik.kernels.ahead import build, glue
from srs_ik.kernels.ahead.signatures import read_table, rooms

ROOT = Path(__file__).resolve().parents[1]
ROBOTS = ("iiwa14", "gen3")


def entries_in_source() -> dict[str, tuple[str, ...]]:
    """Names and arguments of all functions below `@entry`, as their files say."""
    found = {}
    for room in rooms():
        tree = ast.parse((ROOT / "srs_ik/kernels/entries" / f"{room}.py").read_text())
        for node in tree.body:
            if isinstance(node, ast.FunctionDef) and any(ast.unparse(d) == "entry" for d in node.decorator_list):
                found[f"{room}.{node.name}"] = tuple(argument.arg for argument in node.args.args)
    assert len(found) > 30
    return found


def test_the_table_names_every_entry_and_its_arguments():
    table = {f"{e.room}.{e.name}": tuple(a.name for a in e.arguments) for e in read_table()}
    missing = sorted(entries_in_source().keys() - table)
    assert not missing, f"entries/table.py needs a line for {', '.join(missing)}"
    assert table == entries_in_source()


def test_a_line_that_cannot_be_read_is_named():
    for line in ("solve(x: float)", "pose.solve(x: number)", "pose.solve(never_heard_of)"):
        with pytest.raises(ValueError, match=r"no (entry|argument)"):
            read_table(line)


def test_a_line_of_the_table_tells_arguments_sizes_and_results():
    (entry,) = read_table("pose.solve(seed, respect, out: float[n, ROW]&) -> int")
    assert [a.name for a in entry.arguments] == ["seed", "respect", "out"]
    assert [a.written for a in entry.arguments] == [False, False, True]
    assert (entry.sizes, entry.results) == (("n",), ("int",))
    assert entry.arguments[-1].shape == ("n", 13)


@pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")
@pytest.mark.parametrize("language", ["c", "c++"])
def test_the_header_is_plain_c_and_cpp(tmp_path, language):
    (tmp_path / "srs_ik.h").write_text(glue.header(read_table()))
    (tmp_path / "user.c").write_text('#include "srs_ik.h"\n')
    command = ["cc", "-x", language, "-fsyntax-only", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "user.c"]
    subprocess.run(command, cwd=tmp_path, check=True)


@pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")
def test_figures_of_the_header_are_those_of_the_layouts(tmp_path):
    (tmp_path / "srs_ik.h").write_text(glue.header(read_table()))
    names = ["ANSWER_FARTHEST", "SEARCH_REFUSED", "PATH_IMPOSSIBLE", "ANSWER_ROW", "ANSWER_TOO_FAR"]
    values = ", ".join(f"(double)SRS_IK_{name}" for name in names)
    (tmp_path / "user.c").write_text(
        '#include "srs_ik.h"\n#include <stdio.h>\n'
        f"int main(void) {{ double all[] = {{{values}}};"
        f'for (int i = 0; i < {len(names)}; i++) printf("%.17g ", all[i]); }}'
    )
    subprocess.run(["cc", "-Wall", "-Wpedantic", "-Werror", "user.c", "-o", "user"], cwd=tmp_path, check=True)
    said = subprocess.run([tmp_path / "user"], capture_output=True, text=True, check=True).stdout.split()
    layouts = {name: import_module(f"srs_ik.kernels.layout.{name.split('_')[0].lower()}") for name in names}
    assert [float(x) for x in said] == [getattr(layouts[name], name.partition("_")[2]) for name in names]


def numba_kind(kind) -> str:
    """A type as Numba compiled for it, without what makes no other code: whether an array may be written to."""
    from numba import types

    return str(kind.copy(readonly=False)) if isinstance(kind, types.Array) else str(types.unliteral(kind))


ALL = os.environ.get("SRS_IK_JIT") == "all"
"""Whether Numba is to compile the searches too, which takes it half an hour."""

QUICK = (
    "free splits",
    "posture for a task",
    "postures for tasks",
    "forward kinematics, batch",
    "Jacobian, batch",
    "arm angle",
    "arm angle's Jacobian",
    "self-motion tangent",
    "yardstick",
)


@pytest.mark.slow
@pytest.mark.jit
@pytest.mark.parametrize("robot", ROBOTS)
def test_what_numba_compiles_for_every_question_is_in_the_table(robot):
    """Numba sees the arguments of each call; the table has to name them all, and the results."""
    from srs_ik.kernels.ahead.frontend import _ELEMENTS, numba_type

    for name, call in exercise.calls(srs_ik.load(robot)).items():
        if ALL or name in QUICK:
            call()
    seen = 0
    for entry in read_table():
        dispatcher = getattr(import_module(f"{entries.__name__}.{entry.room}"), entry.name)
        known = tuple(numba_kind(numba_type(a)) for a in entry.arguments)
        for compiled in dispatcher.overloads.values():
            assert tuple(map(numba_kind, compiled.signature.args)) == known, f"{entry.room}.{entry.name}"
            result = compiled.signature.return_type
            found = tuple(result) if hasattr(result, "__iter__") else () if str(result) == "none" else (result,)
            assert found == tuple(_ELEMENTS[each] for each in entry.results)
            seen += 1
    assert seen > (30 if ALL else 10)


# Of what follows, everything runs on compiled kernels, in a copy of the package as a wheel would install it.


def run_here(program: str) -> subprocess.CompletedProcess[bytes]:
    """Run a program in this checkout, on compiled kernels if it has them."""
    clean = {name: value for name, value in os.environ.items() if name not in ("SRS_IK_JIT", "NUMBA_DISABLE_JIT")}
    return subprocess.run([sys.executable, "-c", program], env={**clean, "PYTHONPATH": str(ROOT)})


@pytest.fixture(scope="module")
def installed(request, tmp_path_factory) -> Path:
    """A folder with the package and its compiled kernels; they are compiled again where a source has changed."""
    tools = b"".join(
        path.read_bytes() for path in sorted((ROOT / "srs_ik/kernels/ahead").glob("*.[pch]*")) if path.is_file()
    )
    stamp = hashlib.sha256(sources.digest_of_all(native.KERNELS).encode() + tools).hexdigest()[:16]
    made = request.config.cache.mkdir("compiled_kernels") / stamp
    if run_here("import sys; from srs_ik.kernels import native; sys.exit(not native.all_compiled())").returncode == 0:
        made = native.FOLDER
    elif not (made / "srs_ik.h").is_file():
        shutil.rmtree(made.parent, ignore_errors=True)
        environment = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONHASHSEED": "0"}
        subprocess.run([sys.executable, "-m", "srs_ik.kernels.ahead.build", str(made)], check=True, env=environment)
    folder = tmp_path_factory.mktemp("installed")
    left_out = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "srs_ik", folder / "srs_ik", ignore=left_out)
    shutil.copytree(ROOT / "robots", folder / "srs_ik" / "robots", ignore=left_out)
    for path in [*made.glob("*.so"), *made.glob("*.h")]:
        shutil.copy(path, folder / "srs_ik" / "kernels" / "native")
    return folder


WITHOUT_NUMBA = "import sys; sys.modules['numba'] = sys.modules['llvmlite'] = None\n"


def run_installed(installed: Path, program: str, *words: str, **environment: str) -> str:
    """What a program prints that runs on the compiled kernels, with no Numba to be had."""
    clean = {name: value for name, value in os.environ.items() if not name.startswith(("SRS_IK", "NUMBA", "PYTHON"))}
    return subprocess.run(
        [sys.executable, "-c", WITHOUT_NUMBA + program, *words],
        cwd=installed,
        env={**clean, "PYTHONPATH": str(installed), **environment},
        capture_output=True,
        text=True,
        check=True,
        timeout=1200,
    ).stdout


ANSWERS = """
import json
import numpy as np
import srs_ik
from srs_ik.bench.work import Work

def figures(answer):
    return np.nan_to_num(np.asarray(answer, dtype=float)).ravel().tolist()

def answers(robot, *names):
    arm = srs_ik.load(robot)
    w = Work.of(arm, 40)
    far = np.roll(w.q, 1, axis=0)
    way = np.array([arm.forward_kinematics(w.q[0] + 0.02 * i).homogeneous for i in range(12)])
    task = srs_ik.Task([0.4, 0.2, 0.5], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0])
    found = {
        "margin": lambda: arm.solve_batch(w.poses).q,
        "seeded": lambda: arm.solve_batch(w.poses, seed=w.seeds).q,
        "far seeds": lambda: arm.solve_batch(w.poses, seed=far).status,
        "arm angles": lambda: arm.solve_batch(w.poses, w.arm_angles).q,
        "branches": lambda: arm.solve_batch(w.poses, w.arm_angles, all_branches=True).status,
        "intervals": lambda: [x for i in arm.intervals_batch(w.poses) for each in i for x in (each.lower, each.upper)],
        "all": lambda: [len(arm.solve_all(pose)) for pose in w.poses],
        "optimum": lambda: [arm.optimise(pose, "manipulability").value for pose in w.poses[:6]],
        "function": lambda: [arm.optimise(pose, lambda q: float(q @ q)).value for pose in w.poses[:3]],
        "path": lambda: arm.solve_path(way, seed=w.q[0]).q,
        "posture": lambda: [arm.posture(task).arm_angle],
        "kinematics": lambda: [arm.forward_kinematics_batch(w.q), ],
        "tangent": lambda: arm.self_motion_tangent(w.q[0]),
        "gradient": lambda: arm.arm_angle_jacobian(w.q[0]),
    }
    return {name: figures(found[name]()) for name in names or found}
"""
PRINT_ANSWERS = ANSWERS + "\nimport sys; print(json.dumps(answers(*sys.argv[1:])))"


def answers_of(installed: Path, robot: str, *names: str, **environment: str) -> dict[str, np.ndarray]:
    printed = json.loads(run_installed(installed, PRINT_ANSWERS, robot, *names, **environment))
    return {name: np.array(value) for name, value in printed.items()}


def same(found: dict[str, np.ndarray], expected: dict[str, np.ndarray]) -> None:
    """Equal within rounding: 1e-8 rad or m, a thousandth of what any answer is used to; postures of optima are flat."""
    assert found.keys() == expected.keys()
    for name, value in expected.items():
        assert value.size
        np.testing.assert_allclose(found[name], value, rtol=1e-8, atol=1e-8, err_msg=name)


@pytest.mark.jit
@pytest.mark.parametrize("robot", ROBOTS)
def test_compiled_ahead_and_compiled_by_numba_give_the_same_answers(installed, robot):
    here: dict = {}
    exec(ANSWERS, here)
    names = () if ALL else ("kinematics", "tangent", "gradient", "posture")
    expected = {name: np.array(value) for name, value in here["answers"](robot, *names).items()}
    assert native.extension() is None
    same(answers_of(installed, robot, *names), expected)


TARGET = "from srs_ik.kernels.native import extension; print(extension().target())"


@pytest.mark.skipif(len(build.targets()) < 2, reason="one kind of processor")
@pytest.mark.parametrize("robot", ROBOTS)
def test_machines_without_wide_registers_give_the_same_answers(installed, robot):
    least = build.targets()[0][0]
    if run_installed(installed, TARGET, SRS_IK_TARGET=least) != f"{least}\n":
        assert os.environ.get("SRS_IK_BUILD") != "portable"
        pytest.skip(
            "compiled for this kind of processor alone: SRS_IK_BUILD=portable python -m srs_ik.kernels.ahead.build"
        )
    same(answers_of(installed, robot, SRS_IK_TARGET=least), answers_of(installed, robot))


def test_a_kind_of_processor_that_the_kernels_lack_is_warned_of(installed):
    program = f"import warnings; warnings.simplefilter('error'); {TARGET}"
    with pytest.raises(subprocess.CalledProcessError) as refused:
        run_installed(installed, program, SRS_IK_TARGET="z80")
    assert "RuntimeWarning: SRS_IK_TARGET=z80 changes nothing" in refused.value.stderr


def build_of_one_room(folder: Path, program: str, **environment: str) -> None:
    """Compile the entries of kinematics into a folder, by a program that says for what."""
    program = f"""
from pathlib import Path
from srs_ik.kernels.ahead import build
from srs_ik.kernels.ahead.signatures import read_table
entries = tuple(entry for entry in read_table() if entry.room == "kinematics")
if __name__ == "__main__":
    {program}
    build.build(Path({str(folder)!r}), entries, kinds)
"""
    path = folder.with_suffix(".py")
    path.write_text(program)
    numbers = {"PYTHONPATH": str(ROOT), "PYTHONHASHSEED": "0", "SRS_IK_JIT": "1"}
    subprocess.run([sys.executable, str(path)], check=True, env={**os.environ, **numbers, **environment})


def test_kernels_for_another_processor_say_so_in_one_line(installed, tmp_path):
    """As in an image that was built elsewhere: the only kind that was compiled for is one that this machine lacks."""
    made = tmp_path / "made"
    build_of_one_room(made, "kinds = ((build.targets()[0][0], 'false'),)")
    copy = tmp_path / "copy"
    shutil.copytree(installed, copy, ignore=shutil.ignore_patterns("__pycache__", "*.so"))
    for path in made.glob("*.so"):
        shutil.copy(path, copy / "srs_ik" / "kernels" / "native")
    program = "try:\n    import srs_ik.arm\nexcept ImportError as error:\n    print(error)"
    said = run_installed(copy, program)
    assert said.count("\n") == 1
    assert f"for {build.targets()[0][0]}, which this processor is not" in said
    assert "SRS_IK_BUILD=portable" in said
    assert re.search(r"pip install \S*\[jit\]'", said)
    program = f"import sys; sys.path.insert(0, {str(copy)!r}); import srs_ik.arm"
    clean = {name: value for name, value in os.environ.items() if not name.startswith(("SRS_IK", "PYTHON"))}
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=copy, env=clean, capture_output=True, text=True, check=True
    )
    assert done.stderr.count(": RuntimeWarning: ") == 1
    assert "until then Numba compiles what is called" in done.stderr


def test_this_machine_is_of_its_own_kind(installed):
    names = [name for name, _ in build.targets()]
    assert run_installed(installed, TARGET) == f"{build.own_kind()[0] if len(names) > 1 else names[0]}\n"


@pytest.mark.parametrize(("asked", "count"), [("", 1), ("portable", len(build.targets()))])
def test_a_build_is_for_this_machine_unless_it_is_to_be_handed_on(monkeypatch, asked, count):
    monkeypatch.setenv("SRS_IK_BUILD", asked)
    kinds = build.targets(portable=build.is_portable())
    assert len(kinds) == count
    assert set(kinds) <= set(build.targets())


def test_a_build_for_something_unknown_is_refused(monkeypatch):
    monkeypatch.setenv("SRS_IK_BUILD", "everything")
    with pytest.raises(ValueError, match="SRS_IK_BUILD is portable or pure, not everything"):
        build.is_portable()


@pytest.mark.parametrize("robot", ROBOTS)
def test_every_question_is_answered_without_numba(installed, robot):
    program = "from srs_ik.bench.exercise import first_calls; first_calls(sys.argv[1])"
    assert run_installed(installed, program, robot).count("\n") == 35


KEPT = """
import ctypes
import gc
import sys
import srs_ik
from srs_ik.bench.exercise import calls

class Blocks(ctypes.Structure):
    _fields_ = [(f"field_{i}", ctypes.c_size_t) for i in range(10)]

ask = ctypes.CDLL(None).mallinfo2
ask.restype = Blocks

def allocated():
    blocks = ask()
    return blocks.field_4 + blocks.field_7  # in pages of their own, and in the heap

for name, call in calls(srs_ik.load(sys.argv[1])).items():
    grown = []
    for _ in range(4):
        before = allocated()
        for _ in range(10):
            call()
        gc.collect()
        grown.append(allocated() - before)
    print(min(grown), name)
"""


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(ctypes.CDLL(None), "mallinfo2"), reason="glibc 2.33 or newer tells what is allocated")
@pytest.mark.parametrize("robot", ROBOTS)
def test_kernels_give_back_what_they_allocate(installed, robot):
    grown = [line.split(" ", 1) for line in run_installed(installed, KEPT, robot, MALLOC_ARENA_MAX="1").splitlines()]
    assert len(grown) == 34
    # Python keeps a little now and then. What a kernel keeps grows in every round of ten calls, by 64 bytes a call.
    assert [(name, count) for count, name in grown if int(count) >= 10 * 64] == []


FIRST = """
import srs_ik
from srs_ik.kernels.native import at_work
arm = srs_ik.load("gen3")
pose = arm.forward_kinematics([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
assert arm.solve(pose) and arm.intervals(pose) and arm.optimise(pose, "manipulability")
print(at_work())
"""


def test_four_processes_at_once_in_a_read_only_place_without_a_home(installed):
    for path in (installed, *installed.rglob("*")):
        path.chmod(path.stat().st_mode & ~0o222)
    before = set(installed.rglob("*"))
    environment = {"PATH": os.environ["PATH"], "PYTHONPATH": str(installed), "HOME": "/nowhere"}
    command = [sys.executable, "-W", "error", "-c", WITHOUT_NUMBA + FIRST]
    started = [
        subprocess.Popen(command, cwd="/", env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        for _ in range(4)
    ]
    said = [process.communicate(timeout=1200) for process in started]
    for path in (installed, *installed.rglob("*")):
        path.chmod(path.stat().st_mode | 0o200)
    assert all(out.startswith("compiled when the package was built") and not err for out, err in said), said
    assert {path for path in installed.rglob("*") if path.suffix != ".pyc" and path.name != "__pycache__"} <= before


def test_a_kernel_that_was_edited_since_is_not_answered_by_what_was_compiled(installed, tmp_path):
    copy = tmp_path / "edited"
    shutil.copytree(installed, copy, ignore=shutil.ignore_patterns("__pycache__"))
    path = copy / "srs_ik/kernels/limb/triangle.py"
    path.write_text(path.read_text() + "\n# edited\n")
    asked = "from srs_ik.kernels import native; print(*map(native.is_compiled, ('pose', 'maps', 'yardstick')))"
    assert run_installed(installed, asked) == "True True True\n"
    assert run_installed(copy, asked) == "False False True\n"


def test_by_numba_on_demand_and_a_clear_line_where_there_is_none(installed):
    program = "from srs_ik.kernels.native import at_work; print(at_work())"
    assert run_installed(installed, program, SRS_IK_JIT="1") == "compiled by Numba when first needed\n"
    program = "try:\n    import srs_ik.arm\nexcept ImportError as error:\n    print(error)"
    said = run_installed(installed, program, SRS_IK_JIT="1")
    assert re.search(r"pip install \S*\[jit\]'", said)
    assert said.count("\n") == 1


def test_version_tells_which_kernels_are_at_work(installed):
    program = "from srs_ik.cli import main; sys.argv = ['srs-ik', '--version', '--verbose']; main()"
    version, kernels = run_installed(installed, program).splitlines()
    assert version == srs_ik.__version__
    assert kernels.startswith("kernels: compiled when the package was built, for ")


WRONG = """
import numpy as np
from srs_ik.kernels.native import extension
e = extension()
good = np.zeros((4, 4)); good[3, 3] = 1
for wrong in (None, 1.0, [1], np.zeros(16), np.zeros((4, 4), np.float32), np.zeros((4, 4), order="F")[:, ::-1]):
    try:
        e.pose_check_pose(wrong)
    except TypeError as error:
        assert str(error).startswith("check_pose: T must be float[4, 4] in C order"), error
    else:
        raise AssertionError(wrong)
frozen = np.zeros(7); frozen.flags.writeable = False
for arguments in ((np.zeros((4, 247)), np.zeros(7), frozen), (np.zeros((4, 247)),), ()):
    try:
        e.kinematics_arm_angle_jacobian(*arguments)
    except TypeError:
        continue
    raise AssertionError(arguments)
class Own(np.ndarray): pass
assert e.pose_check_pose(good.view(Own)) == e.pose_check_pose(good)
print("ok")
"""


def test_arguments_that_are_not_those_of_the_table_are_refused(installed):
    assert run_installed(installed, WRONG) == "ok\n"


LOCK = """
import threading
import numpy as np
import srs_ik
arm = srs_ik.load("iiwa14")
poses = np.tile(arm.forward_kinematics(np.full(7, 0.4)).homogeneous, (20_000, 1, 1))
done = threading.Event()
count = [0]
def tick():
    while not done.wait(0.001):
        count[0] += 1
ticker = threading.Thread(target=tick)
ticker.start()
from srs_ik.kernels.entries import pose
out, verdicts = np.empty((len(poses), 13)), np.zeros(len(poses), np.int8)
seeds = np.random.default_rng(0).uniform(-1, 1, (len(poses), 7))
before = count[0]
pose.solve_range(arm.packed.family, poses, 0, len(poses), -1, seeds, True, out, verdicts)
during = count[0] - before
done.set()
print(during)
"""


def test_other_threads_of_python_run_during_a_call(installed):
    """One call of some 100 ms, in which another thread wakes every millisecond; with the lock held it would not."""
    assert int(run_installed(installed, LOCK)) >= 3


BY_PYTHON = """
import json, sys
import srs_ik
arm = srs_ik.load(sys.argv[1])
q = [0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2]
pose = arm.forward_kinematics(q)
ends = [(i.branch, i.lower, i.upper) for i in arm.intervals(pose)]
best = arm.optimise(pose, "force_velocity_ratio", force=[0, 0, 2.0], velocity=[3.0, 0, 0])
print(json.dumps({"q": arm.solve(pose, seed=q).q.tolist(), "ends": ends, "best": [best.value, best.arm_angle]}))
"""


@pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")
@pytest.mark.parametrize("robot", ROBOTS)
def test_the_c_example_gives_the_same_answers(installed, tmp_path, robot):
    limb = tmp_path / "robot.limb"
    command = "from srs_ik.cli import main; main()"
    run_installed(installed, f"sys.argv = ['srs-ik', 'inspect', {robot!r}, '--packed', {str(limb)!r}]; {command}")
    flags = run_installed(installed, "from srs_ik.kernels.native.__main__ import main; main(sys.argv[1:])").split()
    program = tmp_path / "solve"
    options = ["-std=c11", "-Wall", "-Wextra", "-Werror"]
    subprocess.run(["cc", *options, str(ROOT / "examples/solve.c"), *flags, "-o", str(program)], check=True)
    first, second, *rows, least, last = subprocess.run(
        [str(program), str(limb)], check=True, capture_output=True, text=True
    ).stdout.splitlines()
    expected = json.loads(run_installed(installed, BY_PYTHON, robot))
    status, *angles = first.removeprefix("status ").replace(":", "").split()
    assert status == "0"
    np.testing.assert_allclose(np.array(angles, dtype=float), expected["q"], atol=1e-9)
    ends = expected["ends"]
    found = [
        [float(word) for word in row.replace("branch", "").replace("to", "").replace(":", "").split()] for row in rows
    ]
    assert second == f"{len(ends)} intervals"
    np.testing.assert_allclose(found, ends, atol=1e-9)
    value, angle = least.removeprefix("least ").split(" at arm angle ")
    assert float(value) == pytest.approx(expected["best"][0], abs=1e-9)
    # A minimum is flat: rounding of its value is this much of its place.
    assert float(angle) == pytest.approx(expected["best"][1], abs=1e-5)
    assert last.startswith("1000 of 1000 solved")
    no_limb = tmp_path / "no.limb"
    no_limb.write_bytes(limb.read_bytes()[:-1])
    assert subprocess.run([str(program), str(no_limb)], check=False, capture_output=True).returncode == 2


@pytest.mark.slow
def test_two_builds_of_a_room_give_the_same_objects(tmp_path):
    made = []
    for name in ("one", "two"):
        environment = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONHASHSEED": "0"}
        folder = tmp_path / name
        command = [sys.executable, "-m", "srs_ik.kernels.ahead.build", str(folder), "--room", "kinematics"]
        subprocess.run(command, check=True, env=environment)
        made.append({path.name: path.read_bytes() for path in folder.iterdir()})
    assert made[0] == made[1]
    assert len(made[0]) == 3
