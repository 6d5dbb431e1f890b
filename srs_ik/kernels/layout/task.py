"""Tasks: what they give, what kernels know of a hand, the row of a posture and that of a solution."""

from srs_ik.kernels.layout.answer import ROW

# A task row: position, then directions of unit length; those not given are zero.
TASK_POSITION = 0
TASK_VELOCITY = 3
TASK_FORCE = 6
TASK_GRASP = 9
TASK_PRONOSUPINATION = 12
TASK = 15

# What a task gives, as a bit set.
GRASP = 1
PRONOSUPINATION = 2

# The packed hand, filled in by `srs_ik.solve.packed.pack_hand`.
HAND_GRASP = 0  # 3, tip frame, as are the two directions across and along
HAND_ACROSS = 3  # 3
HAND_REACH = 6  # 3, from the wrist to the tip
HAND_WRIST = 9  # 3, the wrist centre
HAND_LENGTH = 12  # wrist to tip
HAND_ALONG = 13  # the part of it along the grasp direction
HAND_UPPER_ARM = 14
HAND_FOREARM = 15
HAND_NEAR = 16  # shortest and longest distance of the wrist from the shoulder
HAND_FAR = 17
HAND_TIP_NEAR = 18  # and of the tip, with the hand in line with the forearm
HAND_TIP_FAR = 19
HAND_KNOWN = 20  # 1.0 if the axes of the hand are known; else it is taken to reach out along its grasp direction
HAND = 21

# A posture row.
ELBOW = 0  # 3
WRIST = 3  # 3
TIP = 6  # 3
NORMAL = 9  # 3
TASK_NORMAL = 12  # 3
DIRECTION = 15  # 3
ARM_ANGLE = 18
MISS = 19  # how far the target is beyond (positive) or within (negative) what the arm reaches
POSTURE = 20

# A task solution row: a solution row, a posture row, the pose of the tip, and the arm angle given up.
TASK_POSTURE = ROW
TASK_ROTATION = TASK_POSTURE + POSTURE  # 3 x 3
TASK_TIP = TASK_ROTATION + 9  # 3
ANGLE_LOST = TASK_TIP + 3  # rad, not negative
TASK_SOLUTION = ANGLE_LOST + 1

NOT_FINITE = 1
NO_DIRECTION = 2
ROLL_OPEN = 3
"""What can be wrong with a task."""
