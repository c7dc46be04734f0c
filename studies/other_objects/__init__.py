"""Objects unlike those of calibration: warmer, colder, or thin.

`run` measures and `figure` draws. The touches are those of `studies.second_world`.
"""
