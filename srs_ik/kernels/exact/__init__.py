"""The whole redundancy of an exact limb in closed form: intervals, nearest and farthest postures."""
