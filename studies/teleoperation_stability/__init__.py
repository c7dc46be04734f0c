"""Stability over a delayed link: five architectures compared."""
