"""Whether poses are reached and how well: the early answer, the arcs of yaw, and the measures of a map's cells."""
