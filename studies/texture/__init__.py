"""Surfaces, roughness and grooves from simulated strokes."""
