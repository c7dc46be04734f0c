"""Computes the force on a finger that presses on a model of the remote surface.

Rendering uses `passive_contact`. `loop_stiffness` limits the displayed stiffness of a slow loop.
"""
