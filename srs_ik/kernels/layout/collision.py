"""What kernels know of bodies: rows of spheres or planes, groups of rows, and pairs of groups that may meet.

All rows are in the base frame, at the zero configuration of the arm. The first rows, one a group, are balls around the
groups; the rows of the groups follow.
"""

# A row of bodies: a sphere, or a plane whose normal points out of a solid.
CENTRE = 0  # 3
RADIUS = 3
NORMAL = 0  # 3
OFFSET = 3  # the solid lies where normal . x is at most this
BODY_ROW = 4

# A group: rows of one link, or of one part of an object.
FIRST = 0
LAST = 1  # one behind the last row
PLACE = 2
KIND = 3
BODY = 4  # which body it is a part of
GROUP = 5

# Places: what moves a group.
BASE = 0  # nothing
TIP = 1  # the pose
UPPER = 2  # the arm angle, with the upper arm
FORE = 3  # the arm angle, with the forearm

# Kinds.
SPHERES = 0
PLANES = 1  # a convex solid, at the base, the second of its pairs

# The same rows seen from the line S-W: coordinate along it, two across it, distance from it, and radius or offset.
U = 0
X = 1
Y = 2
RHO = 3
EXTENT = 4
LOCAL_ROW = 5

MOST_ARCS = 128
"""Room for the forbidden arcs of one elbow; beyond, those with the least gap between them are joined."""

# What an entry is told of nearness: margin, drift of a near limb's links.
MARGIN = 0
DRIFT = 1  # how far links of a near limb are from those of its nearest exact limb at the same joint angles, m; at most
REACH_UPPER = 2  # largest distance of a row of the upper arm from the shoulder centre
REACH_FORE = 3  # and of a row of the forearm from the elbow centre
SLACK = 4

# The arm angle of largest clearance.
WIDE_ARM_ANGLE = 0
WIDE_BRANCH = 1
WIDE_CLEARANCE = 2
WIDE_FIRST = 3  # the two groups that are nearest there
WIDE_SECOND = 4
WIDE = 5

NO_GROUP = -1

NOTHING_FREE = -1.0
"""Status in a row of a pose of which nothing is free: whoever asked looks into why."""

# A straight line of joint angles that does not keep clear.
EDGE_AT = 0  # where on it, 0 to 1
EDGE_PAIR = 1  # row of pairs, -1 where it is clear
EDGE_CLEARANCE = 2  # of that pair there, m
EDGE = 3
