"""A cell of a map: the row of its measures, and what is asked of it."""

CELL_BRANCHES = 0  # bit b is set where branch b has a feasible arm angle
CELL_PIECES = 1  # feasible intervals of arm angles, all branches together
CELL_WIDTH = 2  # sum of their widths, rad
CELL_WIDEST = 3  # width of the widest, rad
CELL_MARGIN = 4  # margin to the limits of the posture farthest from them; 0 where it is not asked for
CELL_ARCS = 5  # arcs of yaw, each a start in [-pi, pi) and a width, rad; width 0: no arc

MOST_ARCS = 16
"""Arcs of yaw that a cell may have: a joint 1 with a range of 0.4 rad or more leaves no more."""

NOT_REACHED = 0
REACHED = 1
UNSURE = 2
"""Answers for a pose; minus a verdict for one that is none. Where it is unsure, the search for a posture tells."""
