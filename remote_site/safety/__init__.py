"""The gate before the telemanipulator and the heaters, and its parts.

The site uses `patient_gate`. This folder imports only `common`.
"""
