"""Targets found on a tactile map.

`run` measures and `figure` draws.
"""
