"""A second world for thermal touches: other sensors, other objects, and another structure than the estimator's.

`ranges` has its parameters and their sources. `run` judges the shipped identification in it and in the first world.
"""
