"""Checks that both gates use: thermal dose, oscillation, repeated faults.

Only gates use them. They import nothing but limits and timeouts.
"""
