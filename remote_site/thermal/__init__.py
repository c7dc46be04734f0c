"""Material and temperature of a touched object, and the heater of a free sensor.

Others use `finger_thermal`, `thermal_identification` and `thermal_result`. `material_table` is what calibration
finds.
"""
