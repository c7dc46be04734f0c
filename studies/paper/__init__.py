"""Experiments and figures of Kron & Schmidt 2003 again.

The registry runs `observer` and `paper_figures`.
"""
