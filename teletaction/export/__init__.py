"""Exports a recording in formats that other tools read: named fields with units, and wall-clock times.

Commands use `export`, which lists the formats. `named_messages` gives the same content to Python programs.
"""
