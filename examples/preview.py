"""See an arm: its elbow's circle, the feasible arm angles, and the self-motion, as one file for any browser.

Run: python examples/preview.py [FILE.html]
"""

import sys
import tempfile
from pathlib import Path

import numpy as np

import srs_ik

file = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(tempfile.mkdtemp()) / "scene.html"
arm = srs_ik.load("iiwa14")

# The hand half a metre ahead, pointing down; the x axis of this tip points out of the flange.
T_base_tip = np.array(
    [
        [0.0, 0.0, 1.0, 0.5],
        [0.0, 1.0, 0.0, 0.1],
        [-1.0, 0.0, 0.0, 0.6],
        [0.0, 0.0, 0.0, 1.0],
    ]
)
solution = arm.solve(T_base_tip)
error = arm.verify(T_base_tip, solution.q)
print(f"checked by Pinocchio: {error.position:.1e} m, {error.orientation:.1e} rad")

# Without the file, the page itself would be at view.url for as long as the block lasts.
with srs_ik.Preview(arm) as view:
    view.show(solution.q)
    view.show_ellipsoids(solution.q)
    intervals = view.show_intervals(T_base_tip)
    view.show_self_motion(T_base_tip, branch=solution.branch)
    view.save(file)
print(f"{len(intervals)} intervals of feasible arm angles, and the self-motion through one of them: open {file}")
