"""Runs a session on this machine: files, processes, rates, summary and report.

The commands use `demo` and `conclude`.
"""
