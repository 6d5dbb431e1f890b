"""Joint angles that follow a moving target."""
