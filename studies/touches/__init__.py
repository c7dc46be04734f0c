"""Simulated fingers that touch and stroke real, virtual and remote objects.

Several studies use them.
"""
