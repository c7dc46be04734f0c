"""The newest state of site, fingers and devices, as the console knows it.

The console's model and its alarms use it.
"""
