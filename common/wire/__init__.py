"""Packets between the sites and their checks.

Other folders use `messages`, `session_messages` and `streams`. Only `packets` knows MessagePack.
"""
