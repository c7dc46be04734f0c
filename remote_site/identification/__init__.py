"""Identification by five fingers, and the touch packet with its result.

The site uses `perception`. `finger_touch` holds the result for one finger.
"""
