"""Material and temperature from a touch: speed, accuracy, cost and limits.

`run` measures and `figure` draws.
"""
