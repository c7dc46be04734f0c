"""Pages and what they may do: server, access, places, commands.

The console's process uses `server` and `pages`.
"""
