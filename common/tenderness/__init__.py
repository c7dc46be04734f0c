"""Tenderness: presses with the patient's answers, reaction time, and the most tender place.

The remote site uses `presses` and `reaction` for its force limit. The study of tenderness also uses `tender_place`.
"""
