"""Groove periods and fabrics from recorded strokes."""
