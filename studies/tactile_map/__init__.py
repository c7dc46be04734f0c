"""Targets found on a tactile map."""
