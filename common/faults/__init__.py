"""Faults and reasons as codes with numbers, and the texts that people read.

All folders may use `fault`. Code that shows a fault to people uses `texts`.
"""
