"""Latency and cost of the link beside bare sockets.

The registry of studies runs `link`.
"""
