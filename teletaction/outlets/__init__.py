"""Offers a running session to live tools: Foxglove, Rerun, and LSL. Fed as a console is, never by a site's loop.

Commands use `outlet`.
"""
