"""Perceptual deadband of packets: packets against error.

`run` measures and `figure` draws.
"""
