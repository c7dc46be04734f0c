"""Checks before a session: devices, keys, tables, scenes.

The commands use both modules.
"""
