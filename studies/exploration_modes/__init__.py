"""Exploration modes from noisy motion and force.

`run` measures and `figure` draws.
"""
