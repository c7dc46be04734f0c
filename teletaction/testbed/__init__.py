"""Run a whole session in one process on a virtual clock, so that no tick is ever late.

`testbed` runs it in memory; the same seed gives the same session. `lockstep` runs it over real lines, buses and link,
to measure the cost of a tick.
"""
