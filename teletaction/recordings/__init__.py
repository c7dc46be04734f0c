"""Merges, recovers, reads and summarises the recordings of a session.

Other folders use `session_data` and `summary`.
"""
