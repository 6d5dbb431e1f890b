"""Questions to a near limb."""
