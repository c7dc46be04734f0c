"""Runs the console, which shows a session to its users and records what they find."""
