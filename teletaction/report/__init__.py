"""Writes the report of a session, with its figures and pages.

The commands use `report` and `session_report`.
"""
