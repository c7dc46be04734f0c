"""Drivers of the telemanipulator and the sensors, with the checks of their measurements.

The site uses only `devices`. Drivers import nothing of a gate.
"""
