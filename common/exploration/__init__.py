"""Estimators of a hand's motion and its fingers' contact from noisy samples.

Sites use `exploration_mode` and `hand_motion`, which are made of the other modules.
"""
