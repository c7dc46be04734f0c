"""Serves web pages of a process: access by tokens, bounded connections, guarded files and websockets.

A process makes a `GuardedPage` and runs it with `serve_page`. All of it needs the extra `console`.
"""
