"""Recordings of a session: merged, recovered, read as arrays, summarised.

Others use `session_data` and `summary`.
"""
