"""Makes the tactile map of recorded presses, strokes and rests off line.

`map_recorded` reads the files; `write_map` writes CSV, JSON and a figure.
"""
