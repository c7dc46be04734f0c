"""Material and temperature from a touch: speed, accuracy, limits.

The registry runs `thermal_identification` and `recorded_touches`.
"""
