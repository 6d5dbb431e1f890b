"""KUKA LBR iiwa 14: one pose of the hand, and everything the elbow can do with it.

Run: python examples/iiwa14.py
"""

import numpy as np

import srs_ik

arm = srs_ik.load("iiwa14")
print(arm)

# A pose of the tip frame in the base frame: half a metre ahead, 0.6 m up. The x axis of this tip points out of the
# flange, and here straight down.
T_base_tip = np.array(
    [
        [0.0, 0.0, 1.0, 0.5],
        [0.0, 1.0, 0.0, 0.1],
        [-1.0, 0.0, 0.0, 0.6],
        [0.0, 0.0, 0.0, 1.0],
    ]
)

# One posture: without further wishes, the one farthest from the joint limits.
solution = arm.solve(T_base_tip)
print(solution.message)
for joint, angle in solution.as_dict().items():
    print(f"  {joint}: {np.rad2deg(angle):8.3f} deg")

# Pinocchio, which took no part in the solution, agrees.
error = arm.verify(T_base_tip, solution.q)
print(f"checked by Pinocchio: {error.position:.1e} m, {error.orientation:.1e} rad")

# The elbow is free to circle about the line from shoulder to wrist; the joint limits cut the circle to pieces.
print("where the elbow may be, by branch:")
for interval in arm.intervals(T_base_tip):
    print(f"  branch {interval.branch}: {np.rad2deg(interval.lower):8.2f} to {np.rad2deg(interval.upper):8.2f} deg")

# At one arm angle there are up to eight postures, fewer where limits forbid them.
inside = arm.solve_all(T_base_tip, arm_angle=0.1)
everywhere = arm.solve_all(T_base_tip, arm_angle=0.1, respect_limits=False)
print(f"branches at arm angle 0.1 rad: {everywhere.branch.tolist()}, inside the limits {inside.branch.tolist()}")

# Many poses at once: a straight line of 1,000 poses, each solved near the posture found above.
T_base_line = np.repeat(T_base_tip[None], 1000, axis=0)
T_base_line[:, 1, 3] = np.linspace(-0.2, 0.2, 1000)
batch = arm.solve_batch(T_base_line, seed=solution.q)
print(f"{batch.solved} of {len(batch)} poses solved, errors up to {batch.position_error.max():.1e} m")

# What the hand has to do chooses the posture: polishing along x and y while pressing down, a thousand strokes at once.
angles = np.linspace(0.0, np.pi, 1000)
strokes = np.column_stack([np.cos(angles), np.sin(angles), 0.0 * angles])
polishing = arm.solve_task(srs_ik.Task([0.5, 0.1, 0.6], strokes, force=[0, 0, -1], grasp=[0, 0, -1]), side="left")
lost = np.rad2deg(polishing.angle_lost[polishing.ok])
print(f"{polishing.solved} of 1000 strokes solved, elbows up to {lost.max():.1f} deg from where the strokes want them")
