"""Perceptual deadband of packets: packets against error."""
