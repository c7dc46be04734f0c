"""Provides the command line and the launcher that runs a whole session on one machine."""
