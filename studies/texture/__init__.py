"""Surfaces, roughness and grooves from simulated strokes.

`run` measures and `figure` draws.
"""
