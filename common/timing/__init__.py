"""Timeouts of both sites, standstills of the host, and the safe state of each actuator.

All folders may use `timeouts`. `standstill` and `tick_age` check the time of one process.
"""
