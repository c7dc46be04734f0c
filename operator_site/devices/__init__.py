"""Drivers of the exoskeleton and the fingertip modules, with the checks of what they measure.

The site uses `devices` alone. Drivers know no gate.
"""
