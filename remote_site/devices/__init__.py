"""Drivers of the telemanipulator and the sensors, with the checks of what they measure.

The site uses `devices` alone. Drivers know no gate.
"""
