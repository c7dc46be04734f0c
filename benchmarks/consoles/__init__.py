"""Cost of consoles and their pages."""
