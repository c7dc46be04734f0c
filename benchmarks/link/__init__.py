"""Latency and cost of the link beside bare sockets."""
