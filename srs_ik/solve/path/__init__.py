"""Joint angles along a path of poses."""
