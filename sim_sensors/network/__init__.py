"""A simulated network between the sites.

The command line uses `proxy` and `file`, the test bed `path` and `stream`.
"""
