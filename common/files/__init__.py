"""Reads and writes small files, and makes text printable.

Each module stands alone.
"""
