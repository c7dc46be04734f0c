"""The console: shows a session to the people who run it, and records what they find."""
