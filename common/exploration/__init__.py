"""Motion of a hand and contact of its fingers, from noisy samples.

Sites use `exploration_mode` and `hand_motion`. The others are estimators that these are made of.
"""
