"""Tenderness of the examined person: presses with and without pain, and the most tender place.

It follows touch packets and pain answers, live and from a recording.
"""
