"""Couples the operator's hand to the remote hand: clutch, re-basing and motion scale.

The site uses `motion_coupling`, rendering and replay use `coupling`. This folder imports only `common`.
"""
