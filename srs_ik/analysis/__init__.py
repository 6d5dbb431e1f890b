"""What a posture can do: ellipsoids, polytopes, gravity."""
