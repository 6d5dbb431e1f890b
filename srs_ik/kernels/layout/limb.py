"""Layout of the packed limb: one flat array of floats, so that a call from Python passes one argument.

`srs_ik.solve.packed` fills it. Shoulder and wrist are described by the same block, at `SHOULDER` and at `WRIST`,
because the same functions solve both.
"""

# The true chain: seven lines and the tip at zero.
AXES = 0  # 7 x 3 unit directions
POINTS = 21  # 7 x 3 points on the axes
TIP_ROTATION = 42  # 3 x 3
TIP_POSITION = 51  # 3
IS_CLOSED = 54  # 1.0 if the axes pass their centres up to rounding, so that the closed form is the answer

# Joint limits, written by `limits.set_limits`.
LOWER = 55  # 7
UPPER = 62  # 7
MIDDLE = 69  # 7, zero where unlimited
INVERSE_HALF_RANGE = 76  # 7, zero where unlimited
RANGE_KIND = 83  # 7: 0 a full turn or more, 1 at most half a turn, 2 between
COS_LOWER = 90  # 7
SIN_LOWER = 97  # 7
COS_UPPER = 104  # 7
SIN_UPPER = 111  # 7

# Tolerances; the loose set is for poses whose only postures lie within rounding of a singularity or a limit.
SLACK_SINGULAR = 118  # sine of the angle between axes 1 and 3 of a spherical joint under which they count as parallel
SLACK_REACH = 119  # how far R a3 may lie outside the reach of oblique axes, rad
SLACK_LIMIT = 120  # how far an angle may lie outside a limit to be put on it, rad
SLACK_JOIN = 121  # gap that two intervals may leave where they should touch, rad; wide where it is known only nearly

# Centres and the arm-angle reference, base frame.
SHOULDER_CENTRE = 122  # 3
WRIST_IN_TIP = 125  # 3
ELBOW_CENTRE = 128  # 3
REFERENCE = 131  # 3 unit vector
REFERENCE_2 = 134  # 3 unit vector perpendicular to it, where S-W is parallel to the reference

# Elbow triangle, with the limb straightened: |S-W|^2 = FAR^2 + (FAR^2 - NEAR^2) / 2 (cos x - 1), x = q4 - STRAIGHT.
STRAIGHT = 137  # the q4 at which S-W is longest
COS_STRAIGHT = 138
SIN_STRAIGHT = 139
FAR = 140  # longest S-W
NEAR = 141  # shortest S-W
UPPER_ARM = 142  # 3, S to E
FOREARM = 145  # 3, E to W at q4 = STRAIGHT
NORMAL_0 = 148  # 3, E-S x W-S = NORMAL_0 + sin x NORMAL_S + (1 - cos x) NORMAL_C
NORMAL_S = 151
NORMAL_C = 154
NORMAL_KIND = 157  # 0 planar, 1 oblique but collinear when straight, 2 general

# A spherical joint: R = rot(a1, q1) rot(a2, q2) rot(a3, q3). Offsets within the block.
A1 = 0  # 3
A2 = 3  # 3
A3 = 6  # 3
ACROSS_3 = 9  # 3 unit vector perpendicular to a3
CROSS_3 = 12  # 3, a3 x ACROSS_3
PHASE = 15  # q2 at which a1' R a3 is largest
COS_PHASE = 16
SIN_PHASE = 17
TOP_GAP = 18  # 1 - largest a1' R a3
BOTTOM_GAP = 19  # 1 + smallest a1' R a3
ANCHOR_1 = 20  # where joints 1 and 3 like to be when only their sum or difference matters
ANCHOR_3 = 21
SHARE_1 = 22  # the part that joint 1 takes of such a sum
A1_A2 = 23  # a1' a2
A2_A3 = 24  # a2' a3
CROSS_23 = 25  # 3, a2 x a3
FIRST_JOINT = 28  # 0 or 4
# Limits as linear forms in R: x' R y has a known value on the bound.
BOUND_1_LOWER = 29  # x = rot(a1, lower) a2; y = a3, value A2_A3
BOUND_1_UPPER = 32
BOUND_2_LOWER = 35  # the value of a1' R a3
BOUND_2_UPPER = 36
BOUND_3_LOWER = 37  # y = rot(a3, -lower) a2; x = a1, value A1_A2
BOUND_3_UPPER = 40
BLOCK = 43

SHOULDER = 158
WRIST = SHOULDER + BLOCK
MISS = WRIST + BLOCK  # largest distance of an axis from its centre, of the true chain
SHIFT = MISS + 1  # how far its joint directions are from those of the closed form, rad, elbow at a right angle
BAND = SHIFT + 1  # how far limits of joints 1, 3, 5 and 7 are drawn out, rad; drawn in: negative
# How far the true chain is from the closed form, rad: at most so much, and so much more over the sine of the bend.
# Joints 1, 3, 5 and 7 times the sine of the middle angle between them; joint 4 times the sine of the bend: its cosine.
BANDS = BAND + 1  # 7 times both
COSINE_OFF = BANDS + 14  # how far the cosine of the bend is off at a straight elbow, or a folded one
IS_NEAR = COSINE_OFF + 1  # 1.0 if answers are looked for on the true chain, 0.0 if those of the closed form are taken
SIZE = IS_NEAR + 1

# How far a configuration is from the closed form, rad: the same of each joint; zero where they are not told.
SHIFT_COSINE = 7  # cosine of the elbow's bend
SHIFT_CLOSED = 8  # cosine of the bend of the closed form
SHIFT_BEND = 9  # sine of it; 0 where the differences of joints are not told
SHIFTS = 10

WELL_CLEAR = 1.25
"""The elbow's cosine is farther from straight and folded than it is off there, by this factor; else it may be so."""

# A family of packed limbs (4, SIZE): with limits, without, and both again with the loose tolerances.
LIMITED = 0
FREE = 1
LOOSE = 2
FAMILY = 4

SMALLEST_RANGE = 1e-9
"""A joint with a smaller range, rad, counts as one with this range where margins are compared."""
