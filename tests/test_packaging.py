"""The promises that the project's own files make to one another."""

import os
import re
import runpy
import subprocess
import sys
import tempfile
import tomllib
from importlib import metadata
from pathlib import Path
from types import SimpleNamespace

import pytest
from build import ProjectBuilder
from build.env import DefaultIsolatedEnv

import srs_ik

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def project() -> dict:
    return tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def readme_command(name: str) -> str:
    match = re.search(rf"<!-- command: {name} -->\n```bash\n(.+?)\n```\n", (ROOT / "README.md").read_text(), re.DOTALL)
    assert match, f"README.md has no bash block under '<!-- command: {name} -->'"
    return match[1]


def test_readme_gives_the_two_commands_that_the_checks_run():
    begin = "pip install uv && uv pip install . || pip install . && srs-ik solve "
    assert readme_command("solve").startswith(begin)
    steps = readme_command("test").split(" && ")
    assert steps == ['pip install -e ".[test]"', "python -m srs_ik.kernels.ahead.build", "pytest -n auto"]


def test_installed_version_is_the_one_of_the_package():
    assert metadata.version("srs-ik") == srs_ik.__version__


def test_version_is_written_in_one_place_only(project):
    assert project["dynamic"] == ["version"]
    writers = [
        str(path.relative_to(ROOT))
        for path in [*ROOT.glob("srs_ik/**/*.py"), ROOT / "CITATION.cff", ROOT / "README.md", ROOT / "pyproject.toml"]
        if re.search(rf"(?m)^\W*(__)?version(__)?\W+{re.escape(srs_ik.__version__)}", path.read_text())
    ]
    assert writers == ["srs_ik/__init__.py"]


def test_core_dependencies_are_the_agreed_ones(project):
    names = {re.split(r"[<>=~! \[]", requirement)[0] for requirement in project["dependencies"]}
    assert names == {"pin", "numpy", "yourdfpy", "meshcat", "scipy", "typer", "rich"}


def test_packages_whose_inner_parts_are_used_have_an_upper_bound(project):
    optional = project["optional-dependencies"]
    wanted = [*project["dependencies"], *(each for extra in optional.values() for each in extra)]
    for name in ("numba", "meshcat", "viser", "xacro"):
        own = [each for each in wanted if re.split(r"[<>=~! \[]", each)[0] == name]
        assert own
        assert all("<" in each for each in own), own


def test_package_says_that_it_is_typed():
    assert (ROOT / "srs_ik" / "py.typed").is_file()


def test_command_srs_ik_is_installed():
    (command,) = metadata.entry_points(group="console_scripts", name="srs-ik")
    assert command.value == "srs_ik.cli:main"


def test_every_relative_link_of_the_readme_leads_somewhere():
    text = (ROOT / "README.md").read_text()
    targets = [t.split("#")[0] for t in re.findall(r"\]\(([^)\s]+)\)", text) if not re.match(r"[a-z]+:|#", t)]
    assert [target for target in targets if not (ROOT / target).exists()] == []


TOP = {"pyproject.toml", "srs_ik", "robots", "tests", "examples", "docs", "benchmarks", "mkdocs.yml"}
TOP |= {"README.md", "CHANGELOG.md", "CONTRIBUTING.md", "CITATION.cff", "LICENSE"}


def test_nothing_else_lies_at_the_top_level():
    names = {path.name for path in ROOT.iterdir()}
    if ".git" in names:
        command = ["git", "-c", "safe.directory=*", "ls-files"]
        kept = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout.splitlines()
        names = {name.split("/")[0] for name in kept}
    ignored = {line.rstrip("/") for line in (ROOT / ".gitignore").read_text().splitlines()}
    assert {name for name in names - ignored if not name.startswith(".")} <= TOP


@pytest.fixture
def hook(monkeypatch):
    interface = SimpleNamespace(BuildHookInterface=type("BuildHookInterface", (), {"root": str(ROOT)}))
    monkeypatch.setitem(sys.modules, "hatchling.builders.hooks.plugin.interface", interface)
    return runpy.run_path(str(ROOT / "srs_ik/kernels/ahead/hook.py"))


