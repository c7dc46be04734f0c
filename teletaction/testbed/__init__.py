"""A whole session in one process: no tick is ever late, whatever the machine does.

`testbed` runs it in memory on a virtual clock, the same for the same seed. `lockstep` runs it on a virtual clock over
real lines, buses and link, for measuring what a tick costs.
"""
