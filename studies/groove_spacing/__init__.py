"""Spacing of grooves at the operator's finger over networks with jitter and loss."""
