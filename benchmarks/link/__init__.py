"""Latency and cost of the link beside bare sockets.

`run` measures and `figure` draws.
"""
