"""A whole session in one process and in lock step: no tick is ever late, whatever the machine does.

`lockstep` has both sites, `devices` what they read and write. Real are lines, buses, link and recordings; virtual is
time.
"""
