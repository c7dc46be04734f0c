"""Runs identification and rendering again on a recording.

The commands use `replay`; the studies use `replay_sites`.
"""
