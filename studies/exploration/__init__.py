"""Exploration modes from noisy motion and force.

The registry runs `exploration_modes`.
"""
