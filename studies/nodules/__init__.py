"""Simulated nodules: random phantoms, presses on them, and a reference detector that knows how they are drawn.

`ranges` was fixed before any detector was judged. `judge` takes any detector.
"""
