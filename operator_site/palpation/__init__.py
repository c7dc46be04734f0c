"""Finds lumps by stiffness: a field over measured places, lump probabilities, nodules, and the next press.

Pure functions of numbers in m and ln N/m. The console's map and `teletaction map` use them.
"""
