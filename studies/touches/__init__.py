"""Simulated fingers on real, virtual and remote objects.

Studies of thermal display and of the paper use them.
"""
