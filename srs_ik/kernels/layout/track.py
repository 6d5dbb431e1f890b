"""Layout of a tracker: its state from one update to the next, its settings, and what an update says."""

# The state.
Q = 0  # 7, joint angles
V = 7  # 7, their velocities in the step that led there
GOAL = 14  # 7, the posture that the joints make for, on the target's pose where that can be reached
GOAL_RATE = 21  # 7, how fast it moves, rad/s
ROTATION = 28  # 9, what is followed of the target: all of it, or what is left of jitter
POSITION = 37  # 3
TWIST = 40  # 6, how fast that moved in the last period: linear, angular
LOST = 46  # updates since the last target
ON = 47  # 1.0 if the tip was on the target after the last update
STUCK = 48  # updates in which the goal has come no closer
DETOUR = 49  # 1.0 while the goal goes to a posture known to be on the pose
DETOUR_END = 50  # 7, that posture
MISS = 57  # how far the goal's pose is from the target: metres, turns by the reach
TICK = 58  # updates so far
ELSEWHERE = 59  # what is known of postures that reach the target: `UNKNOWN` ...
STARTED = 60  # 1.0 once there was a target
ESTIMATE = 61  # 12, where the target itself is taken to be: rotation, position
COAST = 73  # updates in which the tip was off the target, close to it, and came no closer
PACE = 74  # 6, how fast what is followed moves, averaged: linear, angular
PLANNED = 80  # 1.0 while there is a plan
PLAN_AGE = 81  # seconds since it was made
PLAN_Q = 82  # 7, where the joints were then
PLAN_V = 89  # 7, and their velocities
PLAN_A = 96  # 7, the accelerations that it has for the beginning
KNOT = 103  # 7 KNOTS, postures at the times of the plan
TREND = 152  # 12, the target as its trend has it: rotation, position
TREND_PACE = 164  # 6, its velocity: linear, angular
TREND_PUSH = 170  # 6, its acceleration
TREND_JOLT = 176  # 6, and how fast that changes
GAP = 182  # how far the joints were behind the goal when that was looked at last, rad
GIVEN = 183  # 12, the last target as it came: rotation, position
CHANGES = 195  # 18, its first, second and third divided differences: linear, angular
IN_A_ROW = 213  # targets that came one after the other, as far as they count
WINDOW_AT = 214  # which sample of noise is the oldest
WINDOW = 215  # 2 by WINDOWED samples of noise: linear (m^2), angular (rad^2), in their order
SORTED = 279  # the same by their size
NOISE = 343  # 2, standard deviation of the target's noise: linear (m), angular (rad)
SMOOTHED = 345  # time constant of the filter in the last update, seconds
LOOKS = 346  # looks of a search for other postures so far, 0 while there is none
TRIED = 347  # postures no farther than this from the goal have been tried in vain at the present turn, rad
SEEN = 348  # what the search knows: `UNKNOWN`, `RECONFIGURE`, or `NOWHERE` where postures that are near are all tried
CLOSEST = 349  # how close the tip has come to a target that rests, as `MISS`
ASKED = 350  # what a search of the whole redundancy said of a target that rests: `UNKNOWN` if not asked, or `MOVES`
ASK_FROM = 351  # the update from which on that may be asked again
SPACING = 352  # 4, periods between the last targets, the newest first
EVERY = 356  # mean of these when noise was measured last
KEPT = 357  # 6, directions from shoulder to wrist, and across it to the elbow, where that is kept from
WARY = 363  # factor of damping for a goal that comes no closer; 0.0 where it does
STATE = 364

WINDOWED = 32
"""Samples of which the noise of a target is the median."""

KNOTS = 7
"""Postures of a plan."""

SOFT_START = 10.0
"""Accelerations cost as if the largest were at most so many times the largest velocity, 1/s."""

BAND = 14
"""Unknowns of a plan farther apart than this have no term in common."""

# Verdicts on a target that the goal does not reach.
UNKNOWN = 0.0
NOWHERE = 1.0
RECONFIGURE = 2.0
MOVES = -1.0

# The settings.
PERIOD = 0  # seconds between updates
SPEED = 1  # 7, largest joint velocities, rad/s
ACCELERATION = 8  # 7, rad/s^2
SMOOTHING = 15  # time constant of the filter that takes jitter from the target, seconds, or `MEASURED`
ELBOW = 16  # `KEEP`, `ANGLE`, or an objective from `OBJECTIVE` on
ANGLE_WANTED = 17  # rad
PATIENCE = 18  # time constant in which a target that is lost slows down, seconds
HAS_FREE = 19  # 1.0 where the target leaves a turn free
FREE = 20  # 4, that freedom
SETTINGS = 24

MEASURED = -1.0
"""Smoothing by as much as the noise of the target asks for."""

# Elbow policies.
KEEP = -1.0
ANGLE = -2.0

# What an update says.
STEP_Q = 0  # 7
STEP_V = 7  # 7
STEP_A = 14  # 7
STEP_STATUS = 21
STEP_JOINT = 22  # the joint (1 to 7) that is farthest behind; 0: none
STEP_POSITION_ERROR = 23  # metres, from the target given
STEP_ORIENTATION_ERROR = 24  # rad
STEP_REASON = 25
STEP_LOST = 26
STEP = 27

# Statuses, numbered as in `srs_ik.TrackerStatus`.
OK = 0.0
LIMITED = 1.0
HELD = 2.0
UNREACHABLE = 3.0

# Why.
NO_REASON = 0.0
BEHIND = 1.0
LOST_TARGET = 2.0
NO_TARGET_YET = 3.0
BAD_TARGET = 4.0
OTHER_POSTURE = 5.0
OUT_OF_REACH = 6.0
FORBIDDEN = 7.0
ON_THE_WAY = 8.0
