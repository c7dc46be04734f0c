"""Scenes, the script of a hand, and constants of materials and surfaces.

Simulators, virtual environments and studies use `scene`, `materials` and `surfaces`.
"""
