"""Serves the pages: server, access, places and commands.

The console's process uses `server` and `pages`.
"""
