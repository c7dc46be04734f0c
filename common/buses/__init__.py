"""CAN and serial lines to the devices of a site.

Drivers use `can_port` and `serial_device`. `wiring` opens them; `drive_monitor` compares reports with commands.
"""
