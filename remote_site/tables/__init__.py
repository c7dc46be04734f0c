"""Calibrated tables as JSON files, and the code that reads and writes them.

Tables of each kind use `table_file`.
"""
