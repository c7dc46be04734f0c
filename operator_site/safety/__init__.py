"""The gate before motors, Peltier elements and finger forces, and its parts.

The site uses `operator_gate`. This folder imports nothing but `common`.
"""
