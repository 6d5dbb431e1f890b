"""All that was measured in one run, as tables in Markdown and as plain figures."""

from __future__ import annotations

import os
import platform
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, field
from importlib import metadata
from pathlib import Path
from typing import Any

from srs_ik.bench.growth import Growth
from srs_ik.bench.own import Batch
from srs_ik.bench.timing import Timed
from srs_ik.kernels.native import at_work

FIRST_ANSWER = {
    "import_s": "`import srs_ik` in a new process",
    "first_answer_cold_s": "import, load iiwa14, first solve; kernels not compiled yet",
    "first_answer_warm_s": "the same, kernels in the cache",
}

CALLS = (
    *("robot", "package", "call", "median us", "99 % us"),
    *("answered", "inside limits", "worst error", "farther", "found a pose"),
)
BATCHES = ("robot", "batch", "poses", "us a pose, 1 thread", "us a pose, 2 threads")
GROWTH = ("robot", "poses", "threads", "us a pose", "answers MB", "memory of the call MB")


@dataclass
class Report:
    """Figures of one run on one machine."""

    machine: dict[str, str]
    floor_us: float
    calls: list[Timed] = field(default_factory=list)
    batches: list[Batch] = field(default_factory=list)
    growth: list[Growth] = field(default_factory=list)
    start: dict[str, float] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """Plain figures, for JSON."""
        return asdict(self)

    def markdown(self) -> str:
        """Tables, one behind another."""
        about = ", ".join(f"{name} {value}" for name, value in self.machine.items())
        floor = f"Eight sine and cosine pairs and seven arctangents, on one thread: {self.floor_us:.3f} us."
        parts = [f"{about}. {floor}"]
        if self.calls:
            parts.append(_table(CALLS, 3, map(_call, self.calls)))
        if self.batches:
            parts.append(_table(BATCHES, 2, map(_batch, self.batches)))
        if self.growth:
            parts.append(_table(GROWTH, 1, map(_growth, self.growth)))
        if self.start:
            rows = ((FIRST_ANSWER[name], f"{seconds:.2f}") for name, seconds in self.start.items())
            parts.append(_table(("start", "s"), 1, rows))
        return "\n\n".join(parts)


def _call(row: Timed) -> Sequence[str]:
    error = "" if row.error is None else f"{row.error:.1e}"
    times = f"{row.median_us:.2f}", f"{row.p99_us:.2f}"
    answered = f"{row.answered} of {row.poses}"
    return (
        row.robot,
        row.package,
        row.call,
        *times,
        answered,
        _whole(row.inside),
        error,
        _whole(row.farther),
        f"{row.found / row.poses:.2f}",
    )


def _batch(row: Batch) -> Sequence[str]:
    return (row.robot, row.call, f"{row.poses:,}", f"{row.one_thread_us:.3f}", f"{row.two_threads_us:.3f}")


def _growth(row: Growth) -> Sequence[str]:
    memory = ("", "") if row.memory_mb is None else (f"{row.answers_mb:.0f}", f"{row.memory_mb:.0f}")
    return (row.robot, f"{row.poses:,}", str(row.threads), f"{row.us:.3f}", *memory)


def _whole(value: int | None) -> str:
    return "" if value is None else str(value)


def _table(columns: Sequence[str], texts: int, rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table whose first columns are texts and whose others are numbers."""
    rule = ["---"] * texts + ["--:"] * (len(columns) - texts)
    return "\n".join("| " + " | ".join(cells) + " |" for cells in (columns, rule, *rows))


def machine(packages: Sequence[str] = ("srs-ik", "pin", "numpy")) -> dict[str, str]:
    """What the figures belong to; the load says how much else the machine had to do."""
    cpu = platform.processor() or platform.machine()
    details = Path("/proc/cpuinfo")
    if details.is_file():
        models = [line.partition(":")[2].strip() for line in details.read_text().splitlines() if "model name" in line]
        cpu = models[0] if models else cpu
    load = f"{os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "unknown"
    versions = {name: metadata.version(name) for name in packages}
    return {
        "CPU": f"{cpu}, {os.cpu_count()} cores",
        "load": load,
        "Python": platform.python_version(),
        **versions,
        "kernels": at_work(),
    }
