"""Joint paths through poses that leave a turn free."""
