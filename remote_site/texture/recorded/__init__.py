"""Off-line identification of recorded strokes.

The command line uses `identify_texture`. Calibration uses `stroke_playback`.
"""
