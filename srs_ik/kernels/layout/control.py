"""Columns of the arrays of a torque controller: one row a port, one row of memory beside it, and the work of a tick."""

# What a port holds.
KIND = 0  # one of the kinds below
JOINT = 1  # 0 to 6, of a joint limit
LAW = 2  # one of the laws below
PER_AXIS = 3  # 1.0: along the base axes; 0.0: along axes that the error chooses
SWITCH = 4  # speed (m/s, rad/s) under which the error counts as growing; negative: by the error itself
PROFILE = 5  # one of the profiles below
STIFFNESS = 6  # N/m, N m/rad: slope of the force at zero
LARGEST = 7  # N, N m: the force is never larger
KNEE = 8  # m, rad: where the published profile leaves its spring
WIDTH = 9  # m, rad: how fast it rises from there
DAMPING = 10  # N s/m, N m s/rad
TARGET = 11  # 3 position, 9 rotation row by row, 1 angle, 2 where the zones of a joint begin, 1 speed of a joint
PORT = 20

# Kinds.
TIP = 0.0
ORIENTATION = 1.0
ELBOW = 2.0
ARM_ANGLE = 3.0
JOINT_LIMIT = 4.0
JOINT_SPEED = 5.0

# Laws of convergence.
LAW_A = 0.0  # F(e_M)/e_M (2 e - e_M)
LAW_B = 1.0  # U(e_M)/(e_M/2)^2 (e - e_M/2), clipped to the largest force
SPRING = 2.0  # F(e), converging as diverging: no fractal at all

# Profiles.
TANH = 0.0
SATURATED = 1.0
PUBLISHED = 2.0

# What a port remembers and reports; up to three axes.
LAST = 0  # 3: size of the error at the last tick; negative before the first one
PEAK = 3  # 3: largest error of the current divergence
CONVERGING = 6  # 3: 1.0 while the error shrinks
ERROR = 9  # 3: m, rad
FORCE = 12  # 3: N, N m, without damping
ENERGY = 15  # J: of the profile at the error, less what is lost of it: what the port can give back at most
POWER = 16  # W: that flows into the arm, with damping
MOVED = 17  # 1.0 where the target has moved since the last tick
FRAME = 18  # 9: axes of the radial form, row by row
SIZE = 27  # m, rad: distance at the last tick; negative before the first one
PHASE = 28  # one of the phases below
LOST = 29  # part of the profile's energy that the arm has not given: of an arm angle, where J' was scaled down
STATE = 30

# Phases of the radial form.
LEAVING = 0.0  # the distance has grown since the beginning: the first axis follows the error
BACK = 1.0  # the distance shrinks: the axes are those of its last peak
AGAIN = 2.0  # it grows again: the axes stay

# What holds for the whole controller.
MAX_TORQUE = 0  # 7, N m
GRAVITY = 7  # 1.0 where the weight of the arm is held

# Rows of the work of a tick, 7 columns each.
TORQUE = 0
WEIGHT = 1
LINES = 2  # 6 rows, lines of the joints
DERIVATIVES = 8  # of the arm angle
TURNED = 9  # 5 rows, gravity in the frame before each joint, and its cosine and sine
WORK = 14

LARGEST_SPEED = 1e6
"""Joint speeds beyond this, rad/s, are refused."""
