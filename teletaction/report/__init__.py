"""The report of a session, its figures and pages.

The commands use `report` and `session_report`.
"""
