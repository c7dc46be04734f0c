"""Number of sessions that one machine carries."""
