"""The loop of a robot's driver: every 2 ms a target comes, and joint angles go out, in time.

Run: python examples/control_loop.py
"""

import time

import numpy as np

import srs_ik

arm = srs_ik.load("gen3")
q = np.array([0.3, 0.6, -0.2, -1.4, 0.1, -0.7, 0.4])
dt = 0.002


class Robot:
    """Stands for a driver: it takes joint angles, and says what it has."""

    def __init__(self, q):
        self.q = q

    def send(self, q):
        self.q = q


robot = Robot(q)
tracker = arm.tracker(robot.q, dt)
start = arm.forward_kinematics(q).homogeneous
tracker.update(start)  # what has to be compiled is compiled here, and not in the loop

took, late = [], 0
begin = time.perf_counter()
for k in range(1000):
    target = start.copy()
    target[:3, 3] += 0.05 * np.sin(np.pi * k * dt) ** 2 * np.array([0.0, 1.0, 0.5])

    woke = time.perf_counter()
    step = tracker.update(target)
    took.append(time.perf_counter() - woke)
    robot.send(step.q)
    if not step:
        print(f"{k * dt:.3f} s: {step.message}")

    left = begin + (k + 1) * dt - time.perf_counter()
    if left > 0.0:
        time.sleep(left)
    else:
        late += 1

print(f"an update takes {1e6 * np.median(took):.0f} us; {late} of {len(took)} periods were late on this machine")
error = np.linalg.norm(arm.forward_kinematics(robot.q).translation - target[:3, 3])
print(f"the tip at the end, by Pinocchio off by {error:.1e} m")
