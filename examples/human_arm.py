"""A human arm: reaching for a cup, and what the answer says where the arm is too short or a joint too stiff.

Run: python examples/human_arm.py
"""

import numpy as np

import srs_ik

arm = srs_ik.load("human_arm")
limb = arm.limb
print(arm)
print(f"upper arm {limb.upper_arm:.2f} m, forearm {limb.forearm:.2f} m, hand {limb.hand:.2f} m")


def hand_pose(position: np.ndarray, grasp: list[float], back: list[float]) -> np.ndarray:
    """Pose of the tip that puts the hand at a position, with where it points and its back in the base frame."""
    R_base_hand = np.column_stack([grasp, back, np.cross(grasp, back)])
    R_tip_hand = np.column_stack([*arm.hand, np.cross(*arm.hand)])
    T_base_tip = np.eye(4)
    T_base_tip[:3, :3] = R_base_hand @ R_tip_hand.T
    T_base_tip[:3, 3] = position
    return T_base_tip


# A cup ahead of the shoulder and lower: the hand points forwards, its back is up.
reach = limb.upper_arm + limb.forearm + limb.hand
cup = limb.shoulder + np.array([0.6 * reach, 0.0, -0.25])
T_base_cup = hand_pose(cup, [1.0, 0.0, 0.0], [0.0, 0.0, 1.0])
solution = arm.solve(T_base_cup)
print(solution.message)
for joint, angle in solution.as_dict().items():
    print(f"  {joint:18} {np.rad2deg(angle):8.2f} deg")
error = arm.verify(T_base_cup, solution.q)
print(f"checked by Pinocchio: {error.position:.1e} m, {error.orientation:.1e} rad")

# How far the elbow can be lifted without letting go of the cup. Zero is the elbow hanging down.
for interval in arm.intervals(T_base_cup):
    print(
        f"branch {interval.branch}: elbow from {np.rad2deg(interval.lower):.1f} to {np.rad2deg(interval.upper):.1f} deg"
    )
print(f"postures, one for each interval: {len(arm.solve_all(T_base_cup))}")

# Moving the cup away: the answer is true as long as the arm reaches, and says how much is missing afterwards.
poses = np.repeat(T_base_cup[None], 5, axis=0)
poses[:, 0, 3] += np.linspace(0.0, 0.6, 5)
batch = arm.solve_batch(poses, seed=solution.q)
for i, T_base_far in enumerate(poses):
    print(f"cup {100.0 * (T_base_far[0, 3] - cup[0]):.0f} cm farther: {batch[i].status.name}. {batch.message(i)}")

# A twist of the hand that no wrist can make.
twisted = hand_pose(cup, [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0])
print(f"hand turned backwards: {arm.solve(twisted).message}")

# What the hand has to do chooses the posture: sawing forwards while the weight is carried, the hand pointing ahead.
task = srs_ik.Task(cup, velocity=[1.0, 0.0, 0.0], force=[0.0, 0.0, 1.0], grasp=[1.0, 0.0, 0.0])
sawing = arm.solve_task(task, side="left")
print(f"sawing: elbow at {np.round(sawing.posture.elbow, 3).tolist()}. {sawing.message}")
error = arm.verify(sawing.T_base_tip, sawing.q)
print(f"checked by Pinocchio: {error.position:.1e} m, {error.orientation:.1e} rad")
