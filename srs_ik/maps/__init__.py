"""Capability maps: which poses an arm reaches and how well; and where to put its base."""
