"""The operator's end of the session: link, admission, local control, emergency stop.

The site uses `session_client`. Rendering knows only `session_protocol`.
"""
