"""Number of sessions that one machine carries.

`run` measures and `figure` draws.
"""
