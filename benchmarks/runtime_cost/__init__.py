"""Cost of a tick of each process, in lock step."""
