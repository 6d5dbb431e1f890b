"""A moving target: where the joints go in the next period."""