@pytest.mark.parametrize(("asked", "numba"), [("", True), ("pure", True), ("portable", False), ("Portable", False)])
def test_where_nothing_can_be_compiled_no_wheel_is_made_that_is_to_be_handed_on(monkeypatch, hook, asked, numba):
    monkeypatch.setenv("SRS_IK_BUILD", asked)
    monkeypatch.setattr(subprocess, "run", lambda command, **how: subprocess.CompletedProcess(command, 1))
    kernels, data, told = hook["CompiledKernels"](), {"dependencies": []}, []
    kernels.app = SimpleNamespace(display_warning=told.append)
    if numba:
        kernels.initialize("standard", data)
        assert data["dependencies"] == [hook["NUMBA"]]
        assert len(told) == 1
    else:
        with pytest.raises((RuntimeError, ValueError), match=r"no portable wheel|is portable or pure, not Portable"):
            kernels.initialize("standard", data)
    kernels.finalize("standard", data, "")


@pytest.mark.parametrize(
    ("release", "machine", "tag"),
    [("14.5", "arm64", "macosx_14_0_arm64"), ("10.15.7", "x86_64", "macosx_10_15_x86_64")],
)
def test_a_wheel_of_a_mac_is_for_its_own_processor_and_system(monkeypatch, hook, release, machine, tag):
    monkeypatch.setattr(subprocess, "run", lambda command, **how: subprocess.CompletedProcess(command, 0))
    monkeypatch.setattr("platform.system", lambda: "Darwin")
    monkeypatch.setattr("sysconfig.get_platform", lambda: "macosx-10.13-universal2")
    monkeypatch.setattr("platform.mac_ver", lambda: (release, ("", "", ""), machine))
    monkeypatch.setattr("platform.machine", lambda: machine)
    kernels, data = hook["CompiledKernels"](), {}
    assert kernels._compile(data) == ""
    kernels.finalize("standard", data, "")
    assert data["tag"] == f"cp311-abi3-{tag}"


@pytest.mark.slow
def test_a_wheel_is_compiled_where_this_checkout_is_installed_as_editable(monkeypatch, hook, tmp_path):
    # An isolated build drops from the search path what the environment around it has added to it: such a checkout, too.
    asked = {}

    def refused(command, **how):
        asked.update(how, args=command)
        return subprocess.CompletedProcess(command, 1)

    monkeypatch.setattr(subprocess, "run", refused)
    assert hook["CompiledKernels"]()._compile({}) == "they could not be compiled, see above"
    monkeypatch.undo()
    drop = f"import sys\nsys.path = [folder for folder in sys.path if folder != {str(ROOT)!r}]\n"
    (tmp_path / "sitecustomize.py").write_text(drop)
    asked["env"]["PYTHONPATH"] += f"{os.pathsep}{tmp_path}"
    # The same program, asked only what it can do.
    done = subprocess.run([*asked.pop("args")[:-1], "--help"], **asked, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "Compile all entries" in done.stdout


@pytest.mark.slow
def test_what_an_installer_reads_of_a_wheel_without_compiled_kernels_asks_for_numba(monkeypatch):
    """An installer such as uv asks before it builds; what Hatchling would say then is too little."""
    monkeypatch.setenv("SRS_IK_BUILD", "pure")
    monkeypatch.delenv("PIP_BUILD_TRACKER", raising=False)
    with tempfile.TemporaryDirectory() as folder, DefaultIsolatedEnv() as environment:
        builder = ProjectBuilder.from_isolated_env(environment, ROOT)
        environment.install(builder.build_system_requires)
        environment.install(builder.get_requires_for_build("wheel"))
        told = (Path(builder.metadata_path(folder)) / "METADATA").read_text()
    assert re.search(r"(?m)^Requires-Dist: numba[<>=,. \d]*$", told)
