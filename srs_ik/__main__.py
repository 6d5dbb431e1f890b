"""`python -m srs_ik`: the command line."""

from srs_ik.cli import main

main()
