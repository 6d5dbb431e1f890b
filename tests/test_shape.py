"""The shape of the package: no circles; of its kernels: few arguments, short files, small rooms; of its tests."""

from __future__ import annotations

import ast
from collections import Counter
from pathlib import Path

import pytest

import srs_ik

PACKAGE = Path(srs_ik.__file__).parent
KERNELS = PACKAGE / "kernels"

MANY = 8
"""So many arguments are many."""

MOST_WITH_MANY = 0.06
"""The part of all functions that may have many; entries take what Python passes one by one."""

LONGEST_FILE = 400

MOST_FILES = 15
"""So many files are in a room at most, its `__init__` among them."""

MOST_ROOMS = 20
"""So many files and folders stand side by side at the top of the package at most."""


@pytest.mark.slow
def test_few_functions_have_many_arguments():
    counts = {
        f"{path.relative_to(KERNELS)}:{node.name}": len(node.args.args)
        for path in KERNELS.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.FunctionDef)
    }
    many = sorted(name for name, count in counts.items() if count >= MANY)
    assert len(many) <= MOST_WITH_MANY * len(counts), many


def test_files_are_short():
    lines = {str(path.relative_to(KERNELS)): len(path.read_text().splitlines()) for path in KERNELS.rglob("*.py")}
    assert {name: count for name, count in lines.items() if count > LONGEST_FILE} == {}


def test_rooms_are_small():
    rooms = {
        str(room.relative_to(KERNELS)): len(list(room.glob("*.py"))) for room in KERNELS.rglob("*") if room.is_dir()
    }
    assert {name: count for name, count in rooms.items() if count > MOST_FILES} == {}


def test_the_package_has_few_rooms():
    rooms = {path.stem for path in PACKAGE.iterdir() if path.suffix == ".py" or (path / "__init__.py").is_file()}
    assert len(rooms - {"__init__"}) <= MOST_ROOMS, sorted(rooms)


@pytest.mark.slow
def test_nothing_is_named_twice():
    twice = [
        f"{path.relative_to(PACKAGE)}: {name}"
        for path in PACKAGE.rglob("*.py")
        for name, count in Counter(names_given(ast.parse(path.read_text()))).items()
        if count > 1
    ]
    assert twice == []


@pytest.mark.slow
def test_files_do_not_import_each_other_in_circles():
    files = {path: ast.parse(path.read_text()) for path in PACKAGE.rglob("*.py")}
    names = {module_of(path): path for path in files}
    # What a package hands on from its own files is no use of them.
    imported = {
        path: {names[name] for name in names_imported(tree) if name in names} - {path}
        for path, tree in files.items()
        if path.name != "__init__.py"
    }
    left = dict(imported)
    # Away with all that imports nothing that is left, and that nothing left imports.
    while free := {path for path, used in left.items() if not used & left.keys()} or left.keys() - {
        used for each in left.values() for used in each
    }:
        left = {path: used for path, used in left.items() if path not in free}
    assert sorted(str(path.relative_to(PACKAGE)) for path in left) == []


def test_tests_import_helpers_and_never_one_another():
    imported = {
        f"{path.name}: {name}"
        for path in Path(__file__).parent.glob("*.py")
        for name in names_imported(ast.parse(path.read_text()))
        if name.startswith("test_")
    }
    assert imported == set()


def module_of(path: Path) -> str:
    """The dotted name of a file."""
    parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def names_imported(tree: ast.Module) -> set[str]:
    """Dotted names that a file imports anywhere, those for type checkers included."""
    found: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return found


def names_given(module: ast.Module) -> list[str]:
    """Names of constants, functions and classes of a module, as often as it gives them to something."""
    names: list[str] = []
    for node in module.body:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            names.append(node.name)
        elif isinstance(node, ast.Assign):
            names += [target.id for target in node.targets if isinstance(target, ast.Name)]
    return names
