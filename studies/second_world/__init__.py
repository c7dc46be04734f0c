"""A second world for thermal touches: other sensors, other objects, and another structure than the estimator's.

`ranges` has all parameters and their sources. `run` judges the shipped identification in it, and `figure` draws.
"""
