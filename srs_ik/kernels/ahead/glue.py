"""The C around compiled kernels, written from the table: header, choice of a processor, and Python extension."""

from __future__ import annotations

import importlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from pkgutil import iter_modules

from srs_ik.kernels import layout
from srs_ik.kernels.ahead.signatures import Argument, Entry
from srs_ik.kernels.native import limb_mark

HERE = Path(__file__).parent
NAME = "srs_ik"

_IN_C = {"float": "double", "int": "int64_t", "byte": "int8_t", "bool": "bool"}
_FROM_C = {"float": "PyFloat_FromDouble", "int": "PyLong_FromLongLong", "bool": "PyBool_FromLong"}

_ABOUT = """\
/* srs_ik in C: inverse kinematics of S-R-S arms. Written from the table of entries when the library is built.

   Angles in radians, lengths in metres, arrays in C order; one without rows may be NULL.
   A call returns 0; 1 where there is no memory for its work space, 2 where this processor is of no kind that was
   compiled for. It keeps nothing, takes no lock, and may run on many threads at once, each with its own output and work
   space. What the rows hold: see the places `SRS_IK_*` below.
*/
"""

_FILES = """
/* Read a limb that `srs-ik inspect ROBOT --packed FILE` wrote: 0; 1: no limb of this version, 2: cannot be read. */
int srs_ik_read_limb(const char *path, double family[4][SRS_IK_LIMB_SIZE]);

/* The kind of processor that the kernels at work are compiled for; NULL where this machine takes none of them. */
const char *srs_ik_target(void);

/* Have another kind do the work: 0, or 1 where there is none of the name or this machine is none. Before any call. */
int srs_ik_choose(const char *target);
"""


def header(entries: Sequence[Entry]) -> str:
    """The header for C and C++."""
    lines = [_ABOUT, "#ifndef SRS_IK_H", "#define SRS_IK_H", "#include <stdbool.h>", "#include <stdint.h>", ""]
    lines += [f"#define SRS_IK_{module}_{name} {value}" for module, name, value in _places()]
    lines += ["", "#ifdef __cplusplus", 'extern "C" {', "#endif", _FILES]
    for entry in entries:
        lines += [f"/* {_documented(entry)} */", f"{_prototype(entry, entry.symbol)};", ""]
    return "\n".join([*lines, "#ifdef __cplusplus", "}", "#endif", "#endif", ""])


_LARGEST = 2**53
"""Whole numbers from here on are no integers of C."""


def _places() -> list[tuple[str, str, float]]:
    """Places and sizes of what travels in arrays, from `layout`: whole numbers, but for those too large for one."""
    found = []
    for each in iter_modules(layout.__path__):
        for name, value in vars(importlib.import_module(f"{layout.__name__}.{each.name}")).items():
            if name.isupper() and not name.startswith("_") and isinstance(value, (int, float)):
                if float(value).is_integer():
                    found.append((each.name.upper(), name, int(value) if abs(value) < _LARGEST else float(value)))
    return found


def _documented(entry: Entry) -> str:
    shapes = [f"{a.name} {_shape(a)}" for a in entry.arguments if a.shape]
    return f"arrays: {', '.join(shapes)}" if shapes else "no arrays"


def _shape(argument: Argument) -> str:
    return f"[{', '.join(map(str, argument.shape or ()))}]"


def _parameters(entry: Entry) -> list[tuple[str, str]]:
    """Type and name of each parameter in C."""
    found = []
    for a in entry.arguments:
        kind = _IN_C[a.element]
        found.append((f"{'' if a.written else 'const '}{kind} *" if a.shape else f"{kind} ", a.name))
    found += [("int64_t ", f"size_{name}") for name in entry.sizes]
    found += [(f"{_IN_C[kind]} *", f"result_{i}") for i, kind in enumerate(entry.results)]
    return found


def _prototype(entry: Entry, symbol: str) -> str:
    return f"int {symbol}({', '.join(kind + name for kind, name in _parameters(entry)) or 'void'})"


def _types(entry: Entry) -> str:
    return ", ".join(kind.strip() for kind, _ in _parameters(entry)) or "void"


def symbol(target: str, entry: Entry) -> str:
    """Name of the machine code of an entry for a kind of processor."""
    return f"{target.replace('-', '_')}_{entry.symbol}"


