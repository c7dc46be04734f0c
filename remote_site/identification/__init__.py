"""Identification by five fingers, and the touch packet with its result.

The site uses `perception` and, for the result of one finger, `finger_identification`.
"""
