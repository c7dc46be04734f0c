"""Runs the operator's end of the session: link, admission, local control and emergency stop.

The site uses `session_client`. Rendering imports only `session_protocol`.
"""
