"""Sessions of real processes: how many, and at which rates.

The registry of studies runs `sessions` and `rates`.
"""
