"""Colours, names and margins of all figures.

Reports and studies use both modules.
"""
