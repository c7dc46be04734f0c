"""Identification of recorded strokes, off line.

The command line uses `identify_texture`. Calibration uses `stroke_playback`.
"""
