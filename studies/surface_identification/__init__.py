"""Stiffness and height of a pressed surface."""
