"""Targets found on a tactile map.

The registry runs `tactile_map`.
"""
