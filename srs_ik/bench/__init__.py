"""How long the package takes on this machine: single calls, batches, memory, start. `srs-ik bench` prints it."""
