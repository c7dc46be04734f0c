"""Simulated devices that speak the real bytes, and the physical world they stand in."""