def library(entries: Sequence[Entry], targets: Sequence[tuple[str, str]]) -> str:
    """C that hands a call on to the machine code that fits; targets are names and the checks for them, best last."""
    lines = [f'#include "{NAME}.h"', "#include <stdio.h>", "#include <stdlib.h>", "#include <string.h>", ""]
    lines.append((HERE / "processor.h").read_text())
    lines.append("typedef struct {")
    lines += [f"    int (*{e.symbol})({_types(e)});" for e in entries]
    lines += ["} functions;", ""]
    for target, _ in targets:
        lines += [f"{_prototype(e, symbol(target, e))};" for e in entries]
        lines.append(f"static const functions {target.replace('-', '_')} = {{")
        lines += [f"    {symbol(target, e)}," for e in entries]
        lines += ["};", ""]
    lines.append("static const struct { const char *name; const functions *of; } targets[] = {")
    lines += [f'    {{"{target}", &{target.replace("-", "_")}}},' for target, _ in targets]
    lines += ["};", "static int at = -1;", f"#define TARGETS {len(targets)}", ""]
    lines += ["static bool fits(int target) {", "    switch (target) {"]
    lines += [f"    case {i}: return {check};" for i, (_, check) in enumerate(targets)]
    mark = ", ".join(map(str, limb_mark()))
    lines += ["    }", "    return false;", "}", "", f"static const unsigned char limb_mark[16] = {{{mark}}};", ""]
    lines += [(HERE / "library.c").read_text()]
    for e in entries:
        names = ", ".join(name for _, name in _parameters(e))
        lines += [
            f"{_prototype(e, e.symbol)} {{",
            "    if (at < 0) return 2;",
            f"    return targets[at].of->{e.symbol}({names});",
            "}",
            "",
        ]
    return "\n".join(lines)


def extension(entries: Sequence[Entry], targets: Sequence[tuple[str, str]], stamps: Mapping[str, str]) -> str:
    """A Python extension with a function for each entry."""
    digests = " ".join(f"{room}:{digest}" for room, digest in stamps.items())
    kinds = " and ".join(target for target, _ in targets)
    lines = [f'#define DIGESTS "{digests}"', f'#define KINDS "{kinds}"', (HERE / "arguments.c").read_text()]
    for entry in entries:
        lines += _function(entry)
    lines.append("static PyMethodDef methods[] = {")
    lines += [f"    ENTRY({e.room}_{e.name})," for e in entries]
    return "\n".join([*lines, (HERE / "module.c").read_text()])


def _function(entry: Entry) -> list[str]:
    count = len(entry.arguments)
    parameters = "PyObject *module, PyObject *const *passed, Py_ssize_t passed_count"
    lines = [f"static PyObject *{entry.room}_{entry.name}({parameters}) {{", "    (void)module;"]
    lines.append(f'    if (passed_count != {count}) return wrong_count("{entry.name}", {count}, passed_count);')
    if entry.sizes:
        lines.append(f"    int64_t {', '.join(f'size_{name} = -1' for name in entry.sizes)};")
    for place, argument in enumerate(entry.arguments):
        lines += _read(entry, place, argument)
    lines += [f"    {_IN_C[kind]} result_{i};" for i, kind in enumerate(entry.results)]
    names = ", ".join(("&" if name.startswith("result_") else "") + name for _, name in _parameters(entry))
    lines += ["    int failed;", "    Py_BEGIN_ALLOW_THREADS", f"    failed = {entry.symbol}({names});"]
    lines += ["    Py_END_ALLOW_THREADS", "    if (failed) return PyErr_NoMemory();"]
    values = [f"{_FROM_C[kind]}(result_{i})" for i, kind in enumerate(entry.results)]
    if not values:
        lines.append("    Py_RETURN_NONE;")
    elif len(values) == 1:
        lines.append(f"    return {values[0]};")
    else:
        lines.append(f"    return tuple_of({len(values)}, {', '.join(values)});")
    return [*lines, "}", ""]


def _read(entry: Entry, place: int, a: Argument) -> list[str]:
    given = f"passed[{place}]"
    where = f'"{entry.name}", "{a.name}"'
    lines = [f"    {_IN_C[a.element]} {'*' if a.shape else ''}{a.name}{' = NULL' if a.shape else ''};"]
    if a.shape is None:
        return [*lines, f"    if (!read_{a.element}({given}, &{a.name})) return wrong_number({where});"]
    checks = [
        f"fits(size_{size}, d[{axis}])" if isinstance(size, str) else f"d[{axis}] == {size}"
        for axis, size in enumerate(a.shape)
    ]
    use = "WRITTEN" if a.written else "READ"
    return [
        *lines,
        "    {",
        "        const Py_ssize_t *d = NULL;",
        f"        {a.name} = array({given}, {a.element}_, {len(a.shape)}, {use}, &d);",
        f"        if (!{a.name} || !({' && '.join(checks)}))",
        f'            return wrong_array({where}, "{a.element}{_shape(a)}", {given});',
        "    }",
    ]
