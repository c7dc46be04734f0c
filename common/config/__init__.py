"""Configurations of all processes: their models, and reading and writing their files.

Others use `models` and `file`.
"""
