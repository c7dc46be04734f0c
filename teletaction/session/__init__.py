"""A session on this machine: files, processes, rates, and its end.

The commands use `demo` and `conclude`.
"""
