"""Simulated patients with a tender place.

`run` measures, `patients` simulates, `examiner` presses, and `figure` draws.
"""
