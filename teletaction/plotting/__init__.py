"""Colours, names and margins of all figures.

Reports use both modules, studies the style.
"""
