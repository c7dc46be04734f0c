"""Exploration modes from noisy motion and force."""
