"""Runs the operator site on a virtual environment instead of a remote site.

The command line uses `virtual_site`.
"""
