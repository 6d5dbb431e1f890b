"""What kernels know of real shapes: convex solids, the bodies that consist of them, and pairs of bodies.

Solids are in the base frame, at the zero configuration of the arm, like the spheres of `layout.collision`.
"""

# A solid: a ball around it, and what it is. Points are the corners of their convex hull, grown by a radius all around;
# a cylinder has an axis from its centre, half a length and a radius. A half-space lies behind a point, seen along an
# axis that points out of it; it stands still, and is the second of its pairs.
CENTRE = 0  # 3
BALL = 3
AXIS = 4  # 3
HALF = 7
RADIUS = 8
INNER = 9  # radius of a capsule within the solid, about its centre; negative for none
SEGMENT = 10  # 3, from the centre to one end of the capsule's segment
SOLID = 13

# The same, integers.
KIND = 0
FIRST = 1  # of its points
LAST = 2  # one behind the last
IS_WHOLE = 3  # whether the shape is this solid, and not only within it
OF_SOLID = 4

POINTS = 0
CYLINDER = 1
HALF_SPACE = 2

# A body, integers.
FIRST_SOLID = 0
LAST_SOLID = 1  # one behind the last
JOINT = 2  # that carries it; 0 for what stands still
PLACE = 3  # what moves it, as `layout.collision` has it, where its spin does not show
SPINS = 4  # whether it does
OF_BODY = 5

# A body: distances that no posture changes, m.
SPIN = 0  # from the axis that it spins about against what moves it
BEFORE = 1  # from the axis of the joint that carries it
BEHIND = 2  # from the axis of the next joint
AROUND = 3  # from the centre on the line S-W that is next to it
SHAPED = 4

# A pair of bodies.
ONE = 0
OTHER = 1
WATCHED = 2  # of the pairs that spheres watch, or RANGED
PAIR = 3

RANGED = -1
"""No spheres watch this pair, but the range of a joint: what that leaves is looked at."""

# The outer ones of the three axes of shoulder (row 0) and wrist (row 1).
FIXED = 0  # the cosine of the angle between them is this,
COSINE = 1  # and this times the cosine of the angle of the joint between them,
SINE = 2  # and this times its sine
TO_FIRST = 3  # cosine of the angle from the first axis to the middle one
TO_LAST = 4
OUTER = 5

# What is left of a pair, for whoever knows the shapes themselves.
REST_PAIR = 0
REST_BRANCH = 1  # or -1 and -2 for the two elbows, of pairs that do not spin
REST_LOWER = 2
REST_UPPER = 3
REST = 4

MOST_WAITING = 96
"""Room for the parts of an arc that wait to be looked at."""

MOST_SPINS = 16
"""Room for the pieces of a set of spins; beyond, those with the least gap between them are joined."""
