"""The source paper: its numerical optimisation as printed, and its experiments."""
