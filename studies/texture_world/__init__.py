"""A hundred textures of the world, rendered from public haptic models."""
