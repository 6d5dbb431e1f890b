"""How long a new process takes to its first answer."""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time

WARM_STARTS = 5
FIRST_ANSWER = """
import srs_ik
arm = srs_ik.load("iiwa14")
assert arm.solve(arm.forward_kinematics([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2]))
"""


def starts() -> dict[str, float]:
    """Seconds to import, and to import, load iiwa14 and solve once, without compiled kernels and with them."""
    with tempfile.TemporaryDirectory() as cache:

        def start(program: str) -> float:
            begin = time.perf_counter()
            subprocess.run([sys.executable, "-c", program], check=True, env={**os.environ, "NUMBA_CACHE_DIR": cache})
            return time.perf_counter() - begin

        cold = start(FIRST_ANSWER)
        warm = statistics.median(start(FIRST_ANSWER) for _ in range(WARM_STARTS))
        bare = statistics.median(start("import srs_ik") for _ in range(WARM_STARTS))
        return {"import_s": bare, "first_answer_cold_s": cold, "first_answer_warm_s": warm}
