"""The shape of the kernels: few arguments, short files, small rooms."""

from __future__ import annotations

import ast
from pathlib import Path

import srs_ik

KERNELS = Path(srs_ik.__file__).parent / "kernels"

MANY = 8
"""So many arguments are many."""

MOST_WITH_MANY = 0.06
"""The part of all functions that may have many; entries take what Python passes one by one."""

LONGEST_FILE = 400

MOST_FILES = 15
"""So many files are in a room at most, its `__init__` among them."""


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
