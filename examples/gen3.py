"""Kinova Gen3: continuous joints, and axes that miss one another by millimetres.

Run: python examples/gen3.py
"""

import numpy as np

import srs_ik

arm = srs_ik.load("gen3")
print(arm)

# No three axes of this arm meet in a point, so it has no closed form; the nearest arm that has one is the start.
misses = ", ".join(f"{1e3 * miss:.2f}" for miss in arm.limb.misses)
print(f"its axes miss the shoulder and wrist centres by {misses} mm")

# Joints 1, 3, 5 and 7 turn without end. Pinocchio stores them as cosine and sine; here a joint vector is 7 angles.
q = np.array([0.4, 0.6, -2.0, -1.6, 0.3, -0.8, 1.0])
configuration = arm.configuration(q)
print(f"{len(q)} joint angles, {len(configuration)} numbers in a configuration of Pinocchio")
T_base_tip = arm.forward_kinematics(q)

# All the same, the posture closes on the true axes.
solution = arm.solve(T_base_tip, arm_angle=arm.arm_angle(q))
error = arm.verify(T_base_tip, solution.q)
print(f"{solution.status.name}: off by {error.position:.1e} m, {error.orientation:.1e} rad")

# With a seed, the nearest posture; its continuous joints come back in the turn of the seed.
seed = q + np.array([2.0 * np.pi, 0.1, 0.0, 0.0, -2.0 * np.pi, 0.0, 0.0])
near = arm.solve(T_base_tip, seed=seed)
print(f"seeded a turn off each: joint 1 at {near.q[0]:.3f} rad, joint 5 at {near.q[4]:.3f} rad")

# One posture for every stretch of arm angles that the limits of joints 2, 4 and 6 leave.
intervals = arm.intervals(T_base_tip)
postures = arm.solve_all(T_base_tip)
print(f"intervals of arm angles: {len(intervals)}, postures: {len(postures)}")
for posture in postures:
    print(f"  branch {posture.branch}, arm angle {posture.arm_angle:6.3f} rad: {np.round(posture.q, 3)}")

# Every branch of many poses, as arrays over (poses, 8).
rng = np.random.default_rng(0)
bound = np.where(np.isfinite(arm.upper), arm.upper, np.pi)
poses = [arm.forward_kinematics(rng.uniform(-bound, bound)) for _ in range(200)]
batch = arm.solve_batch(poses, arm_angle=0.5, all_branches=True)
print(f"{batch.ok.sum()} postures of {batch.ok.size} branches keep the limits at arm angle 0.5 rad")

# What the hand has to do chooses the posture: pushing a lever ahead and up, the hand along y.
task = srs_ik.Task([0.3, 0.25, 0.5], velocity=[1.0, 0.0, 0.0], force=[0.0, 0.6, 1.0], grasp=[0.0, 1.0, 0.0])
for side in ("left", "right"):
    pushing = arm.solve_task(task, side=side)
    print(f"{side} elbow: {np.round(pushing.posture.elbow, 3).tolist()}. {pushing.message}")
    if pushing:
        error = arm.verify(pushing.T_base_tip, pushing.q)
        print(f"checked by Pinocchio: {error.position:.1e} m, {error.orientation:.1e} rad")
