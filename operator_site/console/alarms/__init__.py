"""Holds the alarms and the rules that raise them.

The console's model uses both.
"""
