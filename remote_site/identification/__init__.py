"""Identification by five fingers, and the touch packet that it makes.

The site uses `perception`. `finger_touch` is the result for one finger.
"""
