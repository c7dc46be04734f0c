"""The remote end of the session: requests by the operator and by a person at the patient's side.

The site uses `session_server`.
"""
