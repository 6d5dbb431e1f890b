"""A hand that was recorded, with jitter, drop-outs and a jump, followed by an iiwa 14 within all its limits.

Run: python examples/follow_hand.py
"""

from collections import Counter

import numpy as np
import pinocchio as pin

import srs_ik

arm = srs_ik.load("iiwa14")
q0 = np.array([0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2])
dt = 0.005

# A recording: a figure of eight, 4 s long; from 1.5 s on the camera believes the hand to be 4 cm higher for 0.3 s, and
# 5 % of the samples are lost.
rng = np.random.default_rng(0)
start = arm.forward_kinematics(q0)
recording = []
for t in np.arange(0.0, 4.0, dt):
    way = 0.5 * (1.0 - np.cos(0.5 * np.pi * min(t, 2.0)))
    eight = 0.1 * way * np.array([0.0, np.sin(2.0 * t), np.sin(4.0 * t)])
    jump = np.array([0.0, 0.0, 0.04 if 1.5 < t < 1.8 else 0.0])
    turn = pin.exp3(rng.normal(0.0, 0.001, 3))
    hand = pin.SE3(start.rotation @ turn, start.translation + eight + jump + rng.normal(0.0, 0.0003, 3))
    recording.append(None if rng.uniform() < 0.05 else hand)

# The jitter is measured, and a filter takes away as much of it as the arm cannot follow.
tracker = arm.tracker(q0, dt, elbow="limit_margin")
steps = [tracker.update(pose) for pose in recording]

print("jitter as measured: {:.1e} m, {:.1e} rad".format(*tracker.noise))
print(Counter(str(step.status) for step in steps))
jump = next(k for k in range(301, len(steps)) if recording[k] is not None)
print("at the jump:", steps[jump].message)
velocity = np.abs([step.velocity for step in steps]).max(axis=0)
acceleration = np.abs([step.acceleration for step in steps]).max(axis=0)
print("largest velocities, share of the limits:     ", np.round(velocity / tracker.velocity_limit, 2))
print("largest accelerations, share of the limits:  ", np.round(acceleration / tracker.acceleration_limit, 2))

# At rest at the end, the tip is where Pinocchio says that the target is.
for _ in range(400):
    step = tracker.update(start)
error = np.linalg.norm(arm.forward_kinematics(step.q).translation - start.translation)
print(f"at rest: {step.message} By Pinocchio off by {error:.1e} m.")
