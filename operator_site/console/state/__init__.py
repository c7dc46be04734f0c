"""Keeps the newest state of site, fingers and devices for the console.

The console's model and its alarms use it.
"""
