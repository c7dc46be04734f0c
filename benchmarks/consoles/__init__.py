"""Cost of consoles and their pages.

`run` measures and `figure` draws.
"""
