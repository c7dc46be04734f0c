"""The console: what a session shows to the people who run it, and what they found."""
