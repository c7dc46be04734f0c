"""Plays a recording on the console, with pause and jumps.

The console's process uses `player`.
"""
