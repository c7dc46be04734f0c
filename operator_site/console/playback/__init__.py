"""A recording on the console: play, pause and jump.

The console's process uses `player`.
"""
