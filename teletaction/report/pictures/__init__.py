"""The camera's picture at each finding of a report, and what covers it on request.

A report uses `stills` and `covered`.
"""
