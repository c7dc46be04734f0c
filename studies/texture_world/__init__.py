"""A hundred textures of the world, rendered from public haptic models.

`run` measures and `figure` draws.
"""
