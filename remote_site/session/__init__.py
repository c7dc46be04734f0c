"""The remote end of the session: requests of the operator and of a person at the patient's side.

The site uses `session_server`.
"""
