"""Stability over a delayed link: five architectures compared.

`run` measures and `figure` draws.
"""
