"""Builds the tactile map: samples, layers and tiles.

The console uses `tactile_map`, the page receives `map_tiles`.
"""
