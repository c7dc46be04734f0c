"""Stiffness of recorded presses, and maps of them, against the bars of the recordings' description.

`run` measures and `figure` draws. Modules `map_*` are about maps.
"""
