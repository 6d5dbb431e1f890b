"""How code is divided into parts that are compiled one beside the other, looked at by LLVM itself."""

import pytest

llvm = pytest.importorskip("llvmlite.binding")

from srs_ik.kernels.ahead import units  # noqa: E402

STEPS = "".join(f"  %x{i + 1} = fadd double %x{i}, 1.0\n" for i in range(9))
LARGE = f"(double %x0) {{\n{STEPS}  ret double %x9\n}}\n"
CALLS = (
    "  %a = call double @large(double %x)\n  %b = call double @large(double %a)\n  %c = call double @small(double %b)\n"
)
MODULE = f"""
define internal double @large{LARGE}
define internal double @once{LARGE}
define internal double @small(double %x) {{
  ret double %x
}}
define internal double @thin(double %x) {{
  %a = call double @large(double %x)
  ret double %a
}}
define double @first(double %x) {{
{CALLS}  %d = call double @once(double %c)
  %e = call double @thin(double %d)
  ret double %e
}}
define double @second(double %x) {{
{CALLS}  %d = call double @thin(double %c)
  ret double %d
}}
"""


def defined(text: str) -> set[str]:
    """Functions with a body in a module that LLVM finds sound."""
    module = llvm.parse_assembly(text)
    module.verify()
    return {function.name for function in module.functions if not function.is_declaration}


def test_large_functions_stand_in_one_part_and_small_ones_where_they_are_called(monkeypatch):
    monkeypatch.setattr(units, "LARGE", 9)
    monkeypatch.setattr(units, "SMALL", 5)
    first, second = units.divide(str(llvm.parse_assembly(MODULE)), [["first"], ["second"]])
    found = [defined(first.text), defined(second.text)]
    assert found[0] & found[1] == {
        "small",
        "thin",
    }  # this one would be part of its callers, large as it is with what it calls
    assert found[0] | found[1] == {"first", "second", "large", "once", "small", "thin"}
    assert "once" in found[0]  # with its only caller
    assert (first.entries, second.entries) == (["first"], ["second"])
    assert first.shared == second.shared == ["large"]


def test_one_part_alone_is_not_divided(monkeypatch):
    monkeypatch.setattr(units, "LARGE", 9)
    (whole,) = units.divide(str(llvm.parse_assembly(MODULE)), [["first", "second"]])
    assert defined(whole.text) == {"first", "second", "large", "once", "small", "thin"}
    assert not whole.shared
