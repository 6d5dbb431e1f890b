"""The questions an arm is asked, one a file."""
