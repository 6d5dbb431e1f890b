"""The machine: files that are written whole, processes that fork, and how much of a file is read."""
