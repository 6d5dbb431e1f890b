"""Questions to an arm in a scene: free intervals come from one place, and every question takes them from there."""
