"""What a tick of each process costs, measured in lock step."""
