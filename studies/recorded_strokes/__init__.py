"""Groove periods and fabrics from recorded strokes.

`run` measures and `figure` draws.
"""
