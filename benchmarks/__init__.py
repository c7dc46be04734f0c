"""Measurements of the product's cost and speed on the machine that runs them."""
