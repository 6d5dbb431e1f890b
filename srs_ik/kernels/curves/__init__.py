"""All configurations of a pose on the true chain, as curves that are followed."""
