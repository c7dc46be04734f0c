"""Temperature at the operator's finger: models, plates, strategies.

The registry runs `thermal_rendering`.
"""
