"""Two arms beside each other: the first one goes to its pose, and the second one keeps clear of it.

Run: python examples/two_arms.py
"""

import srs_ik

left = srs_ik.load("iiwa14")
right = srs_ik.load("iiwa14")

# The base of the second arm, seen from the first one.
T_left_right = srs_ik.pose_from_xyz_rpy([0.0, -0.6, 0.0], [0.0, 0.0, 0.0])

# The first arm has only itself and the table to keep clear of.
table = ("table", srs_ik.pose_from_xyz_rpy([0.5, -0.3, -0.06], [0.0, 0.0, 0.0]), [1.0, 2.0, 0.1])
around_left = srs_ik.Scene()
around_left.add_box(*table)
T_left_cup = left.forward_kinematics([0.2, 0.8, 0.1, -1.2, 0.2, 0.9, 0.0])
first = left.solve(T_left_cup, scene=around_left, margin=0.01)
print("left: ", first.message)
error = left.verify(T_left_cup, first.q)
print(f"left:  {error.position:.1e} m and {error.orientation:.1e} rad off, by Pinocchio")

# The second arm has the first one to keep clear of, too, where it now stands.
around_right = srs_ik.Scene()
around_right.add_arm("left", left, first.q, pose=T_left_right.inverse())
T_right_cup = right.forward_kinematics([-0.2, 0.8, -0.1, -1.2, -0.2, 0.9, 0.0])
free = right.intervals(T_right_cup)
clear = right.intervals(T_right_cup, scene=around_right, margin=0.01)
share = sum(i.width for i in clear) / sum(i.width for i in free)
print(f"right: {100 * share:.0f} % of the arm angles inside the limits are clear")
second = right.optimise(T_right_cup, "clearance", scene=around_right, margin=0.01)
print(f"right: {second.message} Nothing is nearer than {1e3 * second.value:.0f} mm.")
error = right.verify(T_right_cup, second.q)
print(f"right: {error.position:.1e} m and {error.orientation:.1e} rad off, by Pinocchio")
