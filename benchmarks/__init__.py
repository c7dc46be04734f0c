"""Measurements of what the product costs and how fast it is, on the machine that runs them."""
