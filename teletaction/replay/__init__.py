"""Identification and rendering again from a recording.

The commands use `replay`, the studies `replay_sites`.
"""
