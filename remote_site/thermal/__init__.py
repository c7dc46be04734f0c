"""Material and temperature of a touched object, and the heater of a free sensor.

Other folders use `finger_thermal`, `thermal_identification` and `thermal_result`. `material_table` holds the results
of calibration.
"""
